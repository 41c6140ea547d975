#include "render/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "render/png.h"
#include "shapes.h"

namespace annulus {
namespace {

Scene HeadAndFrame() {
  Scene scene;
  scene.items.push_back(Item(SphereMesh({0, 0, 0}, 40.0, 48), SkinMaterial()));
  scene.items.push_back(Item(SphereMesh({-15, 33, 5}, 14.0, 32), MetalMaterial(LinearFromHex(0xffd791))));
  scene.items.push_back(Item(SphereMesh({15, 33, 5}, 14.0, 32), PlasticMaterial(LinearFromHex(0x202020))));
  scene.items.push_back(
      Item(QuadMesh({-30, 55, -10}, {60, 3, 0}, {0, 2, 20}), LensSheetMaterial(LinearFromHex(0x88aaff), 0.6)));
  scene.items.back().material.lens_power = -4.0F;
  return scene;
}

Camera CameraOn(const Scene& scene, const char* view) {
  return FrameCamera(BoundsOf(scene), ParseView(view).value(), {}).value();
}

Scene Without(const Scene& scene, std::size_t from, std::size_t to) {
  Scene rest = scene;
  rest.items.erase(rest.items.begin() + static_cast<std::ptrdiff_t>(from),
                   rest.items.begin() + static_cast<std::ptrdiff_t>(to));
  return rest;
}

TEST(Render, EmptySceneIsTheBackdrop) {
  const auto image = Render({}, FrontCamera(100.0, 30), PlainOptions(40, 30), {});
  ASSERT_TRUE(image.has_value());
  for (const LinearRgb& rgb : image->rgb) EXPECT_EQ(rgb, LinearRgb(0.5F, 0.5F, 0.5F));
  for (const float depth : image->depth) EXPECT_EQ(depth, kNoDepth);
}

TEST(Render, LensPassesExactlyItsTransmittancePerLayer) {
  // Facing the camera, a lens mirrors the camera, not a lamp: no highlight. 0.5 and 0.25 are exact in binary.
  Scene scene;
  const Material lens = ExactLens({0.5F, 0.25F, 0.125F});
  scene.items.push_back(Item(QuadMesh({-10, 0, -10}, {20, 0, 0}, {0, 0, 20}), lens));
  const auto once = Render(scene, FrontCamera(100.0, 10), PlainOptions(10, 10), {});
  ASSERT_TRUE(once.has_value());
  for (const LinearRgb& rgb : once->rgb) EXPECT_EQ(rgb, LinearRgb(0.25F, 0.125F, 0.0625F));
  scene.items.push_back(Item(QuadMesh({-10, 5, -10}, {20, 0, 0}, {0, 0, 20}), lens));
  const auto twice = Render(scene, FrontCamera(100.0, 10), PlainOptions(10, 10), {});
  ASSERT_TRUE(twice.has_value());
  for (const LinearRgb& rgb : twice->rgb) EXPECT_EQ(rgb, LinearRgb(0.125F, 0.03125F, 0.0078125F));
}

TEST(Render, LensDarkensTheSurfaceBehindAndNotTheOneInFront) {
  Scene scene;
  scene.items.push_back(Item(QuadMesh({-10, 0, -10}, {20, 0, 0}, {0, 0, 20}), NeutralBodyMaterial()));
  const auto bare = Render(scene, FrontCamera(100.0, 8), PlainOptions(8, 8), {});
  scene.items.push_back(Item(QuadMesh({-10, 5, -10}, {20, 0, 0}, {0, 0, 20}), ExactLens({0.5F, 0.5F, 0.5F})));
  const auto behind = Render(scene, FrontCamera(100.0, 8), PlainOptions(8, 8), {});
  scene.items.back().mesh = QuadMesh({-10, -5, -10}, {20, 0, 0}, {0, 0, 20});
  const auto in_front = Render(scene, FrontCamera(100.0, 8), PlainOptions(8, 8), {});
  ASSERT_TRUE(bare && behind && in_front);
  for (std::size_t k = 0; k < bare->rgb.size(); ++k) {
    EXPECT_EQ(behind->rgb[k], LinearRgb(0.5F * bare->rgb[k]));
    EXPECT_EQ(in_front->rgb[k], bare->rgb[k]);
  }
}

TEST(Render, EdgesAreFilteredInLinearLight) {
  // An opaque black filter covers columns x < 4.25 pixels of the picture: a quarter of pixel 4.
  // The picture's right is the subject's -x, so it spans station x from 0.75 - 1.0 ... the left edge.
  Scene scene;
  scene.items.push_back(Item(QuadMesh({0.75, 0, -10}, {50, 0, 0}, {0, 0, 20}), ExactLens({0.0F, 0.0F, 0.0F})));
  RenderOptions options = PlainOptions(10, 10);
  options.supersampling = 4;
  const auto image = Render(scene, FrontCamera(100.0, 10), options, {});
  ASSERT_TRUE(image.has_value());
  EXPECT_EQ(image->rgb[image->Index(3, 5)][0], 0.0F);
  EXPECT_FLOAT_EQ(image->rgb[image->Index(4, 5)][0], 0.375F);  // (1 - 1/4) * 0.5
  EXPECT_EQ(image->rgb[image->Index(5, 5)][0], 0.5F);
}

TEST(Render, ComposingByDepthEqualsDrawingTogether) {
  const Scene scene = HeadAndFrame();
  const Scene head = Without(scene, 1, 4);
  const Scene frame = Without(scene, 0, 1);
  RenderOptions options;
  options.width = 90;
  options.height = 80;
  for (const char* view : {"front", "left45", "right45", "200,-30"}) {
    const Camera camera = CameraOn(scene, view);
    const auto together = RenderLayer(scene, camera, options, {});
    const auto composed =
        Compose(RenderLayer(head, camera, options, {}).value(), RenderLayer(frame, camera, options, {}).value());
    ASSERT_TRUE(together && composed);
    EXPECT_EQ(together->rgb, composed->rgb);
    EXPECT_EQ(together->depth, composed->depth);
    EXPECT_EQ(together->normal, composed->normal);
    const auto picture = FinishImage(*composed, frame, camera, options, {});
    EXPECT_EQ(picture->rgb, Render(scene, camera, options, {})->rgb);
  }
}

TEST(Render, SameBytesForAnyNumberOfThreads) {
  const Scene scene = HeadAndFrame();
  RenderOptions options;
  options.width = 123;
  options.height = 101;
  options.threads = 1;
  const auto one = Render(scene, CameraOn(scene, "left45"), options, {});
  ASSERT_TRUE(one.has_value());
  for (const int threads : {2, 5}) {
    options.threads = threads;
    const auto many = Render(scene, CameraOn(scene, "left45"), options, {});
    ASSERT_TRUE(many.has_value());
    EXPECT_EQ(EncodePng(*many).value(), EncodePng(*one).value());
    EXPECT_EQ(many->depth, one->depth);
  }
}

TEST(Render, DepthIsThatOfTheNearestSample) {
  Scene scene;
  scene.items.push_back(Item(QuadMesh({-10, 7, -10}, {20, 0, 0}, {0, 0, 20}), SkinMaterial()));
  RenderOptions options = PlainOptions(6, 6);
  options.supersampling = 3;
  const auto image = Render(scene, FrontCamera(100.0, 6), options, {});
  ASSERT_TRUE(image.has_value());
  for (const float depth : image->depth) EXPECT_FLOAT_EQ(depth, 93.0F);
}

TEST(Render, CornersAreDarkerThanOpenWalls) {
  // Two walls that meet at a right angle, seen along the bisector; and one flat wall.
  Scene flat;
  flat.items.push_back(Item(QuadMesh({-90, 0, -90}, {180, 0, 0}, {0, 0, 180}), NeutralBodyMaterial()));
  Scene corner;
  corner.items.push_back(Item(QuadMesh({0, 0, -90}, {90, 90, 0}, {0, 0, 180}), NeutralBodyMaterial()));
  corner.items.push_back(Item(QuadMesh({0, 0, -90}, {-90, 90, 0}, {0, 0, 180}), NeutralBodyMaterial()));
  for (const Scene& scene : {flat, corner}) {
    RenderOptions options = PlainOptions(100, 100);
    const auto without = Render(scene, FrontCamera(300.0, 100), options, {});
    options.occlusion = 1.0;
    const auto with = Render(scene, FrontCamera(300.0, 100), options, {});
    ASSERT_TRUE(without && with);
    const std::size_t middle = with->Index(51, 50);
    const std::size_t open = with->Index(80, 50);
    EXPECT_NEAR(with->rgb[open][1] / without->rgb[open][1], 1.0, 0.02);
    const float ratio = with->rgb[middle][1] / without->rgb[middle][1];
    EXPECT_LE(ratio, scene.items.size() == 1 ? 1.0F : 0.9F);
    EXPECT_GE(ratio, scene.items.size() == 1 ? 1.0F : 0.2F);
  }
}

TEST(Render, CameraInsideTheHeadSeesItFromWithin) {
  const Scene scene = HeadAndFrame();
  Camera camera = CameraOn(scene, "front");
  camera.eye_in_station = Eigen::Vector3d::Zero();
  const auto image = Render(scene, camera, PlainOptions(64, 64), {});
  ASSERT_TRUE(image.has_value());
  for (const LinearRgb& rgb : image->rgb) EXPECT_TRUE(rgb.allFinite() && rgb.minCoeff() >= 0.0F);
  for (const float depth : image->depth) EXPECT_LE(depth, 41.0F);
}

TEST(Render, NoPixelIsEverNotANumber) {
  std::mt19937_64 engine(8);
  const auto uniform = [&engine] { return static_cast<double>(engine() >> 11) * 0x1.0p-53 * 2.0 - 1.0; };
  for (int round = 0; round < 8; ++round) {
    Scene scene;
    for (const Material& material : {SkinMaterial(), MetalMaterial(LinearFromHex(0xffd791)),
                                     PlasticMaterial(LinearRgb::Zero()), LensSheetMaterial(LinearRgb::Zero(), 0.3)}) {
      TriangleMesh mesh;
      for (std::uint32_t k = 0; k < 200; ++k) {
        const double size = std::pow(10.0, 4.0 * uniform());
        const Eigen::Vector3d middle = 200.0 * Eigen::Vector3d(uniform(), uniform(), uniform());
        for (int c = 0; c < 3; ++c) {
          mesh.vertices.push_back(middle + size * Eigen::Vector3d(uniform(), uniform(), uniform()));
        }
        mesh.faces.push_back({3 * k, 3 * k + 1, 3 * k + 2});
      }
      scene.items.push_back(Item(mesh, material));
    }
    Camera camera = FrontCamera(300.0, 64);
    camera.projection = round % 2 == 0 ? Projection::kPerspective : Projection::kOrthographic;
    camera.half_height = round % 2 == 0 ? 0.4 : 150.0;
    RenderOptions options;
    options.width = 64;
    options.height = 48;
    const auto image = Render(scene, camera, options, {});
    ASSERT_TRUE(image.has_value());
    for (const LinearRgb& rgb : image->rgb) EXPECT_TRUE(rgb.allFinite() && rgb.minCoeff() >= 0.0F);
  }
}

TEST(Render, RefusesBrokenMeshesAndSaysWhich) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const Camera camera = FrontCamera(100.0, 10);
  for (const double bad : {nan, infinity, -infinity, 1e300, 2e6}) {
    Scene scene = HeadAndFrame();
    scene.items[1].group = "frame";
    scene.items[1].mesh.vertices[7].z() = bad;
    const auto image = Render(scene, camera, PlainOptions(10, 10), {});
    ASSERT_FALSE(image.has_value());
    EXPECT_NE(image.error().Text().find("'frame': vertex 7"), std::string::npos);
  }
  Scene scene = HeadAndFrame();
  scene.items[0].mesh.faces[3][1] = 1'000'000;
  EXPECT_FALSE(Render(scene, camera, PlainOptions(10, 10), {}).has_value());
  scene = HeadAndFrame();
  scene.items[0].normals.resize(2, Eigen::Vector3d::UnitX());
  EXPECT_FALSE(Render(scene, camera, PlainOptions(10, 10), {}).has_value());
  scene = HeadAndFrame();
  scene.items[3].material.transmittance[1] = static_cast<float>(nan);
  EXPECT_FALSE(Render(scene, camera, PlainOptions(10, 10), {}).has_value());
}

TEST(Render, RefusesSizesOutOfRange) {
  const Camera camera = FrontCamera(100.0, 10);
  for (const auto& [width, height, side] : std::initializer_list<std::array<int, 3>>{{0, 10, 1},
                                                                                     {10, 0, 1},
                                                                                     {-5, 10, 1},
                                                                                     {8193, 10, 1},
                                                                                     {10, 8193, 1},
                                                                                     {10, 10, 0},
                                                                                     {10, 10, 9},
                                                                                     {8192, 8192, 2}}) {
    RenderOptions options = PlainOptions(width, height);
    options.supersampling = side;
    EXPECT_FALSE(Render({}, camera, options, {}).has_value()) << width << " " << height << " " << side;
  }
  EXPECT_TRUE(Render({}, camera, PlainOptions(8192, 1), {}).has_value());
  EXPECT_TRUE(Render(HeadAndFrame(), camera, PlainOptions(1, 1), {}).has_value());
}

TEST(Render, RefusesABrokenCameraAndAForeignLayer) {
  Camera camera = FrontCamera(100.0, 10);
  const Layer layer = RenderLayer({}, camera, PlainOptions(10, 10), {}).value();
  EXPECT_FALSE(FinishImage(layer, {}, camera, PlainOptions(11, 10), {}).has_value());
  EXPECT_FALSE(Compose(layer, RenderLayer({}, camera, PlainOptions(5, 10), {}).value()).has_value());
  camera.near_mm = 0.0;
  EXPECT_FALSE(Render({}, camera, PlainOptions(10, 10), {}).has_value());
  camera = FrontCamera(100.0, 10);
  camera.eye_in_station.x() = std::nan("");
  EXPECT_FALSE(Render({}, camera, PlainOptions(10, 10), {}).has_value());
}

TEST(Render, StopsWhenAskedTo) {
  std::stop_source source;
  source.request_stop();
  const auto image = Render(HeadAndFrame(), FrontCamera(100.0, 90), PlainOptions(90, 90), {{}, source.get_token()});
  ASSERT_FALSE(image.has_value());
  EXPECT_NE(image.error().Text().find("stopped"), std::string::npos);
}

TEST(Render, GivenNormalsReplaceTheFacesOwn) {
  // A flat square with normals turned by 60 degrees is shaded differently from a flat one.
  Scene scene;
  scene.items.push_back(Item(QuadMesh({-10, 0, -10}, {20, 0, 0}, {0, 0, 20}), SkinMaterial()));
  const auto flat = Render(scene, FrontCamera(100.0, 4), PlainOptions(4, 4), {});
  scene.items[0].normals.assign(4, Eigen::Vector3d(0.0, 0.5, -std::sqrt(0.75)));
  const auto turned = Render(scene, FrontCamera(100.0, 4), PlainOptions(4, 4), {});
  ASSERT_TRUE(flat && turned);
  EXPECT_LT(turned->rgb[5].sum(), flat->rgb[5].sum());
}

}  // namespace
}  // namespace annulus
