#include "render/gaze_chart.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

float Grey(const GazeScene& scene, double left_mm, double up_mm, double spot = 1e-4) {
  return scene.Light({left_mm, up_mm, kChartDistance}, spot).mean();
}

TEST(GazeChart, ALandoltRingOfAcuityOneHasAGapOfOneMinute) {
  // 5 · 6 m · tan 1' = 8.7266 mm.
  EXPECT_NEAR(LandoltDiameter(1.0), 8.72665, 1e-4);
  EXPECT_NEAR(LandoltDiameter(0.1), 87.2665, 1e-3);
}

TEST(GazeChart, APictureIsReadBetweenItsTexelsAndCoarselyFromItsSmallerCopies) {
  const LinearRgb black = LinearRgb::Zero();
  const LinearRgb white = LinearRgb::Ones();
  const WallPicture picture(2, 2, {black, white, white, white});
  EXPECT_EQ(picture.At(0.5, 0.5, 1.0), black);
  EXPECT_EQ(picture.At(1.5, 0.5, 0.1), white);
  EXPECT_NEAR(picture.At(1.0, 0.5, 1.0).x(), 0.5, 1e-6);
  EXPECT_NEAR(picture.At(0.5, 0.5, 2.0).x(), 0.75, 1e-6);
  EXPECT_NEAR(picture.At(0.5, 0.5, 1e9).x(), 0.75, 1e-6);
  EXPECT_NEAR(picture.At(0.5, 0.5, std::sqrt(2.0)).x(), 0.375, 1e-6);  // half way between the two
  EXPECT_EQ(picture.At(-50.0, -50.0, 1.0), black);                     // the edge goes on
  const WallPicture odd(3, 1, {black, black, white});
  EXPECT_EQ(odd.At(2.5, 0.5, 1.0), white);
  EXPECT_TRUE(odd.At(1.0, 0.3, 4.0).allFinite());
}

TEST(GazeChart, TheGridHasALineEveryHalfMetreAtSixMetres) {
  const GazeScene scene = GazeScene::Make(GazeSceneKind::kGrid);
  for (const int k : {-6, -4, -2, -1, 1, 3, 4, 7}) {
    EXPECT_LT(Grey(scene, 500.0 * k, 250.0), 0.55F) << k;
    EXPECT_GT(Grey(scene, 500.0 * k + 170.0 * (k > 0 ? 1 : -1), 250.0), 0.85F) << k;
  }
  EXPECT_LT(Grey(scene, 170.0 + 500.0, 500.0), 0.55F);
}

TEST(GazeChart, TheLargestRingsAreUpOnTheBoard) {
  const GazeScene scene = GazeScene::Make(GazeSceneKind::kShop);
  float upper = 0.0F;
  float lower = 0.0F;
  for (double x = -300.0; x <= 300.0; x += 10.0) {
    for (double y = 20.0; y <= 470.0; y += 10.0) {
      upper += Grey(scene, x, y, 2e-3);
      lower += Grey(scene, x, -y, 2e-3);
    }
  }
  EXPECT_LT(upper, 0.95F * lower);  // more ink
}

TEST(GazeChart, TheShopsWindowIsAtTheWearersRight) {
  const GazeScene scene = GazeScene::Make(GazeSceneKind::kShop);
  const double wide = 0.3;  // rad
  const LinearRgb left = scene.Light({1.0, 0.1, 1.0}, wide);
  const LinearRgb right = scene.Light({-1.0, 0.1, 1.0}, wide);
  EXPECT_GT(right.z() / right.x(), left.z() / left.x());  // bluer
}

TEST(GazeChart, EveryDirectionHasFiniteLight) {
  for (const GazeSceneKind kind : {GazeSceneKind::kShop, GazeSceneKind::kGrid}) {
    const GazeScene scene = GazeScene::Make(kind);
    for (int i = 0; i < 2000; ++i) {
      const double z = 1.0 - (i + 0.5) / 1000.0;
      const double around = 2.399963 * i;
      const double across = std::sqrt(1.0 - z * z);
      const LinearRgb light = scene.Light({across * std::cos(around), across * std::sin(around), z}, 1e-3);
      ASSERT_TRUE(light.allFinite() && light.minCoeff() >= 0.0F && light.maxCoeff() <= 1.0F) << i;
    }
    ASSERT_TRUE(scene.Light({0.0, 0.0, 0.0}, 1e-3).allFinite());
  }
}

}  // namespace
}  // namespace annulus
