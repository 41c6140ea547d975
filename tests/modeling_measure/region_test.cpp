#include "modeling/measure/region.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;
using testing::HasSubstr;

SurfaceModel Cylinder() {
  return InterpolatedBody([](double, double) { return 90.0; }, 12, UniformBreakpoints(0.0, 200.0, 10));
}

/// Radius 100 about (5, -3, 100), |z - 100| <= 80; the axis is inside.
SurfaceModel Sphere() {
  return InterpolatedBody(
      [](double t, double z) {
        const double along = 5.0 * std::cos(t) - 3.0 * std::sin(t);
        return along + std::sqrt(along * along + 1e4 - (z - 100.0) * (z - 100.0) - 34.0);
      },
      360, UniformBreakpoints(20.0, 180.0, 640));
}

SurfaceModel Bumpy() {
  return InterpolatedBody(
      [](double t, double z) {
        return 100.0 + 12.0 * std::cos(2.0 * t + 0.02 * z) + 4.0 * std::sin(5.0 * t) * std::cos(0.07 * z);
      },
      36, UniformBreakpoints(0.0, 200.0, 25));
}

struct Numbers {
  double area = 0.0;
  double volume = 0.0;
};

/// The way from A to B over C on a sphere about the origin: a circle about `axis`, at `height` along it.
struct Arc {
  /// About `around`, which points along or against the plane's normal.
  Arc(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& around)
      : axis(around), height(around.dot(a)), angle(AngleOf(a, b)), radius((a - height * axis).norm()) {
    start = axis.cross(a).normalized();
    end = axis.cross(b).normalized();
  }
  static Arc Over(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const Eigen::Vector3d normal = (a - c).cross(b - c).normalized();
    const Arc one(a, b, normal);
    return one.AngleOf(a, c) < one.angle ? one : Arc(a, b, -normal);
  }
  /// How far p is from a, turning left about the axis.
  [[nodiscard]] double AngleOf(const Eigen::Vector3d& a, const Eigen::Vector3d& p) const {
    const Eigen::Vector3d u = (a - height * axis).normalized();
    const double at = std::atan2(p.dot(axis.cross(u)), p.dot(u));
    return at < 0.0 ? at + kTwoPi : at;
  }
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  double height = 0.0;
  double angle = 0.0;
  double radius = 0.0;
  Eigen::Vector3d start = Eigen::Vector3d::Zero();  // tangents
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
  [[nodiscard]] double SegmentArea() const { return 0.5 * radius * radius * (angle - std::sin(angle)); }
};

double Turn(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& normal) {
  return std::atan2(normal.dot(from.cross(to)), from.dot(to));
}

/// Gauss–Bonnet on the sphere of radius R about the origin, region left of A→C→B→D→A: area/R² = 2π - Σ turns - ∫ k_g,
/// where a circle of height h about its axis has ∫ k_g = h·angle/R. Volume = cone over the skin and cones over the
/// circle segments in the planes, from the centre.
Numbers LeftOfLoop(double R, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Arc& over_c, const Arc& over_d) {
  Numbers n;
  const double turns = Turn(over_c.end, -over_d.end, b / R) + Turn(-over_d.start, over_c.start, a / R);
  const double curvature = (over_c.height * over_c.angle - over_d.height * over_d.angle) / R;
  n.area = R * R * (kTwoPi - turns - curvature);
  n.volume = (R * n.area - over_c.height * over_c.SegmentArea() + over_d.height * over_d.SegmentArea()) / 3.0;
  return n;
}

Numbers OnSphere(double R, const std::array<Eigen::Vector3d, 4>& p) {
  const Arc over_c = Arc::Over(p[0], p[1], p[2]);
  const Arc over_d = Arc::Over(p[0], p[1], p[3]);
  const Numbers one = LeftOfLoop(R, p[0], p[1], over_c, over_d);
  const Numbers other = LeftOfLoop(R, p[0], p[1], over_d, over_c);
  return one.area < other.area ? one : other;  // the region is the smaller part
}

