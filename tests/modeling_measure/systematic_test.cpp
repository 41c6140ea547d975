#include "modeling/measure/systematic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "modeling/measure/section.h"
#include "modeling/measure/slab.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;
using testing::HasSubstr;

constexpr double kRadius = 90.0;
const std::vector<double> kBreaks = UniformBreakpoints(0.0, 400.0, 80);

SurfaceModel Cylinder(std::size_t theta_count = 180) {
  return InterpolatedBody([](double, double) { return kRadius; }, theta_count, kBreaks);
}

SystematicErrors Offsets(const Eigen::MatrixXd& covariance) { return {CalibrationErrors{covariance, 0.0, 0.0}, {}}; }

SystematicErrors Sways(double sigma_x, double sigma_y, double length) {
  return {{}, SwayErrors{sigma_x, sigma_y, length, {}, {}}};
}

MeasuredSurface Measured(const SurfaceModel& model) {
  auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  return std::move(*body);
}

/// The estimate that is the radius at one place.
Estimate RadiusEstimate(const SplineSurface& surface, double theta, double z) {
  GradientSum gradient(surface);
  gradient.AddRadius(theta, z, 1.0);
  return {surface.Radius(theta, z), gradient.Get()};
}

TEST(Systematic, ACommonOffsetOfOneMillimetreIsTwoPiOfGirth) {
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  const auto section = SectionAt(body, 200.0);
  ASSERT_TRUE(section);
  for (const std::size_t directions : {1U, 7U, 180U, 500U}) {
    const SystematicErrors errors = Offsets(OffsetCovariance(directions, 1.0, 0.0));
    EXPECT_NEAR(SigmasFrom(errors, body, section->perimeter).calibration, kTwoPi, 1e-9) << directions;
    EXPECT_NEAR(SigmasFrom(errors, body, section->area).calibration, kTwoPi * kRadius, 1e-6) << directions;
    EXPECT_EQ(SigmasFrom(errors, body, section->area).sway, 0.0);
  }
}

TEST(Systematic, IndependentOffsetsAreDividedByTheRootOfTheirNumber) {
  // Girth of a circle = 2π·mean radius: sd 2π·s/√n, whether there is a knot per direction, two, or half a one.
  for (const std::size_t knots : {90U, 180U, 360U}) {
    const SurfaceModel model = Cylinder(knots);
    const MeasuredSurface body = Measured(model);
    const auto section = SectionAt(body, 200.0);
    ASSERT_TRUE(section);
    const SystematicErrors errors = Offsets(OffsetCovariance(180, 0.0, 0.5));
    EXPECT_NEAR(SigmasFrom(errors, body, section->perimeter).calibration, kTwoPi * 0.5 / std::sqrt(180.0), 1e-9)
        << knots;
  }
}

TEST(Systematic, IndependentOffsetsRepeatOverTheHeight) {
  // They do not average out over a slab: sd of the volume is 2πRh·s/√n.
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  const auto slab = SlabBetween(body, 100.0, 300.0);
  ASSERT_TRUE(slab);
  const double expected = kTwoPi * kRadius * 200.0 / std::sqrt(180.0);
  EXPECT_NEAR(SigmasFrom(Offsets(OffsetCovariance(180, 0.0, 1.0)), body, slab->volume).calibration, expected,
              1e-9 * expected);
}

TEST(Systematic, TheOffsetOfOneDirectionMovesThatSideOnly) {
  // Coefficients follow the offsets at their knots; at a knot r = (c_before + 4 c + c_after) / 6.
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(180, 180);
  covariance(10, 10) = 0.3 * 0.3;
  const auto sigma = [&](double degrees) {
    const Estimate radius = RadiusEstimate(body.surface(), degrees * kPi / 180.0, 200.0);
    return SigmasFrom(Offsets(covariance), body, radius).calibration;
  };
  EXPECT_NEAR(sigma(20.0), 0.3 * 4.0 / 6.0, 1e-9);
  EXPECT_NEAR(sigma(22.0), 0.3 / 6.0, 1e-9);
  EXPECT_NEAR(sigma(200.0), 0.0, 1e-12);
}

