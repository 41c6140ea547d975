#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/render_options.h"

namespace annulus {

/// A sheet on which the pictures of a batch are put side by side.
struct BatchSheet {
  std::string out;  ///< PNG; empty: no sheet.
  int columns = 3;  ///< 1 … 20.
  std::string title;
};

/// A batch file: many pictures of one process.
struct RenderBatch {
  std::vector<RenderRequest> pictures;
  BatchSheet sheet;
  std::string key_file;  ///< Of encrypted recordings; not in the file.
};

/// {"defaults": {…}, "pictures": [{…}, …], "sheet": {"out", "columns", "title"}}: each picture has the options of
/// `annulus render` as keys, without dashes in front and with "_" for "-" inside; what is absent is that of "defaults".
/// A picture without "out" is for the sheet only. `name` of the file is for messages, which name the picture. Fails on
/// anything else.
[[nodiscard]] Result<RenderBatch> RenderBatchFromJson(std::string_view json, std::string_view name);

}  // namespace annulus
