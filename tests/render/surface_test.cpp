#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/grooves.h"
#include "render/scene.h"
#include "shapes.h"

namespace annulus {
namespace {

Material Matte(const LinearRgb& colour) {
  Material material;
  material.finish = Finish::kMatte;
  material.colour = colour;
  return material;
}

/// A square of 20 x 20 mm facing the camera, x and z from -10 to 10.
SceneItem Square(const Material& material) { return Item(QuadMesh({-10, 0, -10}, {20, 0, 0}, {0, 0, 20}), material); }

RgbImage Picture(const SceneItem& item) {
  Scene scene;
  scene.items.push_back(item);
  return Render(scene, FrontCamera(100.0, 20), PlainOptions(20, 20), {}).value();
}

TEST(Surface, VertexColoursMultiplyTheMaterials) {
  const RgbImage plain = Picture(Square(Matte({0.4F, 0.2F, 0.1F})));
  SceneItem item = Square(Matte({0.4F, 0.2F, 0.1F}));
  item.colours = {{0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1}};  // red over x, blue over z
  const RgbImage image = Picture(item);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      // The picture's right is the station's -x.
      const LinearRgb shares(1.0F - (static_cast<float>(x) + 0.5F) / 20.0F, 1.0F,
                             1.0F - (static_cast<float>(y) + 0.5F) / 20.0F);
      const LinearRgb expected = plain.rgb[plain.Index(x, y)].cwiseProduct(shares);
      EXPECT_LT((image.rgb[image.Index(x, y)] - expected).norm(), 1e-5F);
    }
  }
}

TEST(Surface, ThePartingPlaneIsSharpBetweenVertices) {
  SceneItem item = Square(Matte({0.5F, 0.0F, 0.0F}));
  item.lower = Matte({0.0F, 0.5F, 0.0F});
  // Solid coordinates turned and moved against the station: solid z = station x + 3.25.
  for (const Eigen::Vector3d& p : item.mesh.vertices) {
    item.solid.emplace_back(static_cast<float>(p.z()), 0.0F, static_cast<float>(p.x()) + 3.25F);
  }
  const RgbImage image = Picture(item);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      const bool is_upper = (10.0 - x - 0.5) + 3.25 >= 0.0;
      EXPECT_EQ(image.rgb[image.Index(x, y)][0] > 0.0F, is_upper);
      EXPECT_EQ(image.rgb[image.Index(x, y)][1] > 0.0F, !is_upper);
    }
  }
}

TEST(Surface, TexturesAreLaidInSolidCoordinates) {
  const RgbImage white = Picture(Square(Matte(LinearRgb::Constant(0.5F))));
  Material material = Matte({0.5F, 0.3F, 0.1F});
  material.texture.pattern = TexturePattern::kTortoiseshell;
  SceneItem item = Square(material);
  const RgbImage in_station = Picture(item);
  for (const Eigen::Vector3d& p : item.mesh.vertices) {
    item.solid.push_back(Eigen::Vector3f(40.0F, 5.0F, -7.0F) + p.cast<float>());
  }
  const RgbImage moved = Picture(item);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      const Eigen::Vector3f p(10.0F - static_cast<float>(x) - 0.5F, 0.0F, 10.0F - static_cast<float>(y) - 0.5F);
      const LinearRgb light = 2.0F * white.rgb[white.Index(x, y)];
      const LinearRgb here = TextureColour(material.texture, material.colour, p).cwiseProduct(light);
      const LinearRgb there =
          TextureColour(material.texture, material.colour, p + Eigen::Vector3f(40.0F, 5.0F, -7.0F)).cwiseProduct(light);
      EXPECT_LT((in_station.rgb[in_station.Index(x, y)] - here).norm(), 1e-3F);
      EXPECT_LT((moved.rgb[moved.Index(x, y)] - there).norm(), 1e-3F);
    }
  }
}