TEST(Region, OfASphereIsByGaussAndBonnet) {
  const SurfaceModel model = Sphere();
  const auto body = MeasuredSurface::FromModel(model);
  const Eigen::Vector3d centre(5.0, -3.0, 100.0);
  const std::vector<RegionClicks> cases{
      {{0.5, 60.0}, {1.4, 140.0}, {0.3, 120.0}, {1.5, 85.0}},
      {{0.2, 100.0}, {1.9, 100.0}, {1.0, 150.0}, {1.1, 55.0}},    // over the equator
      {{-0.4, 90.0}, {0.6, 110.0}, {0.1, 140.0}, {0.15, 115.0}},  // across theta = 0, both cuts on one side of AB
      {{2.9, 95.0}, {3.1, 105.0}, {2.92, 107.0}, {3.08, 93.0}},   // small
  };
  for (const RegionClicks& k : cases) {
    std::array<Eigen::Vector3d, 4> p;
    const std::array<SurfacePlace, 4> places{k.a, k.b, k.c, k.d};
    for (std::size_t i = 0; i < 4; ++i) p[i] = body->Point(places[i].theta, places[i].z) - centre;
    const Numbers truth = OnSphere(100.0, p);
    const auto region = RegionBetween(*body, k);
    ASSERT_TRUE(region.has_value()) << region.error().Text();
    EXPECT_NEAR(region->area.value, truth.area, 1e-6 * truth.area);
    EXPECT_NEAR(region->volume.value, truth.volume, 1e-6 * truth.volume);
    EXPECT_NEAR(region->knowledge.measured, 1.0, 1e-9);
  }
}

TEST(Region, OfACylinderIsTheWedgeOverACircleSegment) {
  // Planes z = 100 ± k (x - 90 cos alpha) meet in the chord theta = ±alpha, z = 100. With s, c = sin, cos alpha:
  // skin = 2k·90²·2 (s - alpha c), volume = 2k·90³ (2 s³/3 - c (alpha - s c)).
  const SurfaceModel model = Cylinder();
  const auto body = MeasuredSurface::FromModel(model);
  for (const double alpha : {0.4, 1.0, 1.4}) {
    for (const double k : {0.3, 0.9}) {
      const auto on = [&](double theta, double slope) {
        return SurfacePlace{theta, 100.0 + slope * 90.0 * (std::cos(theta) - std::cos(alpha))};
      };
      const auto region =
          RegionBetween(*body, {on(-alpha, 0.0), on(alpha, 0.0), on(0.1 * alpha, k), on(-0.3 * alpha, -k)});
      ASSERT_TRUE(region.has_value()) << region.error().Text();
      const double s = std::sin(alpha);
      const double c = std::cos(alpha);
      const double skin = 2.0 * k * 8100.0 * 2.0 * (s - alpha * c);
      const double volume = 2.0 * k * 729000.0 * (2.0 / 3.0 * s * s * s - c * (alpha - s * c));
      EXPECT_NEAR(region->area.value, skin, 1e-8 * skin);
      EXPECT_NEAR(region->volume.value, volume, 1e-7 * volume);
    }
  }
}

TEST(Region, OfAHollowHasNegativeVolume) {
  // The skin dips by up to 10 mm around theta = 1, z = 100, below both planes through points on its rim.
  const SurfaceModel model = InterpolatedBody(
      [](double t, double z) {
        const double d = AngleDifference(t, 1.0);
        return 1000.0 - 30.0 * std::exp(-(d * d * 1e6 + (z - 100.0) * (z - 100.0)) / 1800.0);
      },
      360, UniformBreakpoints(0.0, 200.0, 80));
  const auto body = MeasuredSurface::FromModel(model);
  const auto region = RegionBetween(*body, {{1.0, 80.0}, {1.0, 120.0}, {0.985, 100.0}, {1.015, 100.0}});
  ASSERT_TRUE(region.has_value()) << region.error().Text();
  EXPECT_GT(region->area.value, 0.0);
  EXPECT_LT(region->volume.value, 0.0);
}

