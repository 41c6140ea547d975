#pragma once

#include <vector>

#include "fitting/surface_model.h"
#include "modeling/measure/table.h"
#include "station/sheet_canvas.h"
#include "station/sheet_words.h"

namespace annulus {

/// A measurement with the number that it has on the sheet.
struct NumberedMeasurement {
  int number = 0;  ///< 0 where it is not drawn.
  const Measurement* measurement = nullptr;
};

/// Whether the sheet's pictures show it: it has a path, and no other measurement before it has the same.
[[nodiscard]] bool IsDrawn(const MeasurementTable& table, const Measurement& measurement);

/// A colour per group, for numbers and tapes alike.
[[nodiscard]] SheetColour ColourOf(SheetGroup group);

/// A rectangle of the sheet, mm.
struct SheetBox {
  Eigen::Vector2d corner;
  Eigen::Vector2d size;
};

/// Draws the body from the front, the right side and the back at one scale, side by side in `box`, with the paths of
/// all numbered measurements and their numbers. A path's number stands in the view that shows most of it. Draws only
/// the views' titles if nothing of the model is known.
void DrawBodyFigures(SheetCanvas& canvas, const SheetBox& box, const SurfaceModel& model,
                     const std::vector<NumberedMeasurement>& measurements, SheetLanguage language);

}  // namespace annulus
