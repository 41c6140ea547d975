#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <string>
#include <vector>

#include "modeling/bezier/bezier_patch.h"
#include "modeling/bezier/bezier_tube.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// How finely a parameter direction of a shell's patch is cut: what runs along a tube, what runs round it, and what is
/// straight.
enum class PatchDetail { kAlong, kAround, kStraight };

/// A patch of a shell. S_u × S_v points out of the solid.
struct ShellPatch {
  BezierPatch patch;
  PatchDetail u = PatchDetail::kAlong;
  PatchDetail v = PatchDetail::kAround;
};

/// A closed surface of bicubic patches: the skin of one solid piece. Every edge of a patch is the edge of exactly one
/// other patch with the same control points (in the other direction), or has no length (a pole). Where two edges meet
/// their details are the same. A plain value.
struct PatchShell {
  std::string name;
  std::vector<ShellPatch> patches;
};

/// Steps per patch.
struct ShellTessellation {
  std::size_t along = 12;    ///< >= 1
  std::size_t around = 10;   ///< >= 1
  std::size_t straight = 1;  ///< >= 1
};

/// The closed mesh of a shell: vertices on shared edges are welded, triangles without area left out, no open edge.
/// Triangles are oriented outward.
[[nodiscard]] TriangleMesh Tessellate(const PatchShell& shell, const ShellTessellation& tessellation);

/// The volume enclosed, mm³: (1/3)∬ S·(S_u × S_v) du dv summed, exact for polynomial patches up to rounding.
[[nodiscard]] double Volume(const PatchShell& shell);

/// Volume and first moments ∭ x dV, mm³ and mm⁴; exact for polynomial patches up to rounding.
struct ShellMoments {
  double volume = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
};
[[nodiscard]] ShellMoments MomentsOf(const PatchShell& shell);

/// The shell mirrored at the plane x = 0 under another name; normals stay outward.
[[nodiscard]] PatchShell MirroredX(const PatchShell& shell, std::string name);
/// The shell moved.
[[nodiscard]] PatchShell Moved(const PatchShell& shell, const Eigen::Isometry3d& to_from);
/// The shell with every patch flipped if its volume is negative: for shells built without regard to the side.
[[nodiscard]] PatchShell TurnedOutward(PatchShell shell);

/// How well the patches of a shell fit together.
struct ShellJoins {
  std::size_t open_edges = 0;  ///< Edges without a partner within 1e-6 mm; 0 for a closed shell.
  double position_gap = 0.0;   ///< mm; largest distance between control points of joined edges.
};
[[nodiscard]] ShellJoins MeasureJoins(const PatchShell& shell);

/// The shell of tubes that follow each other: patches A and B of each; kCapped: each end is closed by one ruled patch
/// between the end curves of A and B, unless it is a pole (a section without size).
[[nodiscard]] PatchShell ShellOfTubes(std::string name, const std::vector<BezierTube>& chain, TubeEnds ends);

}  // namespace annulus
