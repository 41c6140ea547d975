// Closed forms without noise, on splines that interpolate them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "modeling/measure/section.h"
#include "modeling/measure/slab.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

/// A closed form between two heights, and what is known of it.
///
/// import numpy as np; from scipy.integrate import quad, dblquad; from scipy.special import ellipe
struct Band {
  std::string name;
  test::RadiusFunction radius;
  std::size_t columns;
  double z_min;
  double z_max;
  std::size_t rows;
  double area;
  double volume;
};

/// Semi-axes a = 160 (x), b = 110 (y), c = 300 (z), |z| <= 0.8 c.
/// volume = np.pi*a*b*(2*h - 2*h**3/(3*c*c)) with h = 0.8*c
/// area: with t the angle of the ellipse's parameter, x = a s cos t, y = b s sin t, s = sqrt(1 - z²/c²):
///   f = lambda t, z: np.sqrt((1-z*z/c/c)*(a*a*np.sin(t)**2 + b*b*np.cos(t)**2) + (a*b*z/c/c)**2)
///   8*dblquad(f, 0, h, 0, np.pi/2, epsabs=1e-9, epsrel=1e-12)[0]
Band Ellipsoid() {
  const double a = 160.0;
  const double b = 110.0;
  const double c = 300.0;
  return {"ellipsoid",
          [=](double theta, double z) {
            return std::sqrt(1.0 - z * z / (c * c)) / std::hypot(std::cos(theta) / a, std::sin(theta) / b);
          },
          720,
          -0.8 * c,
          0.8 * c,
          480,
          371629.540250,
          20878270.793521};
}

/// The outer half of a torus, R = 200 from the axis to the tube's middle, tube a = 80, |z| <= 0.8 a = h:
/// r = R + sqrt(a² − z²).
/// area = 4*np.pi*a*(R*np.arcsin(h/a) + h)
/// volume = 2*np.pi*(R*R*h + R*(h*np.sqrt(a*a-h*h) + a*a*np.arcsin(h/a)) + a*a*h - h**3/3)
Band OuterTorus() {
  const double big = 200.0;
  const double a = 80.0;
  return {"outer torus",
          [=](double, double z) { return big + std::sqrt(a * a - z * z); },
          36,
          -0.8 * a,
          0.8 * a,
          480,
          250783.583599,
          29427653.673342};
}

/// Circles of radius a = 120 about a centre that moves by k = 0.15 mm along x per mm of height, |z| <= 200: a sheared
/// cylinder. Area, with t about the moving centre: ∫∫ a √(1 + k² cos² t) dt dz.
/// volume = np.pi*a*a*400; area = 400*a*4*ellipe(-k*k)
constexpr double kShear = 0.15;
constexpr double kSheared = 120.0;
Band ShearedCylinder() {
  return {"sheared cylinder",
          [](double theta, double z) {
            const double centre = kShear * z;
            const double across = centre * std::sin(theta);
            return centre * std::cos(theta) + std::sqrt(kSheared * kSheared - across * across);
          },
          360,
          -200.0,
          200.0,
          200,
          303282.264119,
          18095573.684677};
}

SurfaceModel ModelOf(const Band& band) {
  return test::InterpolatedBody(band.radius, band.columns, UniformBreakpoints(band.z_min, band.z_max, band.rows));
}

class Bands : public testing::TestWithParam<Band> {};

TEST_P(Bands, AreInterpolatedToOneInAHundredMillion) {
  const Band& band = GetParam();
  const SurfaceModel model = ModelOf(band);
  double worst = 0.0;
  for (int i = 0; i < 997; ++i) {  // places between the knots, by irrational steps
    const double theta = kTwoPi * std::fmod(0.6180339887 * i, 1.0);
    const double z = band.z_min + (band.z_max - band.z_min) * std::fmod(0.4142135624 * i, 1.0);
    const double exact = band.radius(theta, z);
    worst = std::max(worst, std::abs(model.main().surface.Radius(theta, z) - exact) / exact);
  }
  EXPECT_LE(worst, 1e-8);
}

