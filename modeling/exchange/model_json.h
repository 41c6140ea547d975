#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "fitting/surface_model.h"

namespace annulus {

/// MODEL.json: the model as one self-sufficient JSON object (docs/formats.md). The same model gives the same bytes;
/// numbers read back to the same bits.
[[nodiscard]] std::string ModelToJson(const SurfaceModel& model);

/// Reads MODEL.json. `name` of the file is for messages. Sizes are checked against each other before anything is made
/// of them, numbers must be finite; a newer version is refused, unknown keys are skipped.
[[nodiscard]] Result<SurfaceModel> ModelFromJson(std::string_view json, std::string_view name);

}  // namespace annulus
