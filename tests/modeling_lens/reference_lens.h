#pragma once

#include <Eigen/Geometry>

#include "base/units.h"
#include "modeling/glasses/lens_surface.h"

namespace annulus::test {

/// The lens of lens_reference.py: index 1.6, front radius 120 mm, back torus 55/70 mm with its steep meridian at 30°,
/// its normal leaning by 2° towards 200°, 2.2 mm thick.
inline LensForm ReferenceLens() {
  const auto about_z = [](double degrees) {
    return Eigen::AngleAxisd(RadiansFromDegrees(degrees), Eigen::Vector3d::UnitZ());
  };
  LensForm form;
  form.index = 1.6;
  form.centre_thickness = 2.2;
  form.front.curvature_u = form.front.curvature_v = 1.0 / 120.0;
  form.back.curvature_u = 1.0 / 55.0;
  form.back.curvature_v = 1.0 / 70.0;
  form.back.lens_from_surface.linear() =
      (about_z(200.0) * Eigen::AngleAxisd(RadiansFromDegrees(2.0), Eigen::Vector3d::UnitY()) * about_z(-200.0) *
       about_z(30.0))
          .toRotationMatrix();
  form.back.lens_from_surface.translation() = Eigen::Vector3d(0.0, 0.0, -2.2);
  form.back_point = form.back.lens_from_surface.translation();
  return form;
}

}  // namespace annulus::test