TEST(Region, IsTheSameInWhateverOrderItIsClicked) {
  const SurfaceModel model = Bumpy();
  const auto body = MeasuredSurface::FromModel(model);
  const SurfacePlace a{0.3, 95.0};
  const SurfacePlace b{1.5, 105.0};
  const SurfacePlace c{0.8, 112.0};
  const SurfacePlace d{1.1, 92.0};
  const auto first = RegionBetween(*body, {a, b, c, d});
  ASSERT_TRUE(first.has_value()) << first.error().Text();
  EXPECT_GT(first->area.value, 0.0);
  EXPECT_GT(first->volume.value, 0.0);
  for (const RegionClicks& other : {RegionClicks{b, a, c, d}, RegionClicks{a, b, d, c}, RegionClicks{b, a, d, c}}) {
    const auto region = RegionBetween(*body, other);
    ASSERT_TRUE(region.has_value());
    EXPECT_NEAR(region->area.value, first->area.value, 1e-8 * first->area.value);
    EXPECT_NEAR(region->volume.value, first->volume.value, 1e-8 * first->volume.value);
  }
}

TEST(Region, IsTheSumOfItsPartsOrSaysWhyNot) {
  // Three planes through A and B: what lies between the outer ones is what lies on either side of the middle one.
  const SurfaceModel model = Bumpy();
  const auto body = MeasuredSurface::FromModel(model);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> theta(0.0, 1.5);
  std::uniform_real_distribution<double> z(20.0, 180.0);
  std::uniform_real_distribution<double> level(85.0, 115.0);
  int whole_ones = 0;
  for (int k = 0; k < 150; ++k) {
    // Every third case anywhere, the others such that most enclose something.
    const bool anywhere = k % 3 == 0;
    const double turn = theta(random);
    const SurfacePlace a{anywhere ? theta(random) : turn - 0.7, anywhere ? z(random) : level(random)};
    const SurfacePlace b{anywhere ? theta(random) : turn + 0.7, anywhere ? z(random) : level(random)};
    std::array<SurfacePlace, 3> third;
    for (SurfacePlace& place : third) place = {turn + 0.4 * (theta(random) - 0.75), z(random)};
    const std::array<Result<RegionEstimates>, 3> parts{RegionBetween(*body, {a, b, third[0], third[1]}),
                                                       RegionBetween(*body, {a, b, third[1], third[2]}),
                                                       RegionBetween(*body, {a, b, third[2], third[0]})};
    for (const auto& part : parts) {
      EXPECT_TRUE(part.has_value() || !part.error().seen.empty());
    }
    if (!parts[0] || !parts[1] || !parts[2]) continue;
    ++whole_ones;
    std::array<double, 3> areas{};
    std::array<double, 3> volumes{};
    for (std::size_t i = 0; i < 3; ++i) {
      areas[i] = parts[i]->area.value;
      volumes[i] = parts[i]->volume.value;
      EXPECT_GT(areas[i], 0.0);
    }
    const auto largest = static_cast<std::size_t>(std::max_element(areas.begin(), areas.end()) - areas.begin());
    const double area = areas[(largest + 1) % 3] + areas[(largest + 2) % 3];
    const double volume = volumes[(largest + 1) % 3] + volumes[(largest + 2) % 3];
    EXPECT_NEAR(areas[largest], area, 1e-6 * area) << k;
    EXPECT_NEAR(volumes[largest], volume, 1e-6 * std::abs(volume) + 1e-3) << k;
  }
  EXPECT_GT(whole_ones, 30);
}

