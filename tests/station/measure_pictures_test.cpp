#include "station/measure_pictures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/png.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

/// A cylinder of radius 100 mm, z = 0 … 200 mm.
struct Post {
  SurfaceModel model;
  MeasuredSurface body;
  Post()
      : model(test::InterpolatedBody([](double, double) { return 100.0; }, 36, UniformBreakpoints(0.0, 200.0, 40))),
        body(MeasuredSurface::FromModel(model).value()) {}
  Post(const Post&) = delete;
  Post& operator=(const Post&) = delete;
  [[nodiscard]] PictureSubject Subject(const std::string& caption = "post") const {
    return {&model, &body, nullptr, nullptr, caption};
  }
};

/// Values that rise with the height from 0 to 200.
MapInput Heights() {
  MapInput input;
  input.values_name = "heights.csv";
  input.values_csv = "theta_deg,z_mm,value\n";
  for (int z = 0; z <= 200; z += 20) {
    for (int theta = 0; theta < 360; theta += 30) {
      input.values_csv += std::to_string(theta) + "," + std::to_string(z) + "," + std::to_string(z) + "\n";
    }
  }
  return input;
}

MeasurePictureOptions ValuesOptions() {
  MeasurePictureOptions options;
  options.map = MapKind::kValues;
  options.range = {0.0, 200.0};
  options.size = 300;
  return options;
}

RgbImage InBytes(const RgbImage& image) { return DecodePng(EncodePng(image).value()).value(); }

TEST(MeasurePicture, TheMapOnTheBodyAndTheLegendReadBackToTheValues) {
  const Post post;
  const auto picture = MeasurePicture::Prepare({post.Subject()}, Heights(), ValuesOptions(), {});
  ASSERT_TRUE(picture.has_value()) << picture.error().Text();
  const auto drawn = picture->Draw({kPi / 2.0, 0.0}, {});
  ASSERT_TRUE(drawn.has_value()) << drawn.error().Text();
  const RgbImage image = InBytes(*drawn);
  const ValueScale scale{ColourMap::kSequential, 0.0, 200.0};
  // Columns in which the colours rise all the way: those of the body, and those of the legend's bar.
  int columns = 0;
  double longest = 0.0;
  for (int x = 0; x < image.width; x += 4) {
    std::vector<std::pair<int, double>> read;
    for (int y = 0; y < image.height; ++y) {
      const LinearRgb& rgb = image.rgb[image.Index(x, y)];
      const double value = scale.ValueOf(rgb);
      LinearRgb pure = scale.ColourOf(value);
      const float shade = std::clamp(pure.dot(rgb) / pure.squaredNorm(), kMapShade, 1.0F);
      if ((shade * pure - rgb).norm() < 0.01F) read.emplace_back(y, value);
    }
    if (read.size() < 200) continue;
    // The line through the middle half; of a true scale it is straight.
    const auto& a = read[read.size() / 4];
    const auto& b = read[3 * read.size() / 4];
    const double slope = (b.second - a.second) / (b.first - a.first);
    EXPECT_LT(slope, 0.0);
    for (std::size_t k = read.size() / 10; k < 9 * read.size() / 10; ++k) {
      EXPECT_NEAR(read[k].second, a.second + slope * (read[k].first - a.first), 4.0) << "column " << x;
    }
    longest = std::max(longest, -slope * static_cast<double>(read.size()));
    ++columns;
  }
  EXPECT_GT(columns, 50);
  EXPECT_NEAR(longest, 200.0, 15.0);  // the whole scale stands in a column
}

TEST(MeasurePicture, NotesSayLeastGreatestAndWhatTheScaleLeavesOut) {
  const Post post;
  MeasurePictureOptions options = ValuesOptions();
  options.range = {50.0, 150.0};
  const auto picture = MeasurePicture::Prepare({post.Subject()}, Heights(), options, {});
  ASSERT_TRUE(picture.has_value());
  const ValueRange& range = picture->range().value();
  EXPECT_NEAR(range.least, 0.0, 1e-9);
  EXPECT_NEAR(range.greatest, 200.0, 1e-9);
  // The ends of the post are closed by discs, whose area counts too: a quarter of the side lies beyond each end.
  const double side = kTwoPi * 100.0 * 200.0;
  const double disc = kPi * 1e4;
  EXPECT_NEAR(range.below, (0.25 * side + disc) / (side + 2.0 * disc), 0.03);
  EXPECT_NEAR(range.above, (0.25 * side + disc) / (side + 2.0 * disc), 0.03);
}

