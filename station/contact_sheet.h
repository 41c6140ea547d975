#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "render/image.h"

namespace annulus {

/// A picture of a contact sheet.
struct ContactTile {
  RgbImage image;
  std::string caption;  ///< One line below it, ASCII; cut where it is wider than the picture.
};

struct ContactSheetOptions {
  int columns = 3;    ///< 1 … 64; the last row may be shorter.
  std::string title;  ///< Above all; none if empty.
};

/// Pictures side by side on a white sheet, row by row, each in a cell as large as the largest of them, with its caption
/// centred below. The pictures' pixels are kept. Fails on no tile, a picture without pixels, columns out of range, or a
/// sheet larger than kMaxImageSize.
[[nodiscard]] Result<RgbImage> ContactSheet(const std::vector<ContactTile>& tiles, const ContactSheetOptions& options);

}  // namespace annulus
