#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/scene.h"
#include "shapes.h"

namespace annulus {
namespace {

/// Every pixel finite and not negative, alpha a share, depth positive or none.
void ExpectSound(const RgbImage& image) {
  for (std::size_t k = 0; k < image.rgb.size(); ++k) {
    ASSERT_TRUE(image.rgb[k].allFinite() && image.rgb[k].minCoeff() >= 0.0F) << "pixel " << k;
    ASSERT_TRUE(image.alpha[k] >= 0.0F && image.alpha[k] <= 1.0F) << "pixel " << k;
    ASSERT_TRUE(image.depth[k] > 0.0F) << "pixel " << k;
  }
}

/// Random things: the world is 200 mm wide, sizes span eight decades.
class Chance {
 public:
  explicit Chance(std::uint64_t seed) : engine_(seed) {}

  double In(double from, double to) { return from + (to - from) * static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  float Share() { return static_cast<float>(In(0.0, 1.0)); }
  LinearRgb Colour() {
    // Corners of the cube are as likely as its inside.
    const auto channel = [this] { return In(0, 1) < 0.3 ? static_cast<float>(Pick(2)) : Share(); };
    return {channel(), channel(), channel()};
  }
  int Pick(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
  Eigen::Vector3d Place(double half) { return {In(-half, half), In(-half, half), In(-half, half)}; }

  Material AnyMaterial(Finish finish) {
    Material material;
    material.finish = finish;
    material.colour = Colour();
    material.roughness = Pick(3) == 0 ? static_cast<float>(Pick(2)) : Share();
    material.transmittance = Colour();
    material.lower_transmittance = Colour();
    material.translucency = Share();
    material.texture = {static_cast<TexturePattern>(Pick(5)), Colour(), 0.1F + 9.9F * Share(),
                        static_cast<std::uint32_t>(Pick(1000))};
    const double powers[] = {-30.0, 30.0, 0.0, In(-30.0, 30.0), In(-2.0, 2.0)};
    material.lens_power = static_cast<float>(powers[Pick(5)]);
    material.gradient_from = static_cast<float>(In(-50.0, 50.0));
    material.gradient_to = material.gradient_from - (Pick(2) == 0 ? 0.0F : 60.0F * Share());
    return material;
  }

  SceneItem Soup(Finish finish) {
    SceneItem item = Item({}, AnyMaterial(finish));
    for (std::uint32_t k = 0; k < 60; ++k) {
      const double size = std::pow(10.0, In(-4.0, 4.0));
      const Eigen::Vector3d middle = Place(200.0);
      for (int c = 0; c < 3; ++c) item.mesh.vertices.push_back(middle + size * Place(1.0));
      if (Pick(8) == 0) item.mesh.vertices.back() = item.mesh.vertices[3 * k];  // without area
      item.mesh.faces.push_back({3 * k, 3 * k + 1, 3 * k + 2});
    }
    Dress(item);
    return item;
  }

  SceneItem Blob(Finish finish) {
    SceneItem item = Item(SphereMesh(Place(120.0), In(1.0, 120.0), 16), AnyMaterial(finish));
    Dress(item);
    return item;
  }

  Camera AnyCamera() {
    Camera camera = FrontCamera(300.0, 64);
    camera.eye_in_station = Place(Pick(3) == 0 ? 60.0 : 500.0);
    camera.camera_from_station = Eigen::Quaterniond(Eigen::Vector4d(In(-1, 1), In(-1, 1), In(-1, 1), In(0.1, 1)))
                                     .normalized()
                                     .toRotationMatrix();
    camera.projection = Pick(2) == 0 ? Projection::kPerspective : Projection::kOrthographic;
    const double wide = std::pow(10.0, In(-2.0, 0.5));
    camera.half_height = camera.projection == Projection::kPerspective ? wide : 150.0 * wide;
    return camera;
  }

 private:
  /// Per-vertex values and a lower part, or not.
  void Dress(SceneItem& item) {
    for (std::size_t k = 0; k < item.mesh.vertices.size(); ++k) {
      const Eigen::Vector3d normal = Pick(9) == 0 ? Eigen::Vector3d::Zero() : Place(1.0);
      item.normals.push_back(normal);
      item.colours.push_back(3.0F * Colour());
      item.solid.push_back(Place(std::pow(10.0, In(-3.0, 5.0))).cast<float>());
    }
    if (Pick(2) == 0) item.normals.clear();
    if (Pick(2) == 0) item.colours.clear();
    if (Pick(2) == 0) item.solid.clear();
    if (item.material.finish != Finish::kLens && Pick(2) == 0) {
      item.lower = AnyMaterial(static_cast<Finish>(Pick(static_cast<int>(Finish::kLens))));
    }
  }

  std::mt19937_64 engine_;
};

TEST(AnyScene, NoPixelIsEverNotANumber) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Chance chance(seed);
    Scene scene;
    for (int finish = 0; finish <= static_cast<int>(Finish::kLens); ++finish) {
      scene.items.push_back(chance.Soup(static_cast<Finish>(finish)));
      if (chance.Pick(2) == 0) scene.items.push_back(chance.Blob(static_cast<Finish>(finish)));
    }
    RenderOptions options;
    options.width = 1 + chance.Pick(60);
    options.height = 1 + chance.Pick(60);
    options.supersampling = 1 + chance.Pick(3);
    options.occlusion = chance.In(0.0, 1.0);
    options.lens_medium = chance.Pick(2) == 0 ? LensMedium::kThin : LensMedium::kFilled;
    const auto image = Render(scene, chance.AnyCamera(), options, {});
    ASSERT_TRUE(image.has_value()) << image.error().Text();
    SCOPED_TRACE(seed);
    ExpectSound(*image);
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(AnyScene, AwkwardScenesGiveSoundPictures) {
  RenderOptions options;
  options.width = 50;
  options.height = 50;
  const SceneItem head = Item(SphereMesh({0, 0, 0}, 40.0, 48), SkinMaterial());
  const auto lens = [](const TriangleMesh& mesh, float power) {
    SceneItem item = Item(mesh, ExactLens({0.7F, 0.8F, 0.9F}));
    item.material.lens_power = power;
    return item;
  };
  const TriangleMesh behind = QuadMesh({-20, -60, -10}, {40, 0, 0}, {0, 0, 20});
  const TriangleMesh huge = QuadMesh({-900, 50, -900}, {1800, 0, 0}, {0, 0, 1800});
  const TriangleMesh edge_on = QuadMesh({10, 45, -10}, {0, 20, 0}, {0, 0, 20});
  const TriangleMesh inside = QuadMesh({-60, 10, -10}, {120, 0, 0}, {0, 0, 20});
  TriangleMesh flat_line = behind;
  for (Eigen::Vector3d& p : flat_line.vertices) p = {p.x(), 50.0, 0.0};
  for (const TriangleMesh& mesh :
       {behind, huge, edge_on, inside, flat_line, SphereMesh({0, 50, 0}, 8.0, 16), TriangleMesh{}}) {
    for (const float power : {-30.0F, -4.0F, 4.0F, 30.0F}) {
      for (const int copies : {1, 2}) {
        for (const LensMedium medium : {LensMedium::kThin, LensMedium::kFilled}) {
          options.lens_medium = medium;
          Scene scene;
          scene.items.push_back(head);
          for (int k = 0; k < copies; ++k) scene.items.push_back(lens(mesh, power));
          for (const char* view : {"front", "0,10", "135,0"}) {
            const Camera camera = FrameCamera(BoundsOf({{head}, {}}), ParseView(view).value(), {}).value();
            const auto image = Render(scene, camera, options, {});
            ASSERT_TRUE(image.has_value());
            ExpectSound(*image);
          }
        }
      }
    }
  }
}

TEST(AnyScene, APictureWithoutPixelsIsRefused) {
  const Scene scene{{Item(SphereMesh({0, 0, 0}, 40.0, 48), SkinMaterial())}, {}};
  const Camera camera = FrameCamera(BoundsOf(scene), ParseView("front").value(), {}).value();
  for (const auto& [width, height] : {std::pair{0, 50}, std::pair{50, 0}, std::pair{-1, 50}, std::pair{50, 9000}}) {
    RenderOptions options;
    options.width = width;
    options.height = height;
    const auto image = Render(scene, camera, options, {});
    ASSERT_FALSE(image.has_value());
    EXPECT_NE(image.error().Text().find(std::to_string(width) + " x " + std::to_string(height)), std::string::npos);
  }
}

TEST(AnyScene, ALensBehindTheHeadChangesNothing) {
  Scene scene;
  scene.items.push_back(Item(SphereMesh({0, 0, 0}, 40.0, 48), SkinMaterial()));
  const Camera camera = FrameCamera(BoundsOf(scene), ParseView("front").value(), {}).value();
  RenderOptions options;
  options.width = 60;
  options.height = 60;
  const auto bare = Render(scene, camera, options, {});
  scene.items.push_back(Item(QuadMesh({-15, -60, -10}, {30, 0, 0}, {0, 0, 20}), ExactLens({0.1F, 0.1F, 0.1F})));
  scene.items.back().material.lens_power = 8.0F;
  const auto with = Render(scene, camera, options, {});
  EXPECT_EQ(with->rgb, bare->rgb);
}

TEST(AnyScene, MeshesWithoutFacesAreDrawnAsNothing) {
  Scene scene;
  scene.items.push_back(Item({}, SkinMaterial()));
  scene.items.push_back(Item({{{1, 2, 3}}, {}}, SkinMaterial()));
  scene.items.push_back(Item({}, ExactLens(LinearRgb::Ones())));
  const auto image = Render(scene, FrontCamera(100.0, 10), PlainOptions(10, 10), {});
  ASSERT_TRUE(image.has_value());
  for (const LinearRgb& rgb : image->rgb) EXPECT_EQ(rgb, LinearRgb(0.5F, 0.5F, 0.5F));
}

TEST(AnyScene, TenMillionTrianglesAreDrawn) {
  // A sphere of 10 million triangles (0.7 GB, about a second): its silhouette is the tangent cone of asin(r / d).
  constexpr int kCount = 3164;
  Scene scene;
  scene.items.push_back(Item(SphereMesh({0, 0, 0}, 100.0, kCount), SkinMaterial()));
  Camera camera = FrontCamera(600.0, 200);
  camera.projection = Projection::kPerspective;
  camera.half_height = 0.25;
  RenderOptions options = PlainOptions(200, 200);
  const auto image = Render(scene, camera, options, {});
  ASSERT_TRUE(image.has_value());
  double covered = 0.0;
  for (const float alpha : image->alpha) covered += static_cast<double>(alpha);
  const double in_pixels = std::tan(std::asin(100.0 / 600.0)) / 0.25 * 100.0;
  EXPECT_NEAR(covered, kPi * in_pixels * in_pixels, 60.0);
  ExpectSound(*image);
}

}  // namespace
}  // namespace annulus