TEST(MeasurePicture, TwoSubjectsStandSideBySideAtOneScale) {
  const Post post;
  const auto one = MeasurePicture::Prepare({post.Subject()}, Heights(), ValuesOptions(), {});
  const auto two = MeasurePicture::Prepare({post.Subject("a"), post.Subject("b")}, Heights(), ValuesOptions(), {});
  ASSERT_TRUE(one && two);
  const auto single = one->Draw({kPi / 2.0, 0.2}, {});
  const auto pair = two->Draw({kPi / 2.0, 0.2}, {});
  ASSERT_TRUE(single && pair);
  EXPECT_GT(pair->width, single->width + 280);
  EXPECT_DOUBLE_EQ(one->range()->maximum, two->range()->maximum);
}

TEST(MeasurePicture, FramesOfATurntableAreOfOneSizeAndAlwaysTheSame) {
  const Post post;
  MeasurePictureOptions options = ValuesOptions();
  options.size = 120;
  const auto picture = MeasurePicture::Prepare({post.Subject()}, Heights(), options, {});
  ASSERT_TRUE(picture.has_value());
  const auto frames = picture->DrawAround({kPi / 2.0, 0.3}, 5, {});
  const auto again = picture->DrawAround({kPi / 2.0, 0.3}, 5, {});
  ASSERT_TRUE(frames && again);
  ASSERT_EQ(frames->size(), 5U);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_EQ((*frames)[k].width, (*frames)[0].width);
    EXPECT_EQ((*frames)[k].height, (*frames)[0].height);
    EXPECT_EQ(EncodePng((*frames)[k]).value(), EncodePng((*again)[k]).value());
  }
  EXPECT_FALSE(picture->DrawAround({0.0, 0.0}, 0, {}).has_value());
}

TEST(MeasurePicture, UnrolledItShowsTheSameValues) {
  const Post post;
  MeasurePictureOptions options = ValuesOptions();
  options.form = PictureForm::kUnrolled;
  const auto picture = MeasurePicture::Prepare({post.Subject()}, Heights(), options, {});
  ASSERT_TRUE(picture.has_value());
  const auto drawn = picture->Draw({}, {});
  ASSERT_TRUE(drawn.has_value());
  // 300 pixels wide and 300 * 200 / (2 pi 100) tall; a pixel of its middle has the colour of 100, nearly.
  const RgbImage image = InBytes(*drawn);
  const ValueScale scale{ColourMap::kSequential, 0.0, 200.0};
  int found = 0;
  for (const LinearRgb& rgb : image.rgb) found += (scale.ColourOf(100.0) - rgb).norm() < 0.012F ? 1 : 0;
  EXPECT_GT(found, 290);
}

TEST(MeasurePicture, RefusesMapsWithoutWhatTheyNeed) {
  const Post post;
  for (const MapKind kind :
       {MapKind::kResidual, MapKind::kClearance, MapKind::kAreaStrain, MapKind::kDifference, MapKind::kSigma}) {
    MeasurePictureOptions options;
    options.map = kind;
    EXPECT_FALSE(MeasurePicture::Prepare({post.Subject()}, {}, options, {}).has_value()) << MapKindName(kind);
  }
  MeasurePictureOptions options = ValuesOptions();
  options.size = 10;
  EXPECT_FALSE(MeasurePicture::Prepare({post.Subject()}, Heights(), options, {}).has_value());
  options = ValuesOptions();
  options.range = {1.0, 1.0};
  EXPECT_FALSE(MeasurePicture::Prepare({post.Subject()}, Heights(), options, {}).has_value());
  EXPECT_FALSE(MeasurePicture::Prepare({}, {}, {}, {}).has_value());
  options = {};
  options.form = PictureForm::kUnrolled;
  EXPECT_FALSE(MeasurePicture::Prepare({post.Subject()}, {}, options, {}).has_value());
}

TEST(MapFigure, KeepsThePixelsOfItsPanels) {
  std::mt19937_64 random(7);
  MapPanel panel;
  panel.image = RgbImage::Filled(90, 60, LinearRgb::Zero());
  for (LinearRgb& rgb : panel.image.rgb) {
    rgb = LinearFromHex(static_cast<std::uint32_t>(random() & 0xFFFFFFU));
  }
  const auto figure = MapFigure({panel}, std::nullopt, {"title", {"a note"}}, 4.5).ToImage(4.5);
  ASSERT_TRUE(figure.has_value()) << figure.error().Text();
  const auto same = [&](int x, int y) {
    for (int v = 0; v < 60; ++v) {
      for (int u = 0; u < 90; ++u) {
        if ((figure->rgb[figure->Index(x + u, y + v)] - panel.image.rgb[panel.image.Index(u, v)]).norm() > 1e-5F) {
          return false;
        }
      }
    }
    return true;
  };
  int found = 0;
  for (int y = 0; y + 60 <= figure->height; ++y) {
    for (int x = 0; x + 90 <= figure->width; ++x) found += same(x, y) ? 1 : 0;
  }
  EXPECT_EQ(found, 1);
}

}  // namespace
}  // namespace annulus
