// The shift of a face's outline behind a lens, measured in traced pictures.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "render/trace.h"
#include "tests/render_lens/shifted_outline.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using test::VogelLens;

constexpr double kBehind = 18.0;     // mm from the back vertex to the outline
constexpr double kDistance = 600.0;  // mm from the camera to the front vertex
constexpr double kOutline = 10.0;    // mm from the optical axis
constexpr int kWidth = 400;
constexpr int kHeight = 6;
constexpr double kPicture = 30.0;  // mm, the picture's width on the plane of the outline

/// Lens frame in the station as it is worn: z to the front (+y), x to the wearer's left.
Eigen::Isometry3d Worn() {
  Eigen::Isometry3d worn = Eigen::Isometry3d::Identity();
  worn.linear() << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  return worn;
}

/// A sheet between two x of the lens frame on the plane of the outline.
SceneItem Sheet(double from, double to, double plane, const LinearRgb& colour) {
  SceneItem item;
  for (const auto& [x, y] : {std::pair{from, -40.0}, {to, -40.0}, {to, 40.0}, {from, 40.0}}) {
    item.mesh.vertices.push_back(Worn() * Vector3d(x, y, plane));
  }
  item.mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  item.material.finish = Finish::kMatte;
  item.material.colour = colour;
  item.group = "outline";
  return item;
}

/// Where a picture from before `thickness` mm of lens or air shows the outline, mm on its plane from the picture's
/// middle: the white it has left of the outline's black, by the mean of its rows.
double OutlineInPicture(const Scene& scene, double thickness) {
  const double depth = kDistance + thickness + kBehind;
  Camera camera;
  camera.camera_from_station << -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0;
  camera.eye_in_station = {0.0, kDistance, 0.0};
  camera.half_height = 0.5 * kPicture / depth * kHeight / kWidth;
  TraceOptions options;
  options.width = kWidth;
  options.height = kHeight;
  options.samples = 64;
  options.denoising = Denoising::kOff;
  options.tone_curve = ToneCurve::kLinear;
  const Lighting light{Environment::Uniform(LinearRgb::Ones()), {}};
  const auto image = Tracer::Make(scene).value().Trace(camera, light, options, {});
  EXPECT_TRUE(image.has_value());
  std::vector<double> column(kWidth, 0.0);
  for (int x = 0; x < kWidth; ++x) {
    for (int y = 0; y < kHeight; ++y) {
      column[static_cast<std::size_t>(x)] += static_cast<double>(image->rgb[image->Index(x, y)].y()) / kHeight;
    }
  }
  // The steepest fall, then the area under it between the levels on both sides.
  constexpr std::size_t kSide = 12;
  std::size_t steepest = kSide + 4;
  for (std::size_t x = kSide + 4; x + kSide + 4 < column.size(); ++x) {
    if (column[x - 1] - column[x + 1] > column[steepest - 1] - column[steepest + 1]) steepest = x;
  }
  double white = 0.0;
  double black = 0.0;
  for (std::size_t i = 0; i < 8; ++i) {
    white += column[steepest - kSide + i] / 8.0;
    black += column[steepest + kSide - i] / 8.0;
  }
  double edge = static_cast<double>(steepest - kSide);
  for (std::size_t x = steepest - kSide; x <= steepest + kSide; ++x) edge += (column[x] - black) / (white - black);
  return (edge / kWidth - 0.5) * kPicture;
}

/// White up to the outline, black behind it.
Scene Face(double thickness) {
  Scene scene;
  scene.items.push_back(Sheet(-60.0, kOutline, -thickness - kBehind, LinearRgb::Ones()));
  scene.items.push_back(Sheet(kOutline, 60.0, -thickness - kBehind, LinearRgb::Zero()));
  return scene;
}

TEST(TracedOutline, IsWhereItIsWithoutALens) { EXPECT_NEAR(OutlineInPicture(Face(2.0), 2.0), kOutline, 0.003); }

TEST(TracedOutline, ShiftsBehindALensAsTheThickLensCalculationSaysWithinTwoPercent) {
  // The exact meridional trace of thick_lens_test.cpp's Python at 600 mm, X = 10 mm.
  const double expected[] = {-1.185073, -0.596425, -0.266256, 0.527514, 1.047500, 2.351263};
  for (std::size_t i = 0; i < test::kVogelLenses.size(); ++i) {
    const VogelLens& lens = test::kVogelLenses[i];
    Scene scene = Face(lens.thickness);
    SolidLens solid = lens.Solid();
    solid.station_from_lens = Worn();
    solid.finish.coating = LensCoating::kAntiReflective;
    scene.lenses.push_back(solid);
    const double shift = OutlineInPicture(scene, lens.thickness) - kOutline;
    EXPECT_NEAR(shift / expected[i], 1.0, 0.02) << lens.power << " D: " << shift << " mm";
    RecordProperty("shift_" + std::to_string(i), std::to_string(shift));
  }
}

}  // namespace
}  // namespace annulus
