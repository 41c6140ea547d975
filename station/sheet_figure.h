#pragma once

#include <vector>

#include "fitting/surface_model.h"
#include "modeling/table/table.h"
#include "station/sheet_canvas.h"
#include "station/sheet_words.h"

namespace annulus {

/// A measurement with the number that it has on the sheet. Measurements on the same path share a
/// number, and so do a section's tape and skin.
struct NumberedMeasurement {
  int number = 0;  ///< 0 where it is not drawn.
  const Measurement* measurement = nullptr;
};

/// The table in the sheet's order of groups, numbered from 1 where the pictures show a measurement: where it has a path
/// and is no height (its level shows in a girth or a point).
[[nodiscard]] std::vector<NumberedMeasurement> NumberForSheet(const MeasurementTable& table);

/// A colour per group, for numbers and tapes alike.
[[nodiscard]] SheetColour ColourOf(SheetGroup group);

/// A rectangle of the sheet, mm.
struct SheetBox {
  Eigen::Vector2d corner;
  Eigen::Vector2d size;
};

/// Draws the body from the front, the right side and the back at one scale, side by side in `box`, with the paths of
/// all numbered measurements and their numbers. A path's number stands in the view that shows most of it. Returns
/// the height that was used, mm: 0 and no drawing if nothing of the model is known.
double DrawBodyFigures(SheetCanvas& canvas, const SheetBox& box, const SurfaceModel& model,
                       const std::vector<NumberedMeasurement>& measurements, SheetLanguage language);

}  // namespace annulus