TEST(Region, TellsWhatIsWrong) {
  const SurfaceModel model = Cylinder();
  const auto body = MeasuredSurface::FromModel(model);
  const auto says = [&](const RegionClicks& clicks) {
    const auto region = RegionBetween(*body, clicks);
    return region ? std::string("nothing") : region.error().Text();
  };
  EXPECT_THAT(says({{0.0, 50.0}, {1.0, 50.0}, {0.4, 50.0}, {0.6, 50.0}}), HasSubstr("A, B, C and D lie in one plane"));
  EXPECT_THAT(says({{0.0, 50.0}, {0.0, 50.0}, {0.4, 90.0}, {0.6, 20.0}}), HasSubstr("A and B are the same point"));
  EXPECT_THAT(says({{0.0, 50.0}, {1.0, 50.0}, {0.0, 50.0}, {0.6, 20.0}}), HasSubstr("A and C are the same point"));
  EXPECT_THAT(says({{0.0, 50.0}, {1.0, 50.0}, {0.4, 90.0}, {1.0, 50.0}}), HasSubstr("B and D are the same point"));
  EXPECT_THAT(says({{0.0, 50.0}, {0.0, 90.0}, {0.0, 70.0}, {1.0, 50.0}}), HasSubstr("lie on one line"));
  EXPECT_THAT(says({{0.0, 50.0}, {1.0, 50.0}, {0.5, 60.0}, {3.5, 60.0}}), HasSubstr("around the body"));
  EXPECT_THAT(says({{0.0, 50.0}, {1.0, 50.0}, {0.5, 190.0}, {0.5, -20.0}}), HasSubstr("D: z = -20"));
  EXPECT_THAT(says({{0.0, 10.0}, {0.2, 12.0}, {1.6, 190.0}, {0.1, 40.0}}), HasSubstr("leaves the scanned range"));
}

TEST(Region, RefusesWhatWasNotSeenAndTellsTheShareThatWasMeasured) {
  SurfaceModel model = Cylinder();
  const RegionClicks clicks{{0.0, 95.0}, {1.0, 105.0}, {0.5, 140.0}, {0.5, 60.0}};
  KnowledgeMap& map = model.segments.front().knowledge;  // 36 columns, rows of 5 mm
  map.SetCell(3, 20, Knowledge::kUnknown);               // theta 30 deg, z 100 … 105: inside
  const auto over = RegionBetween(*MeasuredSurface::FromModel(model), clicks);
  ASSERT_FALSE(over.has_value());
  EXPECT_THAT(over.error().Text(), HasSubstr("was not seen"));
  map.SetCell(3, 20, Knowledge::kInferred);
  const auto region = RegionBetween(*MeasuredSurface::FromModel(model), clicks);
  ASSERT_TRUE(region.has_value());
  const double cell = 5.0 * 90.0 * kTwoPi / 36.0;
  EXPECT_NEAR(region->knowledge.measured, 1.0 - cell / region->area.value, 1e-3);
}

TEST(RegionGradient, IsThatOfCentralDifferences) {
  const SurfaceModel model = Bumpy();
  const SplineSurface& surface = model.main().surface;
  const RegionClicks clicks{{0.3, 95.0}, {1.5, 105.0}, {0.8, 112.0}, {1.1, 92.0}};
  const auto region = RegionBetween(*MeasuredSurface::FromModel(model), clicks);
  ASSERT_TRUE(region.has_value());
  const Eigen::VectorXd by_area = region->area.gradient;
  const Eigen::VectorXd by_volume = region->volume.gradient;
  constexpr double kStep = 1e-3;
  double area_error = 0.0;
  double volume_error = 0.0;
  for (Eigen::Index k = 0; k < by_area.size(); k += 7) {
    std::array<Numbers, 2> n;
    for (const int side : {0, 1}) {
      Eigen::VectorXd c = surface.coefficients();
      c[k] += side == 0 ? -kStep : kStep;
      SurfaceModel moved;
      moved.segments.push_back(
          {"body", {surface.theta_basis(), surface.z_basis(), c}, model.main().knowledge, {}, {}, {}});
      const auto at = RegionBetween(*MeasuredSurface::FromModel(moved), clicks);
      ASSERT_TRUE(at.has_value());
      n[static_cast<std::size_t>(side)] = {at->area.value, at->volume.value};
    }
    area_error = std::max(area_error, std::abs((n[1].area - n[0].area) / (2.0 * kStep) - by_area[k]));
    volume_error = std::max(volume_error, std::abs((n[1].volume - n[0].volume) / (2.0 * kStep) - by_volume[k]));
  }
  EXPECT_LT(area_error, 1e-4 * by_area.cwiseAbs().maxCoeff());
  EXPECT_LT(volume_error, 1e-4 * by_volume.cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace annulus
