#include "render/scalar_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/png.h"
#include "shapes.h"

namespace annulus {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A ball of radius 100 mm whose value is the height of the place.
MapMesh HeightOnBall() {
  MapMesh ball;
  ball.mesh = SphereMesh({0, 0, 0}, 100.0, 180);
  for (const Eigen::Vector3d& p : ball.mesh.vertices) {
    ball.values.push_back(p.z());
    ball.normals.push_back(p.normalized());
  }
  return ball;
}

MapPictureOptions Small(int size) {
  MapPictureOptions options;
  options.width = size;
  options.height = size;
  options.supersampling = 2;
  options.threads = 1;
  return options;
}

TEST(ScalarMap, TheColourOfAPixelReadsBackToTheHeightThereOnABall) {
  const MapColours colours{{ColourMap::kDiverging, -100.0, 100.0}};
  const auto picture = RenderScalarMap({HeightOnBall()}, colours, FrontCamera(500.0, 240), Small(240), {});
  ASSERT_TRUE(picture.has_value());
  const auto bytes = DecodePng(EncodePng(picture->image).value());
  ASSERT_TRUE(bytes.has_value());
  for (int y = 25; y < 215; y += 3) {
    for (int x = 25; x < 215; x += 3) {
      const double z = 119.5 - y;  // 1 mm per pixel, the middle of the picture is z = 0
      if (std::hypot(x - 119.5, z) > 94.0) continue;
      const double read = colours.scale.ValueOf(bytes->rgb[bytes->Index(x, y)]);
      // 1 % of the scale's length of 200 mm for the bytes, half a millimetre for the pixel's size.
      EXPECT_NEAR(read, z, 2.5) << x << " " << y;
      EXPECT_NEAR(static_cast<double>(picture->value[bytes->Index(x, y)]), z, 0.6) << x << " " << y;
    }
  }
}

TEST(ScalarMap, KeepsDepthAndCoverOfTheBody) {
  const auto picture = RenderScalarMap({HeightOnBall()}, {}, FrontCamera(500.0, 240), Small(240), {});
  ASSERT_TRUE(picture.has_value());
  const RgbImage& image = picture->image;
  EXPECT_NEAR(static_cast<double>(image.depth[image.Index(120, 120)]), 400.0, 0.1);  // the front of the ball
  EXPECT_FLOAT_EQ(image.alpha[image.Index(120, 120)], 1.0F);
  EXPECT_FLOAT_EQ(image.alpha[image.Index(2, 2)], 0.0F);
  EXPECT_EQ(image.depth[image.Index(2, 2)], kNoDepth);
  EXPECT_EQ(image.rgb[image.Index(2, 2)], LinearRgb(1.0F, 1.0F, 1.0F));
  EXPECT_TRUE(std::isnan(picture->value[image.Index(2, 2)]));
  double area = 0.0;
  for (const float share : image.alpha) area += static_cast<double>(share);
  EXPECT_NEAR(area, kPi * 1e4, 0.003 * kPi * 1e4);
}

TEST(ScalarMap, LightTakesAtMostFifteenPercentOfAColour) {
  const MapColours colours{{ColourMap::kSequential, -100.0, 100.0}};
  MapMesh ball = HeightOnBall();
  for (double& value : ball.values) value = 50.0;  // exactly a step of any palette
  const auto picture = RenderScalarMap({ball}, colours, FrontCamera(500.0, 240), Small(240), {});
  ASSERT_TRUE(picture.has_value());
  const LinearRgb pure = colours.scale.ColourOf(50.0);
  float darkest = 1.0F;
  float brightest = 0.0F;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 240; ++x) {
      if (std::hypot(x - 119.5, y - 119.5) > 94.0) continue;
      const LinearRgb& rgb = picture->image.rgb[picture->image.Index(x, y)];
      const float shade = rgb[1] / pure[1];
      EXPECT_LT((rgb - shade * pure).norm(), 1e-5F);  // of one hue
      darkest = std::min(darkest, shade);
      brightest = std::max(brightest, shade);
    }
  }
  EXPECT_GE(darkest, kMapShade - 1e-4F);
  EXPECT_LT(darkest, 0.90F);
  EXPECT_NEAR(static_cast<double>(brightest), 1.0, 0.002);
}

TEST(ScalarMap, PlacesWithoutAValueAreGreyAndThingsWithoutAMapPlain) {
  MapMesh quad;
  quad.mesh = QuadMesh({-40, 0, -40}, {80, 0, 0}, {0, 0, 80});
  quad.values.assign(4, kNan);
  const auto grey = RenderScalarMap({quad}, {}, FrontCamera(100.0, 100), Small(100), {});
  quad.values.clear();
  quad.plain = LinearRgb(0.2F, 0.4F, 0.6F);
  const auto plain = RenderScalarMap({quad}, {}, FrontCamera(100.0, 100), Small(100), {});
  ASSERT_TRUE(grey && plain);
  const LinearRgb& a = grey->image.rgb[grey->image.Index(50, 50)];
  const LinearRgb& b = plain->image.rgb[plain->image.Index(50, 50)];
  EXPECT_LT((a / a[0] - kNoDataColour / kNoDataColour[0]).norm(), 1e-5F);
  EXPECT_LT((b / b[0] - quad.plain / quad.plain[0]).norm(), 1e-5F);
}