TEST(Systematic, HeightErrorsMoveASlopingSurface) {
  // On a cone r = 150 - 0.25 z, dr = 0.25·dz; dz = scale·z + offset.
  const SurfaceModel model = InterpolatedBody([](double, double z) { return 150.0 - 0.25 * z; }, 36, kBreaks);
  const MeasuredSurface body = Measured(model);
  const Estimate radius = RadiusEstimate(body.surface(), 1.0, 240.0);
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(1, 1);
  EXPECT_NEAR(SigmasFrom({CalibrationErrors{none, 0.0, 2.0}, {}}, body, radius).calibration, 0.5, 1e-9);
  EXPECT_NEAR(SigmasFrom({CalibrationErrors{none, 0.001, 0.0}, {}}, body, radius).calibration, 0.06, 1e-9);
  EXPECT_NEAR(SigmasFrom({CalibrationErrors{none, 0.001, 2.0}, {}}, body, radius).calibration, std::hypot(0.5, 0.06),
              1e-9);
}

TEST(Systematic, RigidSwayLeavesHorizontalGirthsAndVolumes) {
  // An ellipse off the axis: a displaced section keeps perimeter and area. Shifting coefficients instead of radii
  // leaves a share of (2π/180)²/6 = 2e-4 of the displacement.
  const SurfaceModel model = InterpolatedBody(
      [](double theta, double) { return 100.0 / std::hypot(std::cos(theta), 1.4 * std::sin(theta)); }, 180, kBreaks);
  const MeasuredSurface body = Measured(model);
  const auto section = SectionAt(body, 200.0);
  const auto slab = SlabBetween(body, 100.0, 300.0);
  ASSERT_TRUE(section && slab);
  const SystematicErrors errors = Sways(5.0, 5.0, 100.0);
  EXPECT_LT(SigmasFrom(errors, body, section->perimeter).sway, 0.005);
  EXPECT_LT(SigmasFrom(errors, body, section->area).sway, 1.0);   // of 22,400 mm²
  EXPECT_LT(SigmasFrom(errors, body, slab->volume).sway, 200.0);  // of 4.5e6 mm³
  EXPECT_EQ(SigmasFrom(errors, body, slab->volume).calibration, 0.0);
}

TEST(Systematic, SwayMovesARadiusByTheDisplacementTowardsIt) {
  const SurfaceModel model = Cylinder(360);
  const MeasuredSurface body = Measured(model);
  const auto sigma = [&](double theta, const SystematicErrors& errors) {
    return SigmasFrom(errors, body, RadiusEstimate(body.surface(), theta, 200.0)).sway;
  };
  const double theta = 0.6;
  EXPECT_NEAR(sigma(theta, Sways(3.0, 0.0, 1e6)), 3.0 * std::cos(theta), 1e-3);
  EXPECT_NEAR(sigma(theta, Sways(0.0, 2.0, 1e6)), 2.0 * std::sin(theta), 1e-3);
  EXPECT_NEAR(sigma(theta, Sways(3.0, 2.0, 1e6)), std::hypot(3.0 * std::cos(theta), 2.0 * std::sin(theta)), 1e-3);
}

TEST(Systematic, SwayMovesWhereASteepSideIs) {
  // A body turned a little: where r_theta is not 0 a tangential displacement d moves r by -(r_theta / r)·d. At
  // theta = 0 the displacement along y is tangential.
  const SurfaceModel model =
      InterpolatedBody([](double theta, double) { return 100.0 + 10.0 * std::sin(2.0 * theta); }, 360, kBreaks);
  const MeasuredSurface body = Measured(model);
  const Estimate radius = RadiusEstimate(body.surface(), 0.0, 200.0);
  EXPECT_NEAR(SigmasFrom(Sways(0.0, 1.0, 1e6), body, radius).sway, 20.0 / 100.0, 1e-3);
}

