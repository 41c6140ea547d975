#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/flatten/pattern_drawing.h"
#include "render/image.h"

namespace annulus {

/// The pieces at 1:1 on A4 pages: a first page with a 100 mm check square and a plan of the pages, then tiles of 180 ×
/// 260 mm with registration marks at their corners, named by column and row. Tiles on which nothing is drawn are left
/// out. Fails over 400 pages, and as SheetCanvas::Finish.
[[nodiscard]] Result<std::vector<std::byte>> PatternPdf(const std::vector<DrawnPiece>& pieces,
                                                        const std::string& title);

/// The strain of the pieces: the principal strain of greater amount in every triangle, red where the flat piece is
/// longer than the body, blue where it is shorter, with a legend. Fails as Figure::ToImage.
[[nodiscard]] Result<RgbImage> StrainPicture(const FlatPattern& flat);

}  // namespace annulus
