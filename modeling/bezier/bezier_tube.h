#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "modeling/bezier/bezier_patch.h"

namespace annulus {

/// One control section of a tube, mm (paper 000, figs. 5–8): the U of patch A and the mirrored U of patch B around M_i.
/// The surface's section is 2·|half_width| wide and 0.75 · 2·|half_depth| deep: half_depth is a control-polygon length.
struct TubeSection {
  Eigen::Vector3d centre;      ///< M_i.
  Eigen::Vector3d half_width;  ///< (Q_i2 - Q_i1) / 2 of patch A: from the centre to the seam v_A = 1.
  Eigen::Vector3d half_depth;  ///< From the centre line's plane to patch A's two middle control points.
};

/// A (bent) cylinder of two bicubic patches A and B joined along both seams with C1 (paper 000, figs. 5–8). u runs
/// along the tube, v_A from seam Q_i0ᴬ = Q_i3ᴮ to seam Q_i3ᴬ = Q_i0ᴮ. Normals point outward when (M_3 - M_0) ×
/// half_width points to half_depth's side. Ends are open. Immutable value.
class BezierTube {
 public:
  using Sections = std::array<TubeSection, 4>;

  explicit BezierTube(const Sections& sections);

  [[nodiscard]] const Sections& sections() const { return sections_; }
  [[nodiscard]] const BezierPatch& a() const { return a_; }
  [[nodiscard]] const BezierPatch& b() const { return b_; }
  /// The centre line: cubic Bezier curve with control points M_0 … M_3.
  [[nodiscard]] Eigen::Vector3d CentreLine(double u) const;
  /// Point at `u` along and `around` in [0, 1): patch A on [0, 0.5], patch B on [0.5, 1).
  [[nodiscard]] Eigen::Vector3d Point(double u, double around) const;
  /// Mirrored at the plane x = 0. Half depths are turned round so that the normals still point outward: A and B change
  /// sides, the seams stay.
  [[nodiscard]] BezierTube MirroredX() const;

 private:
  Sections sections_;
  BezierPatch a_;
  BezierPatch b_;
};

/// How a chain of tubes ends.
enum class TubeEnds {
  kLoop,    ///< The last tube's end is the first tube's start.
  kCapped,  ///< Both ends are closed by flat fans.
};

}  // namespace annulus