TEST(Systematic, SwayBetweenTwoLevelsChangesTheLineBetweenThem) {
  // The distance of two points of the front, in depth: r(z1) - r(z2). Var = 2 s² (1 - exp(-dz²/2L²)).
  const SurfaceModel model = Cylinder(360);
  const MeasuredSurface body = Measured(model);
  const double front = 0.5 * kPi;
  for (const double gap : {20.0, 100.0, 300.0}) {
    const Estimate depth = Combine(1.0, RadiusEstimate(body.surface(), front, 50.0), -1.0,
                                   RadiusEstimate(body.surface(), front, 50.0 + gap));
    const double expected = 4.0 * std::sqrt(2.0 * (1.0 - std::exp(-0.5 * gap * gap / (150.0 * 150.0))));
    EXPECT_NEAR(SigmasFrom(Sways(0.0, 4.0, 150.0), body, depth).sway, expected, 2e-3 * expected) << gap;
  }
}

TEST(Systematic, SwayLengthensASlantingMeridian) {
  // On a cone with slope k the meridian's length follows r at its ends: dL = k/√(1+k²)·(dr(top) - dr(bottom)). Levels
  // that move together (L = 1e6 mm) leave it as it is, independent ends (200 mm apart, L = 20 mm) give √2·s·k/√(1+k²).
  const double k = -0.25;
  const SurfaceModel model = InterpolatedBody([&](double, double z) { return 150.0 + k * z; }, 360, kBreaks);
  const MeasuredSurface body = Measured(model);
  const auto length = MeridianLength(body, 0.0, 100.0, 300.0);
  ASSERT_TRUE(length);
  EXPECT_NEAR(SigmasFrom(Sways(4.0, 0.0, 1e6), body, *length).sway, 0.0, 1e-3);
  // The coefficients at an end stand 5 mm apart: their displacements are as good as one with L = 20 mm, within 6 %.
  const double expected = 4.0 * std::sqrt(2.0) * 0.25 / std::hypot(1.0, k);
  EXPECT_NEAR(SigmasFrom(Sways(4.0, 0.0, 20.0), body, *length).sway, expected, 0.06 * expected);
}

/// The full form with one kind of displacement: 0 along x, 1 along y (mm), 2 yaw (rad), sd `sigma` at all heights,
/// correlated along z as the parametric form is.
SystematicErrors FullSways(Eigen::Index axis, double sigma, double length) {
  SwayErrors sway{sigma, sigma, length, {}, {}};
  for (double z = 0.0; z <= 400.0; z += 10.0) sway.heights.push_back(z);
  const auto n = static_cast<Eigen::Index>(sway.heights.size());
  sway.covariance = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const double distance = 10.0 * static_cast<double>(i - j) / length;
      sway.covariance(axis * n + i, axis * n + j) = sigma * sigma * std::exp(-0.5 * distance * distance);
    }
  }
  return {{}, sway};
}

TEST(Systematic, TheFullSwayOfACylinderIsThatOfTheParameters) {
  // A cylinder has no r_z, so that a lean shows as a displacement only.
  const SurfaceModel model = Cylinder(360);
  const MeasuredSurface body = Measured(model);
  const Estimate depth = Combine(1.0, RadiusEstimate(body.surface(), 0.5 * kPi, 150.0), -1.0,
                                 RadiusEstimate(body.surface(), 0.5 * kPi, 250.0));
  const double expected = 4.0 * std::sqrt(2.0 * (1.0 - std::exp(-0.5 * 100.0 * 100.0 / (150.0 * 150.0))));
  EXPECT_NEAR(SigmasFrom(FullSways(1, 4.0, 150.0), body, depth).sway, expected, 2e-3 * expected);
  EXPECT_NEAR(SigmasFrom(FullSways(0, 4.0, 150.0), body, depth).sway, 0.0, 1e-3);
  EXPECT_NEAR(SigmasFrom(FullSways(2, 0.1, 150.0), body, depth).sway, 0.0, 1e-3);
}

