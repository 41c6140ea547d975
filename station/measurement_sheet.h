#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/storage.h"
#include "fitting/surface_model.h"
#include "modeling/table/table.h"
#include "station/sheet_words.h"
#include "station/units_text.h"

namespace annulus {

/// How the customer reads the sheet.
struct SheetOptions {
  SheetLanguage language = SheetLanguage::kEnglish;
  LengthUnit unit = LengthUnit::kMillimetre;
  std::string subject;  ///< Shown as it is; "" leaves the line out.
};

/// The sheet for the customer as a PDF of A4 pages: pictures of where each tape lies, drawn from the model, and the
/// table with 95 % intervals, shares seen and class limits; the recording's hash says which scan it is of. The same
/// input gives the same bytes. Fails if a letter of the language has no font on this machine.
[[nodiscard]] Result<std::vector<std::byte>> MeasurementSheet(const MeasurementTable& table, const SurfaceModel& model,
                                                              const SheetOptions& options);

/// MeasurementSheet into a file, atomically.
Status WriteMeasurementSheet(Storage& storage, const std::string& path, const MeasurementTable& table,
                             const SurfaceModel& model, const SheetOptions& options);

}  // namespace annulus