TEST_P(Bands, HaveTheirAreaAndVolume) {
  const Band& band = GetParam();
  const SurfaceModel model = ModelOf(band);
  const auto slab = SlabBetween(*MeasuredSurface::FromModel(model), band.z_min, band.z_max);
  ASSERT_TRUE(slab.has_value());
  EXPECT_NEAR(slab->volume.value / band.volume, 1.0, 1e-8);
  EXPECT_NEAR(slab->area.value / band.area, 1.0, 1e-8);
}

TEST_P(Bands, AreTheSumOfTheirParts) {
  // Cut between knots: nothing is lost where a patch is cut.
  const Band& band = GetParam();
  const SurfaceModel model = ModelOf(band);
  const MeasuredSurface body = *MeasuredSurface::FromModel(model);
  const double cut = band.z_min + 0.3183098862 * (band.z_max - band.z_min);
  const auto lower = SlabBetween(body, band.z_min, cut);
  const auto upper = SlabBetween(body, cut, band.z_max);
  ASSERT_TRUE(lower && upper);
  EXPECT_NEAR((lower->volume.value + upper->volume.value) / band.volume, 1.0, 1e-8);
  EXPECT_NEAR((lower->area.value + upper->area.value) / band.area, 1.0, 1e-8);
}

INSTANTIATE_TEST_SUITE_P(ClosedForms, Bands, testing::Values(Ellipsoid(), OuterTorus(), ShearedCylinder()),
                         [](const auto& tested) {
                           std::string name = tested.param.name;
                           name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
                           return name;
                         });

TEST(BandSections, OfTheEllipsoidAreEllipses) {
  // At height z the semi-axes are a s and b s, s = sqrt(1 - z²/c²): 4*a*s*ellipe(1 - (b/a)**2), pi a b s².
  const Band band = Ellipsoid();
  const SurfaceModel model = ModelOf(band);
  const MeasuredSurface body = *MeasuredSurface::FromModel(model);
  for (const double z : {-200.0, 0.0, 77.7, 239.0}) {
    const double square = 1.0 - z * z / 9e4;
    const double perimeter = 855.5179439985 * std::sqrt(square);  // of the section at z = 0: 4*a*ellipe(1-(b/a)**2)
    const auto section = SectionAt(body, z);
    ASSERT_TRUE(section.has_value());
    EXPECT_NEAR(section->perimeter.value / perimeter, 1.0, 1e-6) << z;
    EXPECT_NEAR(section->area.value / (kPi * 160.0 * 110.0 * square), 1.0, 1e-6) << z;
    EXPECT_NEAR(section->tape.value / perimeter, 1.0, 1e-6) << z;
  }
}

TEST(BandSections, OfTorusAndShearedCylinderAreCircles) {
  for (const Band& band : {OuterTorus(), ShearedCylinder()}) {
    const SurfaceModel model = ModelOf(band);
    const MeasuredSurface body = *MeasuredSurface::FromModel(model);
    for (const double share : {0.0, 0.31, 0.5, 0.77, 1.0}) {
      const double z = band.z_min + share * (band.z_max - band.z_min);
      const double radius = band.name == "outer torus" ? band.radius(0.0, z) : kSheared;
      const auto section = SectionAt(body, z);
      ASSERT_TRUE(section.has_value());
      EXPECT_NEAR(section->perimeter.value / (kTwoPi * radius), 1.0, 1e-6) << band.name << z;
      EXPECT_NEAR(section->area.value / (kPi * radius * radius), 1.0, 1e-6) << band.name << z;
      EXPECT_NEAR(section->tape.value / (kTwoPi * radius), 1.0, 1e-6) << band.name << z;
    }
  }
}

}  // namespace
}  // namespace annulus