TEST(Systematic, AFullSwayTurnsAndLeans) {
  // Yaw: -r_theta per rad; at theta = 0 of 100 + 10 sin 2θ it is -20 mm/rad.
  const SurfaceModel bumpy =
      InterpolatedBody([](double theta, double) { return 100.0 + 10.0 * std::sin(2.0 * theta); }, 360, kBreaks);
  const MeasuredSurface turned = Measured(bumpy);
  EXPECT_NEAR(SigmasFrom(FullSways(2, 0.01, 1e6), turned, RadiusEstimate(turned.surface(), 0.0, 200.0)).sway, 0.2,
              1e-3);
  // A cone of slope -0.25, 90 mm wide at z = 240: displaced by d it leans by d/240, and what lies outside goes down by
  // 90·d/240: r changes by d·(1 - 0.25·90/240).
  const SurfaceModel cone = InterpolatedBody([](double, double z) { return 150.0 - 0.25 * z; }, 360, kBreaks);
  const MeasuredSurface leaning = Measured(cone);
  const double expected = 2.0 * (1.0 - 0.25 * 90.0 / 240.0);
  EXPECT_NEAR(SigmasFrom(FullSways(0, 2.0, 1e6), leaning, RadiusEstimate(leaning.surface(), 0.0, 240.0)).sway, expected,
              5e-3);
}

TEST(Systematic, ACommonTranslationOfAllSectionsLeavesGirthsAndLengths) {
  // All sections alike, as where a person stands a little elsewhere; the lean that goes with it is small.
  const SurfaceModel model = InterpolatedBody([](double, double z) { return 150.0 - 0.05 * z; }, 360, kBreaks);
  const MeasuredSurface body = Measured(model);
  const auto section = SectionAt(body, 300.0);
  const auto length = MeridianLength(body, 0.0, 200.0, 350.0);
  ASSERT_TRUE(section && length);
  EXPECT_LT(SigmasFrom(FullSways(0, 3.0, 1e6), body, section->perimeter).sway, 0.02);
  EXPECT_LT(SigmasFrom(FullSways(0, 3.0, 1e6), body, *length).sway, 0.02);
}

TEST(Systematic, AnExactNumberAndUnknownErrorsHaveNoSigma) {
  const SurfaceModel model = Cylinder();
  const MeasuredSurface body = Measured(model);
  const SystematicErrors all{CalibrationErrors{OffsetCovariance(180, 1.0, 1.0), 0.1, 1.0},
                             SwayErrors{1, 1, 50, {}, {}}};
  EXPECT_EQ(SigmasFrom(all, body, Estimate{3.0, {}}).calibration, 0.0);
  EXPECT_EQ(SigmasFrom(all, body, Estimate{3.0, {}}).sway, 0.0);
  const Estimate radius = RadiusEstimate(body.surface(), 0.0, 200.0);
  EXPECT_EQ(SigmasFrom({}, body, radius).calibration, 0.0);
  EXPECT_EQ(SigmasFrom({}, body, radius).sway, 0.0);
}

TEST(SystematicErrors, OfSoundSizeAndSignPass) {
  EXPECT_TRUE(CheckSystematicErrors({}));
  EXPECT_TRUE(CheckSystematicErrors(Offsets(OffsetCovariance(180, 0.2, 0.5))));
  EXPECT_TRUE(CheckSystematicErrors(Offsets(OffsetCovariance(180, 1e150, 0.0))));  // semi-definite and huge
  EXPECT_TRUE(CheckSystematicErrors(Offsets(Eigen::MatrixXd::Zero(3, 3))));
  EXPECT_TRUE(CheckSystematicErrors(Sways(0.0, 0.0, 1.0)));
}

