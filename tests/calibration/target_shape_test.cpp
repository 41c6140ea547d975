#include "fitting/target_shape.h"

#include <gtest/gtest.h>

namespace annulus {
namespace {

Ray RayFrom(double theta, double z, double lateral, double vertical) {
  const double heading = theta + kPi + lateral;
  return {PointFromCylindrical(theta, 600.0, z),
          {std::cos(vertical) * std::cos(heading), std::cos(vertical) * std::sin(heading), std::sin(vertical)}};
}

TEST(TargetShape, MeetsACentredCylinderAtTheRingsRadiusLessItsOwn) {
  CalibrationTarget target;
  TargetForm form;
  form.radius_mm = 150.0;
  for (const double theta : {0.0, 1.0, 4.0}) {
    const auto hit = MeetTarget(target, form, {}, RayFrom(theta, 400.0, 0.0, 0.0));
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance, 450.0, 1e-9);
    EXPECT_NEAR(hit->cos_incidence, 1.0, 1e-12);
    EXPECT_NEAR(hit->along, 400.0, 1e-9);
  }
  EXPECT_FALSE(MeetTarget(target, form, {}, RayFrom(0.0, 400.0, 0.3, 0.0)));
}

}  // namespace
}  // namespace annulus
