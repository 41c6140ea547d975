#pragma once

#include <cstdint>
#include <string_view>

#include "base/result.h"
#include "modeling/wrinkly/control_mesh.h"

namespace annulus {

// Control meshes of paper 003, figs. 11–13, flat in the plane z = 0 and seen from +z but for tubes, heights 0. Each
// fails on counts out of range.

/// A regular net of columns × rows points, `spacing` mm apart: u along x, v along y. With cyclic columns it is a tube
/// about the z axis, with both cyclic a torus about it.
struct RegularNet {
  int columns = 8;
  int rows = 8;
  AxisKind columns_kind = AxisKind::kOpen;
  AxisKind rows_kind = AxisKind::kOpen;
  double spacing = 10.0;
};
[[nodiscard]] Result<ControlMeshParts> MakeNet(const RegularNet& net);

/// A regular net with a border of temporary points (fig. 11 a): columns × rows patches and one point more all around.
[[nodiscard]] Result<ControlMeshParts> MakeBorderedNet(const RegularNet& net);

/// N 方向ネット (figs. 12 b, 13): around a cell of 2N points lie 2N sectors of rings × rings patches, so that axes
/// cross in N directions. N = 2 is a regular net.
struct DirectionsNet {
  int directions = 3;  ///< 2 … 12
  int rings = 5;
  double spacing = 10.0;
};
[[nodiscard]] Result<ControlMeshParts> MakeNet(const DirectionsNet& net);

/// 環状ネット (figs. 11 b, 12 c): U runs round, V outward. The middle is closed: the innermost patches are three-sided.
struct RingNet {
  int spokes = 12;  ///< >= 3
  int rings = 6;    ///< >= 2
  double spacing = 10.0;
};
[[nodiscard]] Result<ControlMeshParts> MakeNet(const RingNet& net);

/// A spiral (fig. 10 d'): one U axis winds outward, V axes run across its turns; the first turn closes on the middle,
/// the first patch is two-sided.
struct SpiralNet {
  int per_turn = 12;  ///< >= 3
  int points = 72;    ///< More than per_turn.
  double spacing = 10.0;
};
[[nodiscard]] Result<ControlMeshParts> MakeNet(const SpiralNet& net);

/// "regular:8x8", "tube:12x6" (columns cyclic), "torus:12x8", "bordered:8x8", "directions:3x5", "ring:12x6",
/// "spiral:12x72". Fails on anything else.
[[nodiscard]] Result<ControlMeshParts> MakeNet(std::string_view name);

/// A number of a sequence without pattern, 0 … 1, the same on every machine.
[[nodiscard]] double ScatteredNumber(std::uint64_t seed, std::uint64_t index);

}  // namespace annulus
