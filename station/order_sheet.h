#pragma once

#include "base/result.h"
#include "station/glasses_export.h"
#include "station/glasses_source.h"

namespace annulus {

/// The order of a pair of glasses as a PDF of A4 pages: reference, frame and size, prescription of both eyes, lens
/// data, position as worn, the fitter's goals with 95 % intervals, and a line to sign. Without options.confirmed_by it
/// says "NOT CONFIRMED – estimate" and asks for an optician. The same source gives the same bytes. Fails if the lenses
/// cannot be made, and as SheetCanvas::Finish.
[[nodiscard]] Result<ExportedFile> OrderSheet(const GlassesSource& source, const GlassesExportOptions& options);

}  // namespace annulus
