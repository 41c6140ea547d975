#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/frames.h"
#include "fitting/surface_model.h"
#include "sim/parametric_body.h"
#include "tests/modeling_measure/interpolated_body.h"
#include "tests/support/radius_about_axis.h"

namespace annulus::test {

/// Which part of a head is sampled, and how finely.
struct HeadSurfaceOptions {
  double depth_mm = 262.0;    ///< From 1 mm below the crown downwards.
  std::size_t columns = 360;  ///< Around.
  double face_step_mm = 1.0;  ///< Between rows from 45 mm below to 30 mm above the eyes.
  double elsewhere_step_mm = 3.0;
};

/// The surface of a head that is known exactly, without a scan: a spline through it at every column and row. Within
/// 0.05 mm (rms) of the face; all measured, no covariance. About 0.1 s.
inline SurfaceModel HeadSurface(const sim::ParametricBody& head, const HeadSurfaceOptions& options = {}) {
  const double top = head.top_mm() - 1.0;
  const double bottom = std::max(top - options.depth_mm, head.bottom_mm() + 2.0);
  const double eyes = 0.5 * (head.face().right_eye.z() + head.face().left_eye.z());
  std::vector<double> breakpoints;
  for (double z = bottom; z < top - options.face_step_mm;) {
    breakpoints.push_back(z);
    z += z > eyes - 45.0 && z < eyes + 30.0 ? options.face_step_mm : options.elsewhere_step_mm;
  }
  breakpoints.push_back(top);
  return InterpolatedBody([&head](double theta, double z) { return RadiusAboutAxis(head, theta, z); }, options.columns,
                          breakpoints);
}

}  // namespace annulus::test
