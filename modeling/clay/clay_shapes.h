#pragma once

#include <cstddef>

#include "modeling/bezier/patch_shell.h"

namespace annulus {

/// The plane of paper 004 §4 (z = 0, −3 <= x, y <= 3) as the top of a closed block: `count` × `count` patches on top
/// and bottom, `count` × `layers` on each side. The numbering begins with the top, row by row along y: patch j·count +
/// i holds the i-th cell along x. `size` mm wide, `height` mm deep; all edges straight. Requires counts >= 1, sizes >
/// 0.
[[nodiscard]] PatchShell ClayBlock(double size = 6.0, double height = 3.0, std::size_t count = 6,
                                   std::size_t layers = 3);

}  // namespace annulus