TEST(SystematicErrors, OfAnotherSizeOrSignAreRefusedByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto seen = [](const SystematicErrors& errors) {
    const Status status = CheckSystematicErrors(errors);
    return status ? std::string("passed") : status.error().seen;
  };
  Eigen::MatrixXd skew = Eigen::MatrixXd::Identity(3, 3);
  skew(0, 2) = 0.5;
  Eigen::MatrixXd indefinite = Eigen::MatrixXd::Identity(3, 3);
  indefinite(0, 1) = indefinite(1, 0) = 1.5;
  Eigen::MatrixXd hollow = Eigen::MatrixXd::Zero(2, 2);
  hollow(0, 1) = hollow(1, 0) = 1.0;
  Eigen::MatrixXd negative = Eigen::MatrixXd::Identity(3, 3);
  negative(1, 1) = -1.0;
  Eigen::MatrixXd broken = Eigen::MatrixXd::Identity(3, 3);
  broken(1, 0) = nan;
  EXPECT_THAT(seen(Offsets(Eigen::MatrixXd::Zero(0, 0))), HasSubstr("0 directions"));
  EXPECT_THAT(seen(Offsets(Eigen::MatrixXd::Zero(2000, 2000))), HasSubstr("2000 directions"));
  EXPECT_THAT(seen(Offsets(Eigen::MatrixXd::Zero(2, 3))), HasSubstr("2 by 3"));
  EXPECT_THAT(seen(Offsets(skew)), HasSubstr("not symmetric"));
  EXPECT_THAT(seen(Offsets(indefinite)), HasSubstr("not positive semi-definite"));
  EXPECT_THAT(seen(Offsets(hollow)), HasSubstr("not positive semi-definite"));
  EXPECT_THAT(seen(Offsets(negative)), HasSubstr("direction 1 is negative"));
  EXPECT_THAT(seen(Offsets(broken)), HasSubstr("not finite"));
  EXPECT_THAT(seen({CalibrationErrors{Eigen::MatrixXd::Zero(1, 1), -1.0, 0.0}, {}}), HasSubstr("heights"));
  EXPECT_THAT(seen({CalibrationErrors{Eigen::MatrixXd::Zero(1, 1), 0.0, nan}, {}}), HasSubstr("heights"));
  EXPECT_THAT(seen(Sways(-1.0, 0.0, 1.0)), HasSubstr("sway"));
  EXPECT_THAT(seen(Sways(0.0, nan, 1.0)), HasSubstr("sway"));
  EXPECT_THAT(seen(Sways(1.0, 1.0, 0.0)), HasSubstr("correlation length"));
}

TEST(SystematicErrors, OfAFullSwayAreRefusedByName) {
  const auto seen = [](const std::function<void(SwayErrors&)>& change) {
    SystematicErrors errors = FullSways(0, 2.0, 100.0);
    change(*errors.sway);
    const Status status = CheckSystematicErrors(errors);
    return status ? std::string("passed") : status.error().seen;
  };
  EXPECT_EQ(seen([](SwayErrors&) {}), "passed");
  EXPECT_THAT(seen([](SwayErrors& s) { s.heights.clear(); }), HasSubstr("no heights"));
  EXPECT_THAT(seen([](SwayErrors& s) { s.heights.resize(1); }), HasSubstr("1 heights"));
  EXPECT_THAT(seen([](SwayErrors& s) { s.heights.pop_back(); }), HasSubstr("for 40 heights"));
  EXPECT_THAT(seen([](SwayErrors& s) { s.heights[1] = s.heights[0]; }), HasSubstr("do not ascend"));
  EXPECT_THAT(seen([](SwayErrors& s) { s.covariance(2, 1) += 0.1; }), HasSubstr("not symmetric"));
  EXPECT_THAT(seen([](SwayErrors& s) { s.covariance(1, 1) = -1.0; }), HasSubstr("displacement 1 is negative"));
  EXPECT_THAT(seen([](SwayErrors& s) { s.covariance(0, 1) = s.covariance(1, 0) = 9.0; }),
              HasSubstr("not positive semi-definite"));
  // A turn is small in rad², and its covariance is checked all the same.
  EXPECT_THAT(seen([](SwayErrors& s) {
                const Eigen::Index yaw = s.covariance.rows() - 2;
                s.covariance(yaw, yaw) = s.covariance(yaw + 1, yaw + 1) = 1e-8;
                s.covariance(yaw, yaw + 1) = s.covariance(yaw + 1, yaw) = 2e-8;
              }),
              HasSubstr("not positive semi-definite"));
}

}  // namespace
}  // namespace annulus