TEST(Surface, GroovesRunAlongATubeAndAroundARing) {
  TriangleMesh tube;
  TriangleMesh ring;
  constexpr std::uint32_t kAlong = 40;
  constexpr std::uint32_t kAround = 16;
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, 0.5).normalized();
  const Eigen::Vector3d u = axis.cross(Eigen::Vector3d::UnitZ()).normalized();
  for (std::uint32_t i = 0; i < kAlong; ++i) {
    const double turn = kTwoPi * i / kAlong;
    for (std::uint32_t j = 0; j < kAround; ++j) {
      const double angle = kTwoPi * j / kAround;
      tube.vertices.push_back(2.0 * i * axis + 2.0 * std::cos(angle) * u + 2.0 * std::sin(angle) * axis.cross(u));
      const double out = 25.0 + 2.0 * std::cos(angle);
      ring.vertices.emplace_back(out * std::cos(turn), out * std::sin(turn), 2.0 * std::sin(angle));
      const std::uint32_t b = i * kAround + (j + 1) % kAround;
      const std::uint32_t next = (i + 1) % kAlong;
      ring.faces.push_back({i * kAround + j, next * kAround + j, b});
      ring.faces.push_back({b, next * kAround + j, next * kAround + (j + 1) % kAround});
      if (i + 1 < kAlong) tube.faces.insert(tube.faces.end(), ring.faces.end() - 2, ring.faces.end());
    }
  }
  for (const Eigen::Vector3d& along : GrooveDirections(tube, VertexNormals(tube))) {
    EXPECT_GT(std::abs(along.dot(axis)), 0.98);
  }
  const std::vector<Eigen::Vector3d> around = GrooveDirections(ring, VertexNormals(ring));
  for (std::size_t k = 0; k < around.size(); ++k) {
    const Eigen::Vector3d& p = ring.vertices[k];
    EXPECT_GT(std::abs(around[k].dot(Eigen::Vector3d(-p.y(), p.x(), 0.0).normalized())), 0.98);
  }
}

TEST(Surface, GroovesOfAFlatPartAreHorizontal) {
  const TriangleMesh flat = QuadMesh({-10, 0, -10}, {20, 3, 0}, {0, 4, 20});
  const std::vector<Eigen::Vector3d> normals = VertexNormals(flat);
  const std::vector<Eigen::Vector3d> along = GrooveDirections(flat, normals);
  for (std::size_t k = 0; k < along.size(); ++k) {
    EXPECT_NEAR(along[k].z(), 0.0, 1e-9);
    EXPECT_NEAR(along[k].dot(normals[k]), 0.0, 1e-9);
    EXPECT_NEAR(along[k].norm(), 1.0, 1e-9);
  }
}

TEST(Surface, RefusesPerVertexValuesAndMaterialsOutOfRange) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto refused = [](const SceneItem& item, const char* why) {
    Scene scene;
    scene.items.push_back(item);
    const auto image = Render(scene, FrontCamera(100.0, 4), PlainOptions(4, 4), {});
    return !image.has_value() && image.error().Text().find(why) != std::string::npos;
  };
  const SceneItem good = Square(Matte(LinearRgb::Ones()));
  SceneItem item = good;
  item.colours.assign(3, LinearRgb::Ones());
  EXPECT_TRUE(refused(item, "3 colours for 4 vertices"));
  item.colours.assign(4, LinearRgb(0.0F, -0.1F, 0.0F));
  EXPECT_TRUE(refused(item, "colours"));
  item = good;
  item.solid.assign(4, Eigen::Vector3f(0.0F, nan, 0.0F));
  EXPECT_TRUE(refused(item, "solid coordinates"));
  item = good;
  item.lower = ExactLens(LinearRgb::Ones());
  EXPECT_TRUE(refused(item, "lower part"));
  item = Square(ExactLens(LinearRgb::Ones()));
  item.lower = good.material;
  EXPECT_TRUE(refused(item, "lower part"));
  item = Square(ExactLens(LinearRgb::Ones()));
  item.material.lens_power = 30.5F;
  EXPECT_TRUE(refused(item, "lens power"));
  item.material.lens_power = nan;
  EXPECT_TRUE(refused(item, "lens power"));
  item = Square(ExactLens(LinearRgb::Ones()));
  item.material.gradient_to = 2.0F;
  EXPECT_TRUE(refused(item, "gradient"));
  item = good;
  item.material.texture.scale = nan;
  EXPECT_TRUE(refused(item, "scale"));
  item = good;
  item.material.translucency = 1.5F;
  EXPECT_TRUE(refused(item, "translucency"));
  item = good;
  item.lower = good.material;
  item.lower->roughness = -1.0F;
  EXPECT_TRUE(refused(item, "roughness"));
  Scene scene;
  scene.lenses.emplace_back();
  const auto image = Render(scene, FrontCamera(100.0, 4), PlainOptions(4, 4), {});
  ASSERT_FALSE(image.has_value());
  EXPECT_NE(image.error().Text().find("path tracer"), std::string::npos);
}

}  // namespace
}  // namespace annulus
