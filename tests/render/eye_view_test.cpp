#include "render/eye_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "modeling/glasses/lens_form.h"
#include "modeling/glasses/lens_sight.h"

namespace annulus {
namespace {

constexpr double kVertex = 12.0;  // mm
constexpr double kWide = RadiansFromDegrees(30.0);

const GazeScene& Grid() {
  static const GazeScene scene = GazeScene::Make(GazeSceneKind::kGrid);
  return scene;
}

SolidLens LensOf(double base, double power, double index, double thickness) {
  LensFormSpec spec;
  spec.base = base;
  spec.index = index;
  SolidLens lens;
  const auto form = BuildLensForm(spec, {power * PowerMatrix::Identity(), Eigen::Vector2d::Zero()}, thickness);
  EXPECT_TRUE(form);
  lens.form = *form;
  for (int i = 0; i < 360; ++i) {
    const double around = kTwoPi * i / 360.0;
    lens.outline.points.emplace_back(28.0 * std::cos(around), 28.0 * std::sin(around));
  }
  LensPose pose;
  pose.vertex_distance = kVertex;
  lens.station_from_lens = LensSight(lens.form, lens.outline, pose, nullptr).lens_from_view().inverse();
  return lens;
}

BeforeTheEye Before(const std::optional<SolidLens>& lens) {
  BeforeTheEye before;
  before.lens = lens;
  before.world = &Grid();
  return before;
}

SeeingEye EyeOf(double pupil, const PowerMatrix& correction) {
  SeeingEye eye;
  eye.pupil_diameter = pupil;
  eye.correction = correction;
  eye.vertex_distance = kVertex;
  return eye;
}
SeeingEye EyeOf(double pupil, double correction) { return EyeOf(pupil, correction * PowerMatrix::Identity()); }

EyeViewOptions Options(int width, int height, double field, int samples) {
  EyeViewOptions options;
  options.width = width;
  options.height = height;
  options.field = field;
  options.samples = samples;
  options.threads = 2;
  return options;
}

RgbImage Seen(const SeeingEye& eye, const BeforeTheEye& before, const EyeViewOptions& options) {
  auto image = RenderEyeView(eye, before, options, {});
  EXPECT_TRUE(image) << (image ? "" : image.error().Text());
  return std::move(*image);
}

/// A dark line that stands upright where the tangent to the wearer's right is about `tangent`, at the height of the
/// tangent 250/6000 (between the grid's lines): its middle and its spread as tangents.
struct LineSeen {
  double middle = 0.0;
  double variance = 0.0;
};
LineSeen LineAt(const RgbImage& image, double field, double tangent, double reach) {
  const double per_pixel = 2.0 * std::tan(0.5 * field) / image.width;
  const int row = static_cast<int>(0.5 * image.height - 250.0 / kChartDistance / per_pixel);
  const auto column = [&](double at) { return static_cast<int>(0.5 * image.width + at / per_pixel); };
  const auto grey = [&](int x) { return static_cast<double>(image.rgb[image.Index(x, row)].mean()); };
  const double ground = 0.5 * (grey(column(tangent - reach)) + grey(column(tangent + reach)));
  double sum = 0.0;
  double first = 0.0;
  double second = 0.0;
  for (int x = column(tangent - reach); x <= column(tangent + reach); ++x) {
    const double at = (x + 0.5 - 0.5 * image.width) * per_pixel;
    const double ink = ground - grey(x);
    sum += ink;
    first += ink * at;
    second += ink * at * at;
  }
  const double middle = first / sum;
  return {middle, second / sum - middle * middle};
}

TEST(EyeView, TheNakedSharpEyeSeesTheGridWhereItIs) {
  const RgbImage image = Seen(EyeOf(0.0, 0.0), Before(std::nullopt), Options(600, 120, kWide, 16));
  for (const int k : {-2, -1, 1, 2}) {
    const double expected = k * 500.0 / kChartDistance;
    EXPECT_NEAR(LineAt(image, kWide, expected, 0.012).middle, expected, 2e-4) << k;
  }
}

TEST(EyeView, ALensMagnifiesByItsSpectacleMagnification) {
  // 1 / ((1 − t/n·F1)(1 − d·Fv)), d from the back vertex to the entrance pupil: 15 mm.
  for (const double power : {-6.0, -2.0, 3.0, 6.0}) {
    const double base = power > 0.0 ? power + 6.0 : power / 2.0 + 6.0;
    const double thickness = power > 0.0 ? 6.0 : 1.5;
    const RgbImage image =
        Seen(EyeOf(0.0, power), Before(LensOf(base, power, 1.6, thickness)), Options(600, 120, kWide, 16));
    const double expected = 1.0 / ((1.0 - thickness / 1600.0 * base) * (1.0 - 0.015 * power));
    const double real = 500.0 / kChartDistance;
    const double left = LineAt(image, kWide, -expected * real, 0.012).middle;
    const double right = LineAt(image, kWide, expected * real, 0.012).middle;
    EXPECT_NEAR(0.5 * (right - left) / real, expected, 0.01 * expected) << power;
  }
}

TEST(EyeView, MinusMakesBarrelsAndPlusMakesPincushions) {
  const double field = RadiansFromDegrees(70.0);
  const auto stretch = [&](double power) {
    const double base = power > 0.0 ? power + 6.0 : power / 2.0 + 6.0;
    const double magnification = 1.0 / ((1.0 - 0.003 / 1.6 * base) * (1.0 - 0.015 * power));
    const RgbImage image =
        Seen(EyeOf(0.0, power), Before(LensOf(base, power, 1.6, 3.0)), Options(1000, 120, field, 16));
    const auto ratio = [&](double real) { return LineAt(image, field, magnification * real, 0.03).middle / real; };
    return ratio(2000.0 / kChartDistance) / ratio(1000.0 / kChartDistance);
  };
  EXPECT_LT(stretch(-6.0), 0.995);
  EXPECT_GT(stretch(5.0), 1.005);
}

TEST(EyeView, AnUncorrectedEyeBlursByPupilRadiusTimesError) {
  // A point becomes a disc of radius r = 2 mm · 1.988 D = 3.976 mrad (−2 D at the cornea is −1.988 D at the pupil, 3 mm
  // behind it); a disc's variance along one axis is r²/4. The lens takes it away.
  const EyeViewOptions options = Options(600, 110, kWide, 100);
  const double real = 500.0 / kChartDistance;
  const auto variance = [&](const SeeingEye& eye, const std::optional<SolidLens>& lens) {
    return LineAt(Seen(eye, Before(lens), options), kWide, real, 0.012).variance;
  };
  const double sharp = variance(EyeOf(0.0, -2.0), std::nullopt);
  const double disc = std::pow(2e-3 * 2.0 / 1.006, 2) / 4.0;
  EXPECT_NEAR(variance(EyeOf(4.0, -2.0), std::nullopt) - sharp, disc, 0.04 * disc);
  // At the lens, 12 mm before the cornea, the eye needs −2 / (1 − 0.024) D.
  EXPECT_NEAR(variance(EyeOf(4.0, -2.0), LensOf(5.0, -2.0 / 0.976, 1.6, 1.5)) - sharp, 0.0, 0.05 * disc);
  // What is wrong up and down blurs no upright line.
  PowerMatrix upright = PowerMatrix::Zero();
  upright(1, 1) = -2.0;
  EXPECT_NEAR(variance(EyeOf(4.0, upright), std::nullopt) - sharp, 0.0, 0.03 * disc);
  PowerMatrix level = PowerMatrix::Zero();
  level(0, 0) = -2.0;
  EXPECT_NEAR(variance(EyeOf(4.0, level), std::nullopt) - sharp, disc, 0.04 * disc);
}

TEST(EyeView, ATurnedEyeSeesWhatItLooksAtInTheMiddle) {
  SeeingEye eye = EyeOf(0.0, 0.0);
  eye.gaze.left = std::atan(1500.0 / kChartDistance);
  eye.gaze.up = 0.0;
  const RgbImage image = Seen(eye, Before(std::nullopt), Options(600, 120, kWide, 16));
  // The line at 1500 mm to the left stands in the middle of the picture.
  EXPECT_NEAR(LineAt(image, kWide, 0.0, 0.02).middle, 0.0, 3e-4);
}

TEST(EyeView, LightIsLostByTheTintAndAtBothSurfaces) {
  // 2 mm of glass of transmittance t, and (1 − R)² with R = ((n − 1)/(n + 1))².
  SolidLens lens = LensOf(0.0, 0.0, 1.6, 2.0);
  const LinearRgb tint(0.5F, 0.25F, 0.8F);
  lens.finish.transmittance = lens.finish.lower_transmittance = tint;
  const EyeViewOptions options = Options(64, 64, RadiansFromDegrees(2.0), 4);
  const RgbImage with = Seen(EyeOf(0.0, 0.0), Before(lens), options);
  const RgbImage without = Seen(EyeOf(0.0, 0.0), Before(std::nullopt), options);
  const float boundaries = std::pow(1.0F - std::pow(0.6F / 2.6F, 2.0F), 2.0F);
  for (Eigen::Index channel = 0; channel < 3; ++channel) {
    float seen = 0.0F;
    float there = 0.0F;
    for (std::size_t i = 0; i < with.rgb.size(); ++i) {
      seen += with.rgb[i][channel];
      there += without.rgb[i][channel];
    }
    EXPECT_NEAR(seen / there, tint[channel] * boundaries, 0.002F);
  }
}

/// A black wall over the wearer's left, 17 mm before the pupil, from 4 mm on.
Scene BlackWall() {
  Scene scene;
  SceneItem wall;
  wall.mesh = {{{4.0, -60.0, 27.0}, {60.0, -60.0, 27.0}, {60.0, 60.0, 27.0}, {4.0, 60.0, 27.0}},
               {{0, 1, 2}, {0, 2, 3}}};
  wall.material.finish = Finish::kMatte;
  wall.material.colour = LinearRgb::Zero();
  wall.group = "wall";
  scene.items.push_back(wall);
  return scene;
}

TEST(EyeView, ANearEdgeIsSoftOverThePupil) {
  const double field = RadiansFromDegrees(60.0);
  BeforeTheEye before = Before(std::nullopt);
  const EyeViewOptions options = Options(300, 60, field, 64);
  const double per_pixel = 2.0 * std::tan(0.5 * field) / options.width;
  const auto share = [&](const RgbImage& covered, const RgbImage& free, double left) {
    // A window of the picture's height, one pixel wide.
    const int x = static_cast<int>(0.5 * options.width - left / per_pixel);
    double seen = 0.0;
    double there = 0.0;
    for (int y = 0; y < options.height; ++y) {
      seen += covered.rgb[covered.Index(x, y)].sum();
      there += free.rgb[free.Index(x, y)].sum();
    }
    return 1.0 - seen / there;
  };
  for (const double pupil : {0.0, 4.0}) {
    before.near = {};
    const RgbImage free = Seen(EyeOf(pupil, 0.0), before, options);
    before.near = BlackWall();
    const RgbImage covered = Seen(EyeOf(pupil, 0.0), before, options);
    // The eye is focused far away: from a point q of the pupil the edge stands at (4 − q)/17.
    const double soft = std::max(0.5 * pupil / 17.0, 2.0 * per_pixel);
    EXPECT_NEAR(share(covered, free, 4.0 / 17.0 + 1.4 * soft), 1.0, 0.02) << pupil;
    EXPECT_NEAR(share(covered, free, 4.0 / 17.0 - 1.4 * soft), 0.0, 0.02) << pupil;
    if (pupil > 0.0) {
      EXPECT_NEAR(share(covered, free, 4.0 / 17.0), 0.5, 0.06);
      // A disc cut at half its radius: 1/2 + (π/6 + √3/4)/π = 0.8045 of its area lies on one side.
      EXPECT_NEAR(share(covered, free, 4.0 / 17.0 + 0.5 * soft), 0.8045, 0.06);
    }
  }
}

TEST(EyeView, ThePictureDoesNotDependOnTheNumberOfThreads) {
  BeforeTheEye before = Before(LensOf(3.0, -6.0, 1.6, 1.5));
  before.near = BlackWall();
  EyeViewOptions options = Options(90, 70, RadiansFromDegrees(110.0), 6);
  options.threads = 1;
  const RgbImage one = Seen(EyeOf(4.0, -6.0), before, options);
  options.threads = 5;
  const RgbImage five = Seen(EyeOf(4.0, -6.0), before, options);
  EXPECT_EQ(one.rgb, five.rgb);
  for (const LinearRgb& pixel : one.rgb) ASSERT_TRUE(pixel.allFinite() && pixel.minCoeff() >= 0.0F);
}

TEST(EyeView, RefusesWhatCannotBe) {
  const EyeViewOptions options = Options(32, 32, 1.0, 2);
  const auto fails = [](const SeeingEye& eye, const BeforeTheEye& before, const EyeViewOptions& wrong) {
    return !RenderEyeView(eye, before, wrong, {}).has_value();
  };
  EyeViewOptions wrong = options;
  wrong.width = 0;
  EXPECT_TRUE(fails(EyeOf(4.0, 0.0), Before(std::nullopt), wrong));
  wrong = options;
  wrong.field = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(fails(EyeOf(4.0, 0.0), Before(std::nullopt), wrong));
  EXPECT_TRUE(fails(EyeOf(-1.0, 0.0), Before(std::nullopt), options));
  EXPECT_TRUE(fails(EyeOf(4.0, std::numeric_limits<double>::infinity()), Before(std::nullopt), options));
  BeforeTheEye nothing;
  EXPECT_TRUE(fails(EyeOf(4.0, 0.0), nothing, options));
  SolidLens lens = LensOf(4.0, -1.0, 1.5, 2.0);
  lens.outline.points.resize(3);
  EXPECT_TRUE(fails(EyeOf(4.0, 0.0), Before(lens), options));
  lens = LensOf(4.0, -1.0, 1.5, 2.0);
  lens.finish.transmittance = LinearRgb::Zero();
  EXPECT_TRUE(fails(EyeOf(4.0, 0.0), Before(lens), options));

  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(RenderEyeView(EyeOf(4.0, 0.0), Before(std::nullopt), options, {{}, stop.get_token()}));
}

}  // namespace
}  // namespace annulus
