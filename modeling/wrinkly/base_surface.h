#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/result.h"
#include "modeling/wrinkly/control_mesh.h"
#include "modeling/wrinkly/patch_net.h"
#include "modeling/wrinkly/rounded_corner.h"

namespace annulus {

/// How patches meet around cells that have not four control points.
enum class CornerJoin {
  kPaper,    ///< As paper 003, §3.4 has it: without a gap, nearly smooth.
  kRounded,  ///< With a common tangent plane (G1) and along all edges that end there; elsewhere the same surface.
};

/// The base surface P(t) of a wrinkly surface (paper 003, eq. 13): one biquadratic patch per control point, no gaps. A
/// value; thread-safe. Station frame, mm.
class BaseSurface {
 public:
  /// Fails if a patch has no area (its control points lie on a point), and for kRounded if an irregular cell touches a
  /// patch with a closed side.
  static Result<BaseSurface> Make(const ControlMesh& mesh, CornerJoin join);

  /// P and its derivatives at (u, v) of a patch, both 0 … 1.
  [[nodiscard]] PatchPoint At(PointIndex patch, double u, double v) const {
    const std::size_t k = ControlMesh::Index(patch);
    return rounded_of_[k] < 0 ? PointOn(nets_[k], u, v) : RoundedAt(patch, u, v);
  }
  /// The outward unit normal for a point of this patch; at a point where the derivatives vanish or are parallel that of
  /// the patch a little further in, the z axis if there is none.
  [[nodiscard]] Eigen::Vector3d NormalAt(PointIndex patch, const PatchPoint& at) const;
  /// The largest |S_u| and |S_v| of a patch as its net bounds them, mm per unit.
  [[nodiscard]] const std::array<double, 2>& LargestSpeed(PointIndex patch) const {
    return speed_[ControlMesh::Index(patch)];
  }
  [[nodiscard]] const BiquadraticNet& net(PointIndex patch) const { return nets_[ControlMesh::Index(patch)]; }

 private:
  BaseSurface() = default;
  Status Round(const ControlMesh& mesh);
  [[nodiscard]] PatchPoint RoundedAt(PointIndex patch, double u, double v) const;

  std::vector<BiquadraticNet> nets_;
  std::vector<std::array<double, 2>> speed_;
  std::vector<Eigen::Vector3d> middle_normal_;
  std::vector<std::int8_t> side_;         ///< +1 if S_u × S_v points outward.
  std::vector<std::int32_t> rounded_of_;  ///< Index into rounded_, or −1.
  std::vector<std::array<RoundedCorner, 4>> rounded_;
};

/// How well the patches of a base surface join.
struct BaseJoins {
  double largest_gap_mm = 0.0;
  /// Angles between the normals of neighbouring patches along their common edges, rad, taken at 1e-6, 1e-3, 0.03, 0.1,
  /// 0.25 and 0.5 of the edge from its end: of edges that end in an irregular cell, and of those with two regular ends.
  double irregular_mean = 0.0;
  double irregular_largest = 0.0;
  double regular_largest = 0.0;
  std::size_t irregular_edges = 0;
};
[[nodiscard]] BaseJoins MeasureBaseJoins(const ControlMesh& mesh, const BaseSurface& surface);

}  // namespace annulus
