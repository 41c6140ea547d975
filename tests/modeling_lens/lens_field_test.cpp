#include "modeling/glasses/lens_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "modeling/glasses/lens_form.h"
#include "modeling/mesh/triangle_mesh.h"
#include "tests/modeling_lens/lens_shapes.h"

namespace annulus {
namespace {

constexpr double kVertex = 12.0;  // mm, 25 mm before the centre of rotation

LensForm SphericalLens(double base, double power, double index, double thickness) {
  LensFormSpec spec;
  spec.base = base;
  spec.index = index;
  const auto form = BuildLensForm(spec, {power * PowerMatrix::Identity(), Eigen::Vector2d::Zero()}, thickness);
  EXPECT_TRUE(form);
  return *form;
}

LensSight SightOf(const LensForm& form, double diameter = 60.0, const Bvh* frame = nullptr) {
  return {form, test::Ellipse(diameter, diameter, 720), PoseOf(0.0, 0.0, kVertex, Eye::kRight), frame};
}

FieldGoal Goal(double power) { return {power * PowerMatrix::Identity(), Eigen::Vector2d::Zero(), 40.0}; }

Gaze Up(double degrees) { return {0.0, RadiansFromDegrees(degrees)}; }
Gaze Left(double degrees) { return {RadiansFromDegrees(degrees), 0.0}; }

/// Oblique powers by the textbook way: circles in the plane of gaze, rays by the sine rule at each circle's centre,
/// Coddington's two scalar equations, the vertex sphere. Everything in metres, z from the back vertex to the object.
struct Oblique {
  double tangential, sagittal;  // D
  double object;                // rad
  double thickness;             // mm
};
Oblique ByCoddington(double base, double power, double index, double thickness_mm, double gaze) {
  const double t = thickness_mm / 1000.0;
  const double r1 = (index - 1.0) / base;
  const double f2 = power - base / (1.0 - base * t / index);
  const double r2 = -(index - 1.0) / f2;
  // From the eye outwards. Back surface: centre at z = -r2, front: at z = t - r1; the eye's at -0.025.
  const auto meet = [](double y0, double z0, double angle, double centre, double radius) {
    // Along the ray from (z0, y0): the crossing with the larger z.
    const double oz = z0 - centre;
    const double half = oz * std::cos(angle) + y0 * std::sin(angle);
    return -half + std::sqrt(half * half - (oz * oz + y0 * y0 - radius * radius));
  };
  const double s2 = meet(0.0, -0.025, gaze, -r2, r2);
  const double y2 = s2 * std::sin(gaze);
  const double z2 = -0.025 + s2 * std::cos(gaze);
  const double normal2 = std::asin(y2 / r2);
  const double air2 = gaze - normal2;
  const double glass2 = std::asin(std::sin(air2) / index);
  const double in_glass = normal2 + glass2;
  const double path = meet(y2, z2, in_glass, t - r1, r1);
  const double y1 = y2 + path * std::sin(in_glass);
  const double normal1 = std::asin(y1 / r1);
  const double glass1 = in_glass - normal1;
  const double air1 = std::asin(index * std::sin(glass1));
  // The light's way back.
  const double gain1 = (index * std::cos(glass1) - std::cos(air1)) / r1;
  double tangential = gain1 / std::pow(std::cos(glass1), 2);
  double sagittal = gain1;
  tangential = tangential / (1.0 - path / index * tangential);
  sagittal = sagittal / (1.0 - path / index * sagittal);
  const double gain2 = (std::cos(air2) - index * std::cos(glass2)) / r2;
  tangential = (tangential * std::pow(std::cos(glass2), 2) + gain2) / std::pow(std::cos(air2), 2);
  sagittal = sagittal + gain2;
  const double to_sphere = s2 - 0.025;
  return {tangential / (1.0 - to_sphere * tangential), sagittal / (1.0 - to_sphere * sagittal), normal1 + air1,
          1000.0 * path};
}

TEST(LensField, AgreesWithTheScalarCoddingtonEquations) {
  struct Case {
    double base, power, index, thickness;
  };
  const Case cases[] = {{4.0, -6.0, 1.67, 1.5}, {3.0, -6.0, 1.74, 1.2}, {12.0, 6.0, 1.5, 7.0},
                        {7.0, 1.0, 1.6, 2.2},   {6.0, -2.0, 1.5, 2.0},  {9.0, 3.0, 1.586, 4.0}};
  for (const Case& one : cases) {
    const LensSight sight = SightOf(SphericalLens(one.base, one.power, one.index, one.thickness));
    for (const double degrees : {3.0, 10.0, 20.0, 30.0}) {
      const Oblique expected = ByCoddington(one.base, one.power, one.index, one.thickness, RadiansFromDegrees(degrees));
      for (const Gaze& gaze : {Up(degrees), Left(-degrees)}) {
        const FieldPoint point = FieldPointAt(sight, Goal(one.power), gaze);
        ASSERT_EQ(point.path, SightPath::kLens) << one.power << " " << degrees;
        EXPECT_NEAR(point.mean_error, 0.5 * (expected.tangential + expected.sagittal) - one.power, 1e-8);
        EXPECT_NEAR(point.astigmatism, std::abs(expected.tangential - expected.sagittal), 1e-8);
        EXPECT_NEAR(point.thickness, expected.thickness, 1e-8);
        EXPECT_NEAR(std::hypot(point.object.left, point.object.up), expected.object, 1e-9);
        EXPECT_NEAR(point.prism.norm(), 100.0 * std::tan(std::abs(expected.object - RadiansFromDegrees(degrees))),
                    1e-7);
        EXPECT_NEAR(point.chromatic, point.prism.norm() / 40.0, 1e-12);
      }
    }
  }
}

/// Tangential less sagittal error, signed.
double SignedAstigmatism(const FieldPoint& point) {
  // Gaze up: a minus cylinder with a horizontal axis weakens the tangential (vertical) meridian.
  return std::abs(std::sin(point.axis)) < 0.5 ? -point.astigmatism : point.astigmatism;
}

TEST(LensField, TheBaseWithoutAstigmatismLiesOnTscherningsEllipse) {
  // Third order, thin lens F = F1 + F2, centre of rotation 1/Z behind it, distant object. The angles of incidence of a
  // chief ray at height y are i1 = y(c1 − Z + F) and, behind the back, i2' = y(c2 − Z) with c = F/(n − 1); Coddington's
  // equations leave T − S = F·i2'² − F1(i2'² − i1²)/n². It is zero on
  //   (n + 2)·F1² − F1·[(n + 2)F + 2Z(n² − 1)] + n·(F + Z(n − 1))² = 0:
  // Ostwalt's flatter form and Wollaston's steeper one.
  constexpr double z = 1000.0 / 25.0;
  for (const double index : {1.5, 1.6}) {
    for (const double power : {-12.0, -8.0, -4.0, -1.0, 2.0, 5.0}) {
      const double a = index + 2.0;
      const double b = -((index + 2.0) * power + 2.0 * z * (index * index - 1.0));
      const double c = index * std::pow(power + z * (index - 1.0), 2);
      const double root = std::sqrt(b * b - 4.0 * a * c);
      for (const double expected : {(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)}) {
        const auto astigmatism = [&](double base) {
          return SignedAstigmatism(
              FieldPointAt(SightOf(SphericalLens(base, power, index, 1e-3)), Goal(power), Up(1.0)));
        };
        double low = expected - 0.8;
        double high = expected + 0.8;
        ASSERT_LT(astigmatism(low) * astigmatism(high), 0.0) << index << " " << power << " " << expected;
        const bool rising = astigmatism(high) > 0.0;
        for (int step = 0; step < 40; ++step) {
          const double middle = 0.5 * (low + high);
          ((astigmatism(middle) > 0.0) == rising ? high : low) = middle;
        }
        EXPECT_NEAR(low, expected, 0.02) << index << " " << power;
      }
    }
  }
}

TEST(LensField, AFlatPlateChangesNothingAndEndsWhereSnellSays) {
  LensFormSpec spec;
  spec.base = 0.0;
  spec.index = 1.6;
  constexpr double thickness = 3.0;
  const auto form = BuildLensForm(spec, {}, thickness);
  ASSERT_TRUE(form);
  const LensSight sight = SightOf(*form, 40.0);
  const FieldPoint point = FieldPointAt(sight, Goal(0.0), {RadiansFromDegrees(12.0), RadiansFromDegrees(-20.0)});
  const double turn = std::acos(std::cos(RadiansFromDegrees(12.0)) * std::cos(RadiansFromDegrees(20.0)));
  EXPECT_NEAR(point.worst_error, 0.0, 1e-12);
  EXPECT_NEAR(point.prism.norm(), 0.0, 1e-12);
  EXPECT_NEAR(point.magnification, 1.0, 1e-8);
  EXPECT_NEAR(point.object.left, point.gaze.left, 1e-12);
  EXPECT_NEAR(point.object.up, point.gaze.up, 1e-12);
  EXPECT_NEAR(point.thickness, thickness / std::cos(std::asin(std::sin(turn) / 1.6)), 1e-9);

  double low = 0.0;
  double high = 1.5;
  while (high - low > 1e-12) {
    const double middle = 0.5 * (low + high);
    const double reach = 25.0 * std::tan(middle) + thickness * std::tan(std::asin(std::sin(middle) / 1.6));
    (reach < 20.0 ? low : high) = middle;
  }
  const FieldLimits limits = FieldLimitsOf(sight);
  for (const FieldEdge& edge : {limits.left, limits.right, limits.up, limits.down}) {
    EXPECT_NEAR(edge.gaze, low, 1e-6);
    EXPECT_NEAR(edge.object, low, 1e-6);
    EXPECT_NEAR(edge.beside, std::atan(20.0 / 25.0), 1e-6);
  }
  EXPECT_NEAR(limits.gaze_solid_angle, kTwoPi * (1.0 - std::cos(low)), 1e-4);
  EXPECT_NEAR(limits.object_solid_angle, limits.gaze_solid_angle, 1e-9);
}

TEST(LensField, AheadItMagnifiesByTheThickLensFormula) {
  // For an eye that turns: 1 / ((1 − t/n·F1)(1 − d·Fv)), d from the back vertex to the centre of rotation.
  for (const double power : {-8.0, -3.0, 0.0, 2.0, 6.0}) {
    const double base = power > 0.0 ? power + 6.0 : power / 2.0 + 6.0;
    const FieldPoint point = FieldPointAt(SightOf(SphericalLens(base, power, 1.6, 4.0)), Goal(power), {});
    const double expected = 1.0 / ((1.0 - 0.004 / 1.6 * base) * (1.0 - 0.025 * power));
    EXPECT_NEAR(point.magnification, expected, 1e-6) << power;
    EXPECT_NEAR(point.worst_error, 0.0, 1e-9) << power;
  }
}

TEST(LensField, ATiltedLensHasMartinsErrorAhead) {
  const LensForm form = SphericalLens(3.0, -6.0, 1.6, 1.0);
  const LensPose pose = PoseOf(RadiansFromDegrees(8.0), 0.0, kVertex, Eye::kRight);
  const LensSight sight(form, test::Ellipse(50.0, 40.0), pose, nullptr);
  const FieldPoint point = FieldPointAt(sight, Goal(-6.0), {});
  const double tilt = RadiansFromDegrees(8.0);
  const double sphere = -6.0 * (1.0 + std::pow(std::sin(tilt), 2) / (2.0 * 1.6));
  const double cylinder = sphere * std::pow(std::tan(tilt), 2);
  EXPECT_NEAR(point.mean_error, sphere + 0.5 * cylinder + 6.0, 0.02);
  EXPECT_NEAR(point.astigmatism, -cylinder, 0.02);
  EXPECT_NEAR(point.axis, kPi, 1e-6);
}

TEST(LensField, APlusLensHidesARingAndAMinusLensShowsItTwice) {
  const FieldLimits plus = FieldLimitsOf(SightOf(SphericalLens(12.0, 6.0, 1.5, 8.0), 44.0));
  const FieldLimits minus = FieldLimitsOf(SightOf(SphericalLens(3.0, -6.0, 1.6, 1.5), 44.0));
  EXPECT_LT(plus.left.object, plus.left.gaze);
  EXPECT_GT(plus.left.gap(), RadiansFromDegrees(4.0));
  EXPECT_LT(plus.object_solid_angle, plus.gaze_solid_angle);
  EXPECT_GT(minus.left.object, minus.left.gaze);
  EXPECT_LT(minus.left.gap(), 0.0);
  EXPECT_GT(minus.object_solid_angle, minus.gaze_solid_angle);
}

/// A wall in the lens frame over x > `from` at height z.
TriangleMesh WallTowardsTheLeft(double from, double z) {
  return {{{from, -100.0, z}, {100.0, -100.0, z}, {100.0, 100.0, z}, {from, 100.0, z}}, {{0, 1, 2}, {0, 2, 3}}};
}

TEST(LensField, TheFrameEndsTheFieldBeforeAndBehindTheLens) {
  LensFormSpec spec;
  spec.index = 1.6;
  const auto form = BuildLensForm(spec, {}, 1.0);
  ASSERT_TRUE(form);
  // Behind the plate (z = −1) at −3 mm, 23 mm before the centre of rotation, and before it at 4 mm, 30 mm before it.
  const Bvh behind(WallTowardsTheLeft(10.0, -3.0));
  EXPECT_NEAR(FieldLimitsOf(SightOf(*form, 60.0, &behind)).left.gaze, std::atan(10.0 / 23.0), 1e-6);
  const Bvh before(WallTowardsTheLeft(10.0, 4.0));
  const FieldLimits limits = FieldLimitsOf(SightOf(*form, 60.0, &before));
  // The plate shifts the ray inwards by less than a millimetre of the 30.
  EXPECT_NEAR(limits.left.gaze, std::atan(10.0 / 30.0), 0.02);
  EXPECT_GT(limits.left.gaze, std::atan(10.0 / 30.0));
  EXPECT_NEAR(limits.left.beside, std::atan(100.0 / 30.0), 1e-6);  // past the wall
  EXPECT_FALSE(std::isnan(limits.right.beside));
  const FieldPoint blocked = FieldPointAt(SightOf(*form, 60.0, &before), Goal(0.0), Left(25.0));
  EXPECT_EQ(blocked.path, SightPath::kFrame);
  EXPECT_TRUE(std::isnan(blocked.worst_error) && std::isnan(blocked.thickness) && std::isnan(blocked.object.left));
}

TEST(LensField, WithinIsTheOutline) {
  const LensOutline outline = test::Rectangle(50.0, 30.0);
  const LensSight sight(SphericalLens(4.0, -2.0, 1.5, 2.0), outline, {}, nullptr);
  EXPECT_TRUE(sight.Within({24.99, 14.99}));
  EXPECT_TRUE(sight.Within({-24.99, -14.99}));
  EXPECT_TRUE(sight.Within({-24.99, 0.0}));
  EXPECT_FALSE(sight.Within({25.01, 0.0}));
  EXPECT_FALSE(sight.Within({-25.01, 0.001}));
  EXPECT_FALSE(sight.Within({24.99, -15.01}));
  EXPECT_FALSE(sight.Within({std::nan(""), 0.0}));
}

TEST(LensField, TheGridRunsFromUpLeftAndCountsBothEnds) {
  FieldGrid grid;
  grid.most_left = grid.most_right = RadiansFromDegrees(20.0);
  grid.most_up = grid.most_down = RadiansFromDegrees(10.0);
  grid.step = RadiansFromDegrees(5.0);
  const LensField field = LensFieldOf(SightOf(SphericalLens(4.0, -4.0, 1.6, 2.0)), Goal(-4.0), grid);
  EXPECT_EQ(grid.columns(), 9);
  EXPECT_EQ(grid.rows(), 5);
  ASSERT_EQ(field.points.size(), 45U);
  EXPECT_NEAR(field.At(0, 0).gaze.left, RadiansFromDegrees(20.0), 1e-12);
  EXPECT_NEAR(field.At(0, 0).gaze.up, RadiansFromDegrees(10.0), 1e-12);
  EXPECT_NEAR(field.At(8, 4).gaze.left, RadiansFromDegrees(-20.0), 1e-12);
  EXPECT_NEAR(field.At(4, 2).worst_error, 0.0, 1e-9);
  const FieldShares shares = SharesOf(field);
  EXPECT_GT(shares.one, 0.9);
  EXPECT_LE(shares.quarter, shares.half);
  EXPECT_LE(shares.half, shares.one);
}

TEST(LensField, GazeAndDirectionAreEachOthersInverse) {
  const Gaze gaze{0.4, -0.7};
  const Gaze back = GazeAlong(3.0 * DirectionOf(gaze));
  EXPECT_NEAR(back.left, gaze.left, 1e-14);
  EXPECT_NEAR(back.up, gaze.up, 1e-14);
  EXPECT_NEAR((ViewFromTurned(gaze).col(2) - DirectionOf(gaze)).norm(), 0.0, 1e-14);
}

}  // namespace
}  // namespace annulus
