#pragma once

#include "base/result.h"
#include "station/glasses_export.h"
#include "station/glasses_source.h"

namespace annulus {

/// The drawing of a frame as a PDF: two A4 pages in landscape, 1:1, third angle. Front with boxes, DBL and pupils, side
/// of the right temple, view from above, shape of the lens with box and effective diameter, dimensions in mm, and a bar
/// of 50 mm to check the print with. Lines are those of the frame's own geometry, hidden ones left out. The same source
/// gives the same bytes. Fails as SheetCanvas::Finish.
[[nodiscard]] Result<ExportedFile> GlassesDrawing(const GlassesSource& source, const GlassesExportOptions& options);

}  // namespace annulus
