#include "render/sheet_lens.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "shapes.h"

namespace annulus {
namespace {

constexpr std::array<float, 6> kPowers = {-8.0F, -4.0F, -2.0F, 2.0F, 4.0F, 8.0F};

/// A square sheet of half width `half`, its middle at (0, 0, 0), its true normals at the vertices. Towards +y it bulges
/// as a sphere of `radius` (hollow if negative, flat if 0).
SceneItem Sheet(double radius, double half, float power) {
  constexpr std::uint32_t kCells = 80;
  SceneItem item = Item({}, ExactLens(LinearRgb::Ones()));
  item.material.lens_power = power;
  for (std::uint32_t i = 0; i <= kCells; ++i) {
    for (std::uint32_t j = 0; j <= kCells; ++j) {
      const double x = half * (2.0 * i / kCells - 1.0);
      const double z = half * (2.0 * j / kCells - 1.0);
      const double rest = std::sqrt(radius * radius - x * x - z * z);
      const double sag = radius == 0.0 ? 0.0 : std::copysign(rest, radius) - radius;
      item.mesh.vertices.emplace_back(x, sag, z);
      item.normals.push_back(radius == 0.0 ? Eigen::Vector3d::UnitY()
                                           : Eigen::Vector3d(x / radius, rest / std::abs(radius), z / radius));
    }
  }
  for (std::uint32_t i = 0; i < kCells; ++i) {
    for (std::uint32_t j = 0; j < kCells; ++j) {
      const std::uint32_t a = i * (kCells + 1) + j;
      const std::uint32_t c = a + kCells + 1;
      item.mesh.faces.push_back({a, a + 1, c});
      item.mesh.faces.push_back({a + 1, c + 1, c});
    }
  }
  return item;
}

/// A plane at y = -distance, red where station x > edge and green elsewhere.
void AddEdge(Scene& scene, double distance, double edge) {
  Material red;
  red.finish = Finish::kMatte;
  red.colour = LinearRgb(0.5F, 0.0F, 0.0F);
  Material green = red;
  green.colour = LinearRgb(0.0F, 0.5F, 0.0F);
  scene.items.push_back(Item(QuadMesh({edge, -distance, -30}, {60, 0, 0}, {0, 0, 60}), red));
  scene.items.push_back(Item(QuadMesh({edge - 60, -distance, -30}, {60, 0, 0}, {0, 0, 60}), green));
}

/// Station x at which the edge is seen, mm, along the row in the middle of a picture of +-4 mm from far.
double EdgeSeenAt(const Scene& scene, LensMedium medium) {
  RenderOptions options = PlainOptions(1600, 4);
  options.lens_medium = medium;
  Camera camera = FrontCamera(200.0, 4);
  camera.half_height = 0.01;  // 0.005 mm per pixel
  const RgbImage image = Render(scene, camera, options, {}).value();
  // The picture's right is the station's -x: red comes first.
  double red = 0.0;
  for (int x = 0; x < 1600; ++x) red += static_cast<double>(image.rgb[image.Index(x, 1)][0]);
  return 4.0 - 0.005 * red / static_cast<double>(image.rgb[image.Index(0, 1)][0]);
}

TEST(SheetLens, IndexAndCurvatureGiveThePowerOfAThinLens) {
  // From far, an object d behind a surface of curvature k before a medium n looks n / (n - d (n - 1) k) times as large
  // (kFilled), one d behind a thin lens of power (n - 1) k 1 / (1 - d (n - 1) k) times (kThin).
  for (const double power : {-30.0, -8.0, -1.0, -0.01, 0.01, 2.0, 8.0, 30.0}) {
    for (const double curvature : {-0.02, -0.008, 0.0, 1e-4, 0.008, 0.02}) {
      const double d = 14.0;
      const double wanted = 1.0 / (1.0 - d * power / 1000.0);
      const SheetPower filled = SheetPowerOf(power, curvature, LensMedium::kFilled);
      EXPECT_NEAR(filled.index / (filled.index - d * (filled.index - 1.0) * filled.curvature), wanted, 1e-9);
      EXPECT_GE(filled.index, kLeastSheetIndex);
      EXPECT_LE(filled.index, kGreatestSheetIndex);
      const SheetPower thin = SheetPowerOf(power, curvature, LensMedium::kThin);
      EXPECT_NEAR(1.0 / (1.0 - d * (thin.index - 1.0) * thin.curvature), wanted, 1e-9);
      EXPECT_GT(thin.index, 1.0);
      EXPECT_LE(thin.index, kGreatestSheetIndex);
    }
  }
  // Within the range the sheet keeps its own curvature: n = 1 / (1 - P r).
  const SheetPower natural = SheetPowerOf(2.0, 0.01, LensMedium::kFilled);
  EXPECT_NEAR(natural.index, 1.0 / (1.0 - 0.002 * 100.0), 1e-12);
  EXPECT_NEAR(natural.curvature, 0.01, 1e-12);
  EXPECT_EQ(SheetPowerOf(0.0, 0.01, LensMedium::kThin).index, 1.0);
}

TEST(SheetLens, AVerticalEdgeIsShiftedAsByAThinLens) {
  // From far and near the axis a ray at height h meets a plane d behind at h (1 - d P): the edge at x is seen at
  // x / (1 - d P). The sphere's own sag at 3 mm (0.05 mm of 20) and third-order terms (0.2 %) are allowed for.
  const double distance = 20.0;
  const double edge = 2.5;
  for (const LensMedium medium : {LensMedium::kThin, LensMedium::kFilled}) {
    for (const double radius : {100.0, -100.0, 60.0, 0.0}) {
      for (const float power : kPowers) {
        Scene scene;
        AddEdge(scene, distance, edge);
        scene.items.push_back(Sheet(radius, 15.0, power));
        const double shift = edge / (1.0 - distance * static_cast<double>(power) / 1000.0) - edge;
        EXPECT_NEAR(EdgeSeenAt(scene, medium) - edge, shift, 0.01 * std::abs(shift) + 0.006)
            << "radius " << radius << " power " << power;
      }
      Scene scene;
      AddEdge(scene, distance, edge);
      scene.items.push_back(Sheet(radius, 15.0, 0.0F));
      EXPECT_NEAR(EdgeSeenAt(scene, medium), edge, 0.006);
    }
  }
}

TEST(SheetLens, PlusEnlargesAndMinusShrinks) {
  // A disc of radius 5 mm, 20 mm behind: its area grows by 1 / (1 - d P)^2.
  const auto count = [](float power) {
    Scene scene;
    Material red;
    red.finish = Finish::kMatte;
    red.colour = LinearRgb(0.5F, 0.0F, 0.0F);
    scene.items.push_back(Item(SphereMesh({0, 0, 0}, 5.0, 96), red));
    for (Eigen::Vector3d& p : scene.items[0].mesh.vertices) p.y() = -20.0 + 1e-3 * p.y();  // flat
    scene.items.push_back(Sheet(100.0, 15.0, power));
    Camera camera = FrontCamera(200.0, 200);
    camera.half_height = 8.0;
    const RgbImage image = Render(scene, camera, PlainOptions(200, 200), {}).value();
    double area = 0.0;
    for (const float alpha : image.alpha) area += static_cast<double>(alpha);
    return area;
  };
  const double plain = count(0.0F);
  double last = 0.0;
  for (const float power : kPowers) {
    const double area = count(power);
    EXPECT_NEAR(area / plain, std::pow(1.0 - 0.02 * static_cast<double>(power), -2.0), 0.02) << power;
    EXPECT_GT(area, last);
    last = area;
    EXPECT_EQ(area > plain, power > 0.0F);
  }
}

TEST(SheetLens, ObliquelyAThinMediumLeavesTheMiddleInPlaceAndAFilledOneShiftsItAsWater) {
  // Seen at 45 degrees through the middle: a thin prism-free lens leaves the ray alone; behind a surface of index n it
  // goes on at asin(sin 45 / n).
  Scene scene;
  scene.items.push_back(Sheet(100.0, 15.0, 2.0F));
  Camera camera = FrontCamera(200.0, 100);
  const PreparedScene prepared = PrepareScene(scene, ScenePart::kLenses, camera).value();
  const Eigen::Vector3d direction = Eigen::Vector3d(1.0, 0.0, 1.0).normalized();
  const Eigen::Vector3d normal(0.0, 0.0, -1.0);
  const SheetLens thin(prepared, 0, LensMedium::kThin);
  const SheetLens filled(prepared, 0, LensMedium::kFilled);
  EXPECT_NEAR(thin.curvature() * thin.axis().dot(normal), 0.01, 1e-5);
  EXPECT_NEAR((thin.Refract(thin.middle(), normal, direction).value() - direction).norm(), 0.0, 1e-9);
  EXPECT_NEAR(filled.Refract(filled.middle(), normal, direction).value().x(), std::sqrt(0.5) / 1.25, 1e-5);
}

TEST(SheetLens, TotalReflectionIsSaid) {
  // Index 0.8 behind: no ray enters at more than asin(0.8) = 53.1 degrees.
  Scene scene;
  scene.items.push_back(Sheet(100.0, 15.0, -2.5F));
  const Camera camera = FrontCamera(200.0, 100);
  const PreparedScene prepared = PrepareScene(scene, ScenePart::kLenses, camera).value();
  const SheetLens filled(prepared, 0, LensMedium::kFilled);
  const auto at = [&](double degrees) {
    const double angle = RadiansFromDegrees(degrees);
    return filled.Refract(filled.middle(), {0.0, 0.0, -1.0}, {std::sin(angle), 0.0, std::cos(angle)});
  };
  EXPECT_TRUE(at(52.9).has_value());
  EXPECT_FALSE(at(53.3).has_value());
}

TEST(SheetLens, TheNearerLensShowsWhatTheFartherMakesOfTheScene) {
  // Two sheets in a row: transmittances multiply whatever their order in the scene, refracted or not.
  for (const float power : {0.0F, 3.0F}) {
    for (const bool swapped : {false, true}) {
      Scene scene;
      Material white;
      white.finish = Finish::kMatte;
      white.colour = LinearRgb::Constant(0.5F);
      scene.items.push_back(Item(QuadMesh({-30, -20, -30}, {60, 0, 0}, {0, 0, 60}), white));
      const float plain = Render(scene, FrontCamera(100.0, 8), PlainOptions(8, 8), {})->rgb[27][0];
      SceneItem near = Sheet(100.0, 20.0, power);
      near.material.transmittance = LinearRgb::Constant(0.5F);
      SceneItem far = near;
      far.material.transmittance = LinearRgb::Constant(0.25F);
      for (Eigen::Vector3d& p : far.mesh.vertices) p.y() -= 8.0;
      scene.items.push_back(swapped ? far : near);
      scene.items.push_back(swapped ? near : far);
      const auto image = Render(scene, FrontCamera(100.0, 8), PlainOptions(8, 8), {});
      EXPECT_FLOAT_EQ(image->rgb[27][0], 0.125F * plain);
    }
  }
}

TEST(SheetLens, AGradientRunsWithTheSolidHeight) {
  Scene scene;
  SceneItem sheet = Item(QuadMesh({-10, 0, -10}, {20, 0, 0}, {0, 0, 20}), ExactLens(LinearRgb::Constant(0.8F)));
  sheet.material.lower_transmittance = LinearRgb::Constant(0.2F);
  sheet.material.gradient_from = 5.0F;
  sheet.material.gradient_to = -3.0F;
  scene.items.push_back(sheet);
  const auto image = Render(scene, FrontCamera(100.0, 20), PlainOptions(20, 20), {});
  ASSERT_TRUE(image.has_value());
  for (int y = 0; y < 20; ++y) {
    const double height = 10.0 - y - 0.5;
    const double share = std::clamp((5.0 - height) / 8.0, 0.0, 1.0);
    EXPECT_NEAR(image->rgb[image->Index(7, y)][1], 0.5 * (0.8 - 0.6 * share), 1e-5);
  }
}

}  // namespace
}  // namespace annulus
