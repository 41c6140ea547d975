#include "render/overlay.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/scalar_map.h"
#include "shapes.h"

namespace annulus {
namespace {

/// A ball of radius 100 mm about the origin, seen from the front at 1 mm per pixel.
RgbImage BallPicture(const Camera& camera) {
  MapPictureOptions options;
  options.width = 240;
  options.height = 240;
  options.threads = 1;
  return RenderScalarMap({{SphereMesh({0, 0, 0}, 100.0, 180), {}, {}}}, {}, camera, options, {})->image;
}

TEST(Overlay, PutsPointsWhereTheCameraSeesThem) {
  const Camera camera = FrontCamera(500.0, 240);
  const RgbImage picture = BallPicture(camera);
  const Overlay overlay(camera, picture);
  const auto point = overlay.Project({30.0, 40.0, 50.0});  // the picture's right is -x
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(point->at.x(), 120.0 - 30.0, 1e-9);
  EXPECT_NEAR(point->at.y(), 120.0 - 50.0, 1e-9);
  EXPECT_NEAR(point->depth, 460.0, 1e-9);
  EXPECT_FALSE(overlay.Project({0.0, 600.0, 0.0}).has_value());  // behind the eye
}

TEST(Overlay, PerspectiveAgreesWithSimilarTriangles) {
  Camera camera = FrontCamera(500.0, 240);
  camera.projection = Projection::kPerspective;
  camera.half_height = 0.3;
  const RgbImage picture = BallPicture(FrontCamera(500.0, 240));
  const auto point = Overlay(camera, picture).Project({0.0, 100.0, 60.0});
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(point->at.y(), 120.0 - 120.0 * 60.0 / (400.0 * 0.3), 1e-9);
}

TEST(Overlay, HidesTheFarHalfOfAnEquator) {
  const Camera camera = FrontCamera(500.0, 240);
  const RgbImage picture = BallPicture(camera);
  const Overlay overlay(camera, picture);
  std::vector<Eigen::Vector3d> equator;
  for (int k = 0; k <= 360; ++k) {
    equator.push_back(100.0 * Eigen::Vector3d(std::cos(k * kPi / 180.0), std::sin(k * kPi / 180.0), 0.0));
  }
  double seen = 0.0;
  double hidden = 0.0;
  for (const OverlayRun& run : overlay.Runs(equator)) {
    for (std::size_t k = 0; k + 1 < run.points.size(); ++k) {
      (run.visible ? seen : hidden) += (run.points[k + 1] - run.points[k]).norm();
    }
  }
  // Each half is as long as the ball is wide. Within the tolerance of 4 mm of depth, and one pixel beside the outline,
  // the far half still counts as seen: it leaves the near half at y = 0 and is 4 mm behind at x = 99.8.
  EXPECT_NEAR(seen + hidden, 400.0, 1.0);
  EXPECT_NEAR(seen, 200.0, 6.0);
  EXPECT_NEAR(hidden, 200.0, 6.0);
}

TEST(Overlay, PartsALineThatLeavesTheEye) {
  const Camera camera = FrontCamera(500.0, 240);
  const RgbImage picture = BallPicture(camera);
  const auto runs =
      Overlay(camera, picture).Runs({{50, 110, 0}, {40, 110, 0}, {30, 700, 0}, {20, 110, 0}, {10, 110, 0}});
  ASSERT_EQ(runs.size(), 2U);
  for (const OverlayRun& run : runs) {
    EXPECT_TRUE(run.visible);
    for (const Eigen::Vector2d& p : run.points) EXPECT_TRUE(p.allFinite());
  }
}

TEST(SpreadLabels, MovesThreeOnOnePlaceApartAboutIt) {
  const std::vector<double> placed = SpreadLabels({10.0, 10.0, 10.0}, 4.0, 0.0, 100.0);
  EXPECT_EQ(placed, (std::vector<double>{6.0, 10.0, 14.0}));
}

TEST(SpreadLabels, LeavesWhatIsFarApartAndKeepsTheOrderGiven) {
  const std::vector<double> placed = SpreadLabels({50.0, 10.0, 11.0}, 4.0, 0.0, 100.0);
  EXPECT_DOUBLE_EQ(placed[0], 50.0);
  EXPECT_DOUBLE_EQ(placed[1], 8.5);  // 10 and 11 share their two ways: 1.5 mm each
  EXPECT_DOUBLE_EQ(placed[2], 12.5);
}

TEST(SpreadLabels, StaysBetweenTheEnds) {
  const std::vector<double> placed = SpreadLabels({0.0, 1.0, 99.0, 100.0}, 10.0, 5.0, 95.0);
  EXPECT_EQ(placed, (std::vector<double>{5.0, 15.0, 85.0, 95.0}));
}

TEST(SpreadLabels, NeverOverlapsWhateverIsWanted) {
  std::vector<double> wanted;
  for (int k = 0; k < 40; ++k) wanted.push_back(50.0 + 40.0 * std::sin(7.3 * k));
  std::vector<double> placed = SpreadLabels(wanted, 2.0, 0.0, 100.0);
  std::sort(placed.begin(), placed.end());
  for (std::size_t k = 0; k + 1 < placed.size(); ++k) EXPECT_GE(placed[k + 1] - placed[k], 2.0 - 1e-9);
  EXPECT_GE(placed.front(), 0.0);
  EXPECT_LE(placed.back(), 100.0);
}

}  // namespace
}  // namespace annulus