TEST(ScalarMap, ClassesAreNotMixed) {
  MapMesh quad;
  quad.mesh = QuadMesh({-40, 0, -40}, {80, 0, 0}, {0, 0, 80});
  quad.values = {0.0, 2.0, 2.0, 0.0};  // in between lies a class of its own, which must not appear
  MapColours colours;
  colours.categories = {{"a", {0.9F, 0.1F, 0.1F}}, {"b", {0.1F, 0.9F, 0.1F}}, {"c", {0.1F, 0.1F, 0.9F}}};
  const auto picture = RenderScalarMap({quad}, colours, FrontCamera(100.0, 100), Small(100), {});
  ASSERT_TRUE(picture.has_value());
  int first = 0;
  int last = 0;
  for (int y = 15; y < 85; ++y) {
    for (int x = 15; x < 85; ++x) {
      const LinearRgb& rgb = picture->image.rgb[picture->image.Index(x, y)];
      EXPECT_LT(rgb[1], 0.2F);
      (rgb[0] > rgb[2] ? first : last) += 1;
    }
  }
  EXPECT_GT(first, 1500);
  EXPECT_GT(last, 1500);
}

TEST(ScalarMap, LinesStandAtTheMultiplesOfTheirStep) {
  MapMesh quad;
  quad.mesh = QuadMesh({-40, 0, -40}, {80, 0, 0}, {0, 0, 80});
  quad.values = {-40.0, -40.0, 40.0, 40.0};  // the height
  MapColours colours{{ColourMap::kDiverging, -100.0, 100.0}};
  const auto bare = RenderScalarMap({quad}, colours, FrontCamera(100.0, 100), Small(100), {});
  colours.isolines = 25.0;
  const auto lined = RenderScalarMap({quad}, colours, FrontCamera(100.0, 100), Small(100), {});
  ASSERT_TRUE(bare && lined);
  for (int y = 15; y < 85; ++y) {
    const std::size_t at = lined->image.Index(50, y);
    const double height = 49.5 - y;
    const double apart = std::abs(height - 25.0 * std::round(height / 25.0));
    const bool differs = (bare->image.rgb[at] - lined->image.rgb[at]).norm() > 1e-4F;
    if (apart > 1.1) {
      EXPECT_FALSE(differs) << y;
    }
  }
  int changed = 0;
  for (int y = 15; y < 85; ++y) {
    changed += lined->image.rgb[lined->image.Index(50, y)] != bare->image.rgb[bare->image.Index(50, y)] ? 1 : 0;
  }
  EXPECT_GE(changed, 3);  // -25, 0, 25
  EXPECT_LE(changed, 6);
}

TEST(ScalarMap, SameInputSameBytesForAnyNumberOfThreads) {
  MapPictureOptions one = Small(90);
  MapPictureOptions three = one;
  three.threads = 3;
  const auto a = RenderScalarMap({HeightOnBall()}, {}, FrontCamera(500.0, 240), one, {});
  const auto b = RenderScalarMap({HeightOnBall()}, {}, FrontCamera(500.0, 240), three, {});
  ASSERT_TRUE(a && b);
  EXPECT_EQ(EncodePng(a->image).value(), EncodePng(b->image).value());
}

TEST(ScalarMap, RefusesWhatCannotBeDrawn) {
  const Camera camera = FrontCamera(500.0, 100);
  MapMesh ball = HeightOnBall();
  ball.values.pop_back();
  EXPECT_FALSE(RenderScalarMap({ball}, {}, camera, Small(50), {}).has_value());
  ball = HeightOnBall();
  ball.mesh.vertices[3].x() = kNan;
  EXPECT_FALSE(RenderScalarMap({ball}, {}, camera, Small(50), {}).has_value());
  ball = HeightOnBall();
  ball.mesh.faces[0][1] = 1'000'000;
  EXPECT_FALSE(RenderScalarMap({ball}, {}, camera, Small(50), {}).has_value());
  EXPECT_FALSE(RenderScalarMap({}, {}, camera, Small(0), {}).has_value());
  EXPECT_FALSE(RenderScalarMap({}, {{ColourMap::kDiverging, 1.0, 1.0}}, camera, Small(50), {}).has_value());
  const auto empty = RenderScalarMap({}, {}, camera, Small(50), {});
  ASSERT_TRUE(empty.has_value());
  for (const LinearRgb& rgb : empty->image.rgb) EXPECT_EQ(rgb, LinearRgb(1.0F, 1.0F, 1.0F));
}

}  // namespace
}  // namespace annulus
