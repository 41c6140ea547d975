#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "modeling/clay/clay_mesh.h"
#include "modeling/clay/clay_shapes.h"

namespace annulus::test {

/// The block, bent to something without a flat or straight part: a smooth map of all of space applied by each corner's
/// affine part, so that joins that are smooth stay so.
inline PatchShell RoundBlock() {
  PatchShell shell = ClayBlock();
  for (ShellPatch& piece : shell.patches) {
    BezierPatch::ControlNet net = piece.patch.control_net();
    const BezierPatch::ControlNet from = net;
    for (std::size_t edge = 0; edge < 4; ++edge) {
      const auto at = [&](std::size_t s, std::size_t t) {
        const auto [i, j] = NetIndex(edge, s, t);
        return from[i][j];
      };
      const Eigen::Vector3d c = at(0, 0);
      // x + 0.3 sin(y), y + 0.2 cos(x + z), z + 0.25 sin(x) cos(y)
      const Eigen::Vector3d to(c.x() + 0.3 * std::sin(c.y()), c.y() + 0.2 * std::cos(c.x() + c.z()),
                               c.z() + 0.25 * std::sin(c.x()) * std::cos(c.y()));
      Eigen::Matrix3d slope;
      slope << 1.0, 0.3 * std::cos(c.y()), 0.0,                                 //
          -0.2 * std::sin(c.x() + c.z()), 1.0, -0.2 * std::sin(c.x() + c.z()),  //
          0.25 * std::cos(c.x()) * std::cos(c.y()), -0.25 * std::sin(c.x()) * std::sin(c.y()), 1.0;
      for (std::size_t s = 0; s < 2; ++s) {
        for (std::size_t t = 0; t < 2; ++t) {
          const auto [i, j] = NetIndex(edge, s, t);
          net[i][j] = to + slope * (at(s, t) - c);
        }
      }
    }
    piece.patch = BezierPatch(net);
  }
  return shell;
}

/// How well the leaves of a mesh fit together, found by evaluating both sides of every join.
struct JoinErrors {
  double gap = 0.0;   ///< mm
  double kink = 0.0;  ///< rad, where the join is said to be smooth.
};

inline JoinErrors MeasureLeafJoins(const ClayMesh& mesh) {
  JoinErrors errors;
  const auto place = [](std::size_t edge, double along) -> std::pair<double, double> {
    switch (edge) {
      case 0:
        return {along, 0.0};
      case 1:
        return {1.0, along};
      case 2:
        return {1.0 - along, 1.0};
      default:
        return {0.0, 1.0 - along};
    }
  };
  for (PatchIndex index = 0; index < mesh.patches().size(); ++index) {
    if (!mesh.alive(index)) continue;
    const BezierPatch own(mesh.patch(index).net);
    for (std::size_t edge = 0; edge < 4; ++edge) {
      const ClayJoin& join = mesh.patch(index).join[edge];
      if (join.kind != ClayJoin::Kind::kEqual && join.kind != ClayJoin::Kind::kCoarser) continue;
      const BezierPatch other(mesh.patch(join.patch[0]).net);
      for (const double t : {0.0, 0.13, 0.5, 0.71, 1.0}) {
        const double theirs = join.kind == ClayJoin::Kind::kEqual ? 1.0 - t : 0.5 * (1.0 - t) + 0.5 * join.half;
        const auto [u, v] = place(edge, t);
        const auto [s, w] = place(join.edge[0], theirs);
        errors.gap = std::max(errors.gap, (own.Point(u, v) - other.Point(s, w)).norm());
        if (!join.smooth) continue;
        const double sine = own.Normal(u, v).cross(other.Normal(s, w)).norm();
        errors.kink = std::max(errors.kink, sine);
      }
    }
  }
  return errors;
}

/// What is wrong with a mesh's bookkeeping, or with its joins beyond `tolerance` (mm, rad); empty if nothing is.
inline std::string Unsound(const ClayMesh& mesh, double tolerance) {
  std::size_t leaves = 0;
  for (PatchIndex index = 0; index < mesh.patches().size(); ++index) {
    if (!mesh.alive(index)) continue;
    ++leaves;
    const ClayPatch& own = mesh.patch(index);
    for (std::uint8_t e = 0; e < 4; ++e) {
      const auto& corners = mesh.vertex(own.vertex[e]).corners;
      const bool known = std::any_of(corners.begin(), corners.end(),
                                     [&](const PatchCorner& at) { return at.patch == index && at.corner == e; });
      if (!known) return "a vertex does not know a corner of leaf " + std::to_string(index);
      const ClayJoin& join = own.join[e];
      if (join.kind == ClayJoin::Kind::kPole) continue;
      const std::size_t others = join.kind == ClayJoin::Kind::kFiner ? 2 : 1;
      for (std::size_t n = 0; n < others; ++n) {
        if (!mesh.alive(join.patch[n])) return "leaf " + std::to_string(index) + " joins one that is not";
        const ClayJoin& back = mesh.patch(join.patch[n]).join[join.edge[n]];
        if (back.patch[0] != index && back.patch[1] != index) return "a join does not go both ways";
        if (std::abs(back.ratio * join.ratio - 1.0) > 1e-12) return "the ratios of a join do not agree";
      }
    }
  }
  if (leaves != mesh.leaf_count()) return "leaves are miscounted";
  const JoinErrors errors = MeasureLeafJoins(mesh);
  if (errors.gap > tolerance) return "a gap of " + std::to_string(errors.gap * 1e12) + "e-12 mm";
  if (errors.kink > std::max(tolerance, 1e-9)) return "a kink of " + std::to_string(errors.kink * 1e9) + "e-9 rad";
  return {};
}

inline bool MeshIsSound(const ClayMesh& mesh) { return Unsound(mesh, 1e-12).empty(); }

}  // namespace annulus::test
