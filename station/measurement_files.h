#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/storage.h"
#include "fitting/surface_model.h"
#include "modeling/table/table.h"
#include "station/measurement_sheet.h"

namespace annulus {

/// The files that a table of measurements can be written to.
enum class MeasurementFormat {
  kJson,        ///< `.json`
  kCsv,         ///< `.csv`
  kSeamly,      ///< `.smis`
  kValentina,   ///< `.vit`
  kFreeSewing,  ///< `.freesewing.json`
  kSheet,       ///< `.pdf`
};

/// The format by the ending of `path`; fails on any other ending, naming those that there are.
[[nodiscard]] Result<MeasurementFormat> MeasurementFormatOf(std::string_view path);

/// What is written: a table and the model that it was measured on.
struct MeasuredModel {
  const MeasurementTable& table;
  const SurfaceModel& model;
};

/// Writes the table to `path` atomically, in the format of its ending. `options` are the sheet's; every other file is
/// in millimetres and English. Returns what the format could not hold, one sentence each.
[[nodiscard]] Result<std::vector<std::string>> WriteMeasurements(Storage& storage, const std::string& path,
                                                                 const MeasuredModel& measured,
                                                                 const SheetOptions& options);

}  // namespace annulus
