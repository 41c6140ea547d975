#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "difference.h"
#include "picture.h"
#include "tests/render/shapes.h"
#include "tests/support/face_scene.h"

namespace annulus {
namespace {

using test::Difference;
using test::Shot;

/// What the issue allows, in 1/255 of sRGB.
constexpr double kAllowed = 2.0;
/// How many pixels may be edges.
constexpr double kMostEdges = 0.15;

RgbImage Trace(const Shot& shot, int width, int height) {
  TraceOptions options;
  options.width = width;
  options.height = height;
  options.samples = 32;
  options.seed = 5;
  options.threads = 1;
  options.max_bounces = 0;  // as povray without radiosity
  options.denoising = Denoising::kOff;
  options.tone_curve = ToneCurve::kLinear;
  options.background = TraceOptions::Background::kEnvironment;
  const Result<Tracer> tracer = Tracer::Make(shot.scene);
  if (!tracer) throw std::runtime_error(tracer.error().Text());
  Result<RgbImage> image = tracer->Trace(shot.camera, shot.lighting, options, {});
  if (!image) throw std::runtime_error(image.error().Text());
  return *std::move(image);
}

/// Both programs draw the shot; the mean difference is within what is allowed.
void ExpectTheSamePicture(const Shot& shot, const std::string& name, int size = 144) {
  test::PovraySampling sampling;
  sampling.width = size;
  sampling.height = size;
  sampling.threshold = 0.03;
  sampling.depth = 2;
  const RgbImage theirs = test::Povray(shot, {}, sampling, name);
  const RgbImage ours = Trace(shot, size, size);
  const Difference difference = test::Compare(shot, ours, theirs);
  std::printf("%s: mean %.3f/255, 99%% below %.2f/255, edges %.1f %%, %d pixels\n", name.c_str(), difference.mean_255,
              difference.p99_255, 100.0 * difference.edge_share, difference.compared);
  EXPECT_GT(difference.compared, 3500) << name;
  EXPECT_LE(difference.mean_255, kAllowed) << name;
  EXPECT_LE(difference.edge_share, kMostEdges) << name;
}

/// Key, fill and rim as far lights, so placed that the lenses are met within 45 degrees.
std::vector<FarLight> ThreeLights() {
  return {{Eigen::Vector3d(-0.45, 0.8, 0.45).normalized(), LinearRgb(0.7F, 0.68F, 0.62F)},
          {Eigen::Vector3d(0.5, 0.85, 0.1).normalized(), LinearRgb(0.22F, 0.24F, 0.27F)},
          {Eigen::Vector3d(-0.7, -0.5, 0.5).normalized(), LinearRgb(0.4F, 0.4F, 0.45F)}};
}

Camera CameraOnFace(const char* view) {
  // The face fills the picture: eyes in the middle.
  const sim::FaceTruth face = sim::MakeHead({}).face();
  const Eigen::Vector3d middle = 0.5 * (face.right_eye + face.left_eye);
  const Eigen::Vector3d reach(75.0, 75.0, 75.0);
  return *FrameCamera(Eigen::AlignedBox3d(middle - reach, middle + reach), *ParseView(view), {});
}

/// A wall 250 mm behind the head, turned a little.
void AddWall(Scene& scene) {
  const Eigen::Vector3d middle = BoundsOf(scene).center();
  const Eigen::Vector3d u(1600.0, 200.0, 0.0);
  const Eigen::Vector3d v(0.0, -150.0, 1600.0);
  scene.items.push_back(Item(QuadMesh(middle - 0.5 * u - 0.5 * v - Eigen::Vector3d(0.0, 250.0, 0.0), u, v),
                             test::Matte(LinearRgb(0.25F, 0.4F, 0.55F))));
}

TEST(TracerBesidePovray, HeadUnderThreeLightsIsTheSameFromAllSides) {
  if (!test::HasPovray()) GTEST_SKIP() << "no povray here";
  Shot shot;
  shot.scene = *test::FaceScene(120, 100, {});
  shot.lighting.lights = ThreeLights();
  for (const char* view : {"front", "left45", "20,-30"}) {
    shot.camera = *FrameCamera(BoundsOf(shot.scene), *ParseView(view), {});
    ExpectTheSamePicture(shot, view);
  }
}

TEST(TracerBesidePovray, ShadowsBetweenSimpleThingsAreTheSame) {
  if (!test::HasPovray()) GTEST_SKIP() << "no povray here";
  Shot shot;
  auto& items = shot.scene.items;
  items.push_back(Item(SphereMesh({-30.0, 0.0, 30.0}, 30.0, 120), test::Matte(LinearRgb(0.8F, 0.2F, 0.1F))));
  items.push_back(Item(SphereMesh({45.0, 25.0, 20.0}, 20.0, 120), test::Matte(LinearRgb(0.1F, 0.6F, 0.3F))));
  items.push_back(Item(QuadMesh({-120.0, -120.0, 0.0}, {240.0, 0.0, 0.0}, {0.0, 240.0, 0.0}),
                       test::Matte(LinearRgb(0.7F, 0.7F, 0.7F))));
  items.push_back(Item(QuadMesh({-20.0, -60.0, 0.0}, {60.0, -10.0, 0.0}, {0.0, 5.0, 90.0}),
                       test::Matte(LinearRgb(0.2F, 0.3F, 0.9F))));
  for (SceneItem& item : items) item.normals = VertexNormals(item.mesh);
  shot.lighting.lights = {{Eigen::Vector3d(0.5, 0.6, 0.8).normalized(), LinearRgb(0.8F, 0.75F, 0.7F)},
                          {Eigen::Vector3d(-0.6, 0.5, 0.4).normalized(), LinearRgb(0.2F, 0.25F, 0.3F)}};
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    Framing framing;
    framing.projection = projection;
    shot.camera = *FrameCamera(BoundsOf(shot.scene), *ParseView("75,35"), framing);
    ExpectTheSamePicture(shot, projection == Projection::kPerspective ? "perspective" : "orthographic", 220);
  }
}

TEST(TracerBesidePovray, FaceBehindItsLensesIsTheSame) {
  if (!test::HasPovray()) GTEST_SKIP() << "no povray here";
  Shot shot;
  shot.lighting.lights = ThreeLights();
  const std::pair<const char*, std::vector<SpheroCylinder>> pairs[] = {{"minus", {{-6.0, 0.0, kPi}, {-4.0, -2.0, 0.6}}},
                                                                       {"plus", {{5.0, 0.0, kPi}, {3.0, -1.5, 2.2}}}};
  for (const auto& [name, orders] : pairs) {
    test::FaceLenses lenses;
    lenses.orders = orders;
    Result<Scene> scene = test::FaceScene(120, 100, lenses);
    ASSERT_TRUE(scene) << scene.error().Text();
    shot.scene = *std::move(scene);
    AddWall(shot.scene);
    const char* view = orders[0].sphere < 0.0 ? "front" : "115,10";
    shot.camera = CameraOnFace(view);
    ExpectTheSamePicture(shot, std::string(name) + "-" + view);
  }
}

TEST(TracerBesidePovray, TintedLensesDimFaceAndShadowAlike) {
  if (!test::HasPovray()) GTEST_SKIP() << "no povray here";
  Shot shot;
  shot.lighting.lights = ThreeLights();
  test::FaceLenses lenses;
  lenses.orders = {{0.0, 0.0, kPi}, {-2.0, 0.0, kPi}};
  lenses.transmittance = LinearRgb(0.55F, 0.45F, 0.35F);
  Result<Scene> scene = test::FaceScene(120, 100, lenses);
  ASSERT_TRUE(scene) << scene.error().Text();
  shot.scene = *std::move(scene);
  AddWall(shot.scene);
  shot.camera = CameraOnFace("front");
  ExpectTheSamePicture(shot, "tinted");
}

}  // namespace
}  // namespace annulus
