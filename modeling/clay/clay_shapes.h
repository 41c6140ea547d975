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

/// The Utah teapot (Newell 1975), z up, 3.15 high, made of its profiles: a closed pot with lid and bottom, in which the
/// gap of 0.1 between lid and rim is bridged by a ring, a closed handle and a closed spout. Handle and spout begin
/// inside the pot's skin, so that a volume, which is signed, counts what lies in both twice. Patches 0 … 27 are the
/// pot's, four in each row from the lid's knob down; 28 … 33 the handle's, its two caps last; 34 … 39 the spout's.
[[nodiscard]] PatchShell UtahTeapot(double scale = 1.0);

}  // namespace annulus
