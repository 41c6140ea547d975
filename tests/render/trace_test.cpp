#include "render/trace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "render/tone.h"
#include "tests/render/shapes.h"

namespace annulus {
namespace {

/// A scene of one sphere, radius 40 mm.
Scene SphereScene(const Material& material) {
  Scene scene;
  scene.items.push_back(Item(SphereMesh({0.0, 0.0, 0.0}, 40.0, 64), material));
  return scene;
}

Material White(Finish finish, float roughness) {
  Material material;
  material.finish = finish;
  material.colour = LinearRgb::Ones();
  material.roughness = roughness;
  return material;
}

/// A round lens of two spherical surfaces (radii 90 and 200 mm, 4 mm thick, index 1.6), as seen from +y, at `place`.
SolidLens RoundLens(const Eigen::Vector3d& place, LensCoating coating) {
  SolidLens lens;
  lens.form.index = 1.6;
  lens.form.centre_thickness = 4.0;
  lens.form.front.curvature_u = lens.form.front.curvature_v = 1.0 / 90.0;
  lens.form.back.curvature_u = lens.form.back.curvature_v = 1.0 / 200.0;
  lens.form.back.lens_from_surface.translation() = Eigen::Vector3d(0.0, 0.0, -4.0);
  for (int k = 0; k < 180; ++k) {
    const double angle = kTwoPi * k / 180;
    lens.outline.points.emplace_back(18.0 * std::cos(angle), 14.0 * std::sin(angle));
  }
  Eigen::Matrix3d turn;
  turn << -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0;
  lens.station_from_lens.linear() = turn;
  lens.station_from_lens.translation() = place;
  lens.finish.coating = coating;
  return lens;
}

/// Light as it is: no tone curve, no denoising, the environment behind.
TraceOptions TrueLight(int size, int samples) {
  TraceOptions options;
  options.width = size;
  options.height = size;
  options.samples = samples;
  options.threads = 1;
  options.denoising = Denoising::kOff;
  options.tone_curve = ToneCurve::kLinear;
  options.background = TraceOptions::Background::kEnvironment;
  return options;
}

Lighting Furnace() { return {Environment::Uniform(LinearRgb::Ones()), {}}; }

RgbImage Traced(const Scene& scene, const Camera& camera, const Lighting& lighting, const TraceOptions& options) {
  const Result<Tracer> tracer = Tracer::Make(scene);
  EXPECT_TRUE(tracer.has_value());
  const Result<RgbImage> image = tracer->Trace(camera, lighting, options, {});
  EXPECT_TRUE(image.has_value()) << (image ? "" : image.error().Text());
  return image.value_or(RgbImage{});
}

LinearRgb MeanOf(const RgbImage& image) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const LinearRgb& rgb : image.rgb) sum += rgb.cast<double>();
  return (sum / static_cast<double>(image.rgb.size())).cast<float>();
}

/// A camera whose picture lies within the sphere of SphereScene.
Camera CloseCamera() {
  Camera camera = FrontCamera(300.0, 50);
  return camera;
}

TEST(Trace, WhiteThingsVanishInAWhiteFurnace) {
  Material translucent = White(Finish::kTranslucent, 0.2F);
  translucent.translucency = 0.5F;
  const std::vector<Material> materials = {White(Finish::kMatte, 1.0F),   White(Finish::kPlastic, 0.2F),
                                           White(Finish::kSkin, 0.45F),   White(Finish::kMetal, 0.3F),
                                           White(Finish::kBrushed, 0.3F), translucent};
  for (const Material& material : materials) {
    for (const bool with_lenses : {false, true}) {
      Scene scene = SphereScene(material);
      if (with_lenses) {
        scene.lenses.push_back(RoundLens({-8.0, 48.0, 0.0}, LensCoating::kNone));
        scene.lenses.push_back(RoundLens({14.0, 55.0, 6.0}, LensCoating::kMirror));
      }
      TraceOptions options = TrueLight(32, 256);
      options.max_bounces = 64;
      const LinearRgb mean = MeanOf(Traced(scene, CloseCamera(), Furnace(), options));
      for (int channel = 0; channel < 3; ++channel) {
        EXPECT_NEAR(mean[channel], 1.0F, 0.002F)
            << "finish " << static_cast<int>(material.finish) << (with_lenses ? " with lenses" : "");
      }
    }
  }
}

/// A box without its side towards +y, 40 mm wide, 60 mm deep.
Scene OpenBox(const Material& material) {
  Scene scene;
  TriangleMesh box = QuadMesh({-20, -60, -20}, {40, 0, 0}, {0, 0, 40});
  Append(box, QuadMesh({-20, -60, -20}, {0, 60, 0}, {0, 0, 40}));
  Append(box, QuadMesh({20, -60, -20}, {0, 60, 0}, {0, 0, 40}));
  Append(box, QuadMesh({-20, -60, -20}, {0, 60, 0}, {40, 0, 0}));
  Append(box, QuadMesh({-20, -60, 20}, {0, 60, 0}, {40, 0, 0}));
  scene.items.push_back(Item(box, material));
  return scene;
}

TEST(Trace, ADeepWhiteBoxVanishesInAWhiteFurnaceIfPathsAreLongEnough) {
  Scene scene = OpenBox(White(Finish::kMatte, 1.0F));
  TraceOptions options = TrueLight(24, 512);
  options.max_bounces = 64;
  Camera camera = FrontCamera(300.0, 36);
  camera.projection = Projection::kPerspective;
  camera.half_height = 18.0 / 300.0;
  EXPECT_NEAR(MeanOf(Traced(scene, camera, Furnace(), options))[1], 1.0F, 0.002F);
  // A lens across its mouth changes nothing.
  scene.lenses.push_back(RoundLens({0.0, 4.0, 0.0}, LensCoating::kAntiReflective));
  EXPECT_NEAR(MeanOf(Traced(scene, camera, Furnace(), options))[1], 1.0F, 0.002F);
  // Short paths lose light and never make any.
  options.max_bounces = 1;
  const float cut = MeanOf(Traced(scene, camera, Furnace(), options))[1];
  EXPECT_LT(cut, 0.9F);
  EXPECT_GT(cut, 0.1F);
}

TEST(Trace, DispersionLeavesWhiteWhite) {
  Scene scene = SphereScene(White(Finish::kMatte, 1.0F));
  scene.lenses.push_back(RoundLens({0.0, 48.0, 0.0}, LensCoating::kNone));
  scene.lenses[0].abbe = 30.0;
  TraceOptions options = TrueLight(32, 64);
  options.dispersion = Dispersion::kOn;
  options.max_bounces = 64;
  const LinearRgb mean = MeanOf(Traced(scene, CloseCamera(), Furnace(), options));
  for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(mean[channel], 1.0F, 0.004F) << channel;
}

TEST(Trace, AFarLightOnAMattePlateFollowsLambertsCosine) {
  Scene scene;
  Material grey = White(Finish::kMatte, 1.0F);
  grey.colour = LinearRgb(0.5F, 0.25F, 0.125F);
  scene.items.push_back(Item(QuadMesh({-50, 0, -50}, {100, 0, 0}, {0, 0, 100}), grey));
  for (const double angle : {0.0, 0.5, 1.2, 2.0}) {
    const Eigen::Vector3d towards(std::sin(angle), std::cos(angle), 0.0);
    const Lighting lighting{Environment::Uniform(LinearRgb::Zero()), {{towards, LinearRgb(2.0F, 2.0F, 2.0F)}}};
    const RgbImage image = Traced(scene, FrontCamera(100.0, 16), lighting, TrueLight(16, 1));
    const auto cosine = static_cast<float>(std::max(0.0, std::cos(angle)));
    for (const LinearRgb& rgb : image.rgb) {
      EXPECT_NEAR(rgb[0], 1.0F * cosine, 1e-5F);
      EXPECT_NEAR(rgb[2], 0.25F * cosine, 1e-5F);
    }
  }
}

TEST(Trace, ABlackWallTakesHalfOfAnEvenSkyAndThrowsAHardShadowOfASun) {
  // Floor y = 0 seen from above (+y); a tall black wall stands on x = 0.
  Scene scene;
  scene.items.push_back(Item(QuadMesh({-50, 0, -50}, {100, 0, 0}, {0, 0, 100}), White(Finish::kMatte, 1.0F)));
  Material black = White(Finish::kMatte, 1.0F);
  black.colour.setZero();
  scene.items.push_back(Item(QuadMesh({0, 0, -1e5}, {0, 1e5, 0}, {0, 0, 2e5}), black));
  Camera camera = FrontCamera(100.0, 40);
  camera.near_mm = 50.0;  // within the wall's height, seen edge on
  TraceOptions options = TrueLight(40, 256);
  const RgbImage sky = Traced(scene, camera, Furnace(), options);
  // The wall covers half of the hemisphere of every point, whatever its distance: it is endless.
  EXPECT_NEAR(MeanOf(sky)[1], 0.5F, 0.004F);
  const Eigen::Vector3d towards = Eigen::Vector3d(1.0, 1.0, 0.0).normalized();
  const Lighting sun{Environment::Uniform(LinearRgb::Zero()), {{towards, LinearRgb::Ones()}}};
  const RgbImage shadow = Traced(scene, camera, sun, TrueLight(40, 1));
  // FrontCamera has +x to the left.
  EXPECT_NEAR(shadow.rgb[shadow.Index(5, 20)][1], std::sqrt(0.5F), 1e-4F);
  EXPECT_EQ(shadow.rgb[shadow.Index(35, 20)][1], 0.0F);
}

TEST(Trace, ALensSheetPassesAndMirrorsWhatTheTwoFacesOfPlasticDo) {
  // Normal incidence, index 1.5: a face mirrors 0.04, both with all reflections between them 2 · 0.04 / 1.04.
  Scene scene;
  scene.items.push_back(Item(QuadMesh({-50, 0, -50}, {100, 0, 0}, {0, 0, 100}), ExactLens({1.0F, 0.5F, 0.25F})));
  const RgbImage image = Traced(scene, FrontCamera(100.0, 16), Furnace(), TrueLight(16, 16));
  const float mirrored = 0.08F / 1.04F;
  for (const LinearRgb& rgb : image.rgb) {
    EXPECT_NEAR(rgb[0], 1.0F, 1e-5F);
    EXPECT_NEAR(rgb[1], mirrored + 0.5F * (1.0F - mirrored), 1e-5F);
    EXPECT_NEAR(rgb[2], mirrored + 0.25F * (1.0F - mirrored), 1e-5F);
  }
  // Light on its way to a matte plate behind the sheet is dimmed once more.
  Material white = White(Finish::kMatte, 1.0F);
  scene.items.push_back(Item(QuadMesh({-50, -10, -50}, {100, 0, 0}, {0, 0, 100}), white));
  const Lighting sun{Environment::Uniform(LinearRgb::Zero()), {{Eigen::Vector3d::UnitY(), LinearRgb::Ones()}}};
  TraceOptions options = TrueLight(16, 1);
  options.max_bounces = 0;
  const RgbImage behind = Traced(scene, FrontCamera(100.0, 16), sun, options);
  for (const LinearRgb& rgb : behind.rgb) EXPECT_NEAR(rgb[1], std::pow(0.5F * (1.0F - mirrored), 2.0F), 1e-4F);
}

TEST(Trace, AlphaAndDepthAreThoseOfTheZBuffer) {
  Scene scene = SphereScene(White(Finish::kMatte, 1.0F));
  scene.items.push_back(Item(QuadMesh({-70, 20, -10}, {60, 0, 5}, {0, 8, 30}), White(Finish::kMatte, 1.0F)));
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    Camera camera = FrontCamera(300.0, 160);
    camera.projection = projection;
    if (projection == Projection::kPerspective) camera.half_height = 80.0 / 300.0;
    TraceOptions options = TrueLight(60, 64);
    options.max_bounces = 0;
    const RgbImage traced = Traced(scene, camera, Furnace(), options);
    RenderOptions raster = PlainOptions(60, 60);
    raster.supersampling = 8;
    const RgbImage drawn = Render(scene, camera, raster, {}).value();
    double alpha_error = 0.0;
    int compared = 0;
    for (std::size_t k = 0; k < drawn.alpha.size(); ++k) {
      alpha_error += std::abs(static_cast<double>(traced.alpha[k] - drawn.alpha[k])) / 3600.0;
      const bool is_inside = k > 60 && k + 61 < drawn.depth.size();
      // Where the depth changes little within the pixel, the nearest sample is much the same.
      if (is_inside && drawn.alpha[k] == 1.0F && std::abs(drawn.depth[k - 1] - drawn.depth[k + 1]) < 2.0F &&
          std::abs(drawn.depth[k - 60] - drawn.depth[k + 60]) < 2.0F) {
        EXPECT_NEAR(traced.depth[k], drawn.depth[k], 1.5F);
        ++compared;
      }
      if (drawn.alpha[k] == 0.0F) {
        EXPECT_LT(traced.alpha[k], 0.1F);
      }
    }
    EXPECT_LT(alpha_error, 0.002);
    EXPECT_GT(compared, 200);
  }
}

TEST(Trace, NothingIsDrawnBeforeTheNearPlane) {
  Camera camera = FrontCamera(300.0, 100);
  camera.near_mm = 290.0;  // behind the front of the sphere, whose middle is at 300
  const RgbImage image = Traced(SphereScene(White(Finish::kMatte, 1.0F)), camera, Furnace(), TrueLight(40, 4));
  for (const float depth : image.depth) EXPECT_GE(depth, 290.0F);
  EXPECT_NEAR(image.depth[image.Index(20, 20)], 340.0F, 0.5F);
}

TEST(Trace, AnEmptySceneIsTheBackdrop) {
  TraceOptions options;
  options.width = 40;
  options.height = 30;
  options.samples = 2;
  const RgbImage traced = Traced({}, FrontCamera(100.0, 30), {}, options);
  RenderOptions raster;
  raster.width = 40;
  raster.height = 30;
  const RgbImage drawn = Render({}, FrontCamera(100.0, 30), raster, {}).value();
  for (std::size_t k = 0; k < drawn.rgb.size(); ++k) {
    EXPECT_LT((traced.rgb[k] - drawn.rgb[k]).cwiseAbs().maxCoeff(), 1e-5F);
    EXPECT_EQ(traced.alpha[k], 0.0F);
    EXPECT_EQ(traced.depth[k], kNoDepth);
  }
}

/// A sphere with a frame-like ring of plastic and metal, two lenses and a sheet.
Scene MixedScene() {
  Scene scene = SphereScene(SkinMaterial());
  scene.items.push_back(Item(QuadMesh({-30, 44, 6}, {60, 0, 0}, {0, 2, 4}), PlasticMaterial({0.1F, 0.02F, 0.01F})));
  scene.items.push_back(Item(QuadMesh({-30, 44, -14}, {60, 0, 0}, {0, 2, 4}), MetalMaterial({0.9F, 0.8F, 0.5F})));
  scene.items.push_back(Item(QuadMesh({-10, 60, -30}, {20, 0, 0}, {0, 0, 15}), ExactLens({0.5F, 0.7F, 0.9F})));
  scene.lenses.push_back(RoundLens({-18.0, 48.0, 0.0}, LensCoating::kAntiReflective));
  scene.lenses.push_back(RoundLens({18.0, 48.0, 0.0}, LensCoating::kNone));
  return scene;
}

TEST(Trace, TheSameBytesForAnyNumberOfThreads) {
  const Result<Tracer> tracer = Tracer::Make(MixedScene());
  ASSERT_TRUE(tracer.has_value());
  TraceOptions options;
  options.width = 50;
  options.height = 40;
  options.samples = 5;
  options.threads = 1;
  const RgbImage one = tracer->Trace(FrontCamera(300.0, 100), {}, options, {}).value();
  for (const int threads : {2, 3}) {
    options.threads = threads;
    const RgbImage other = tracer->Trace(FrontCamera(300.0, 100), {}, options, {}).value();
    EXPECT_EQ(other.rgb, one.rgb);
    EXPECT_EQ(other.depth, one.depth);
    EXPECT_EQ(other.alpha, one.alpha);
  }
  const RgbImage rebuilt = Traced(MixedScene(), FrontCamera(300.0, 100), {}, options);
  EXPECT_EQ(rebuilt.rgb, one.rgb);
  options.seed = 1;
  EXPECT_NE(tracer->Trace(FrontCamera(300.0, 100), {}, options, {}).value().rgb, one.rgb);
}

TEST(Trace, PassesComeAtPowersOfTwoAndGetBetter) {
  const Result<Tracer> tracer = Tracer::Make(MixedScene());
  ASSERT_TRUE(tracer.has_value());
  TraceOptions options = TrueLight(40, 44);
  const RgbImage final = tracer->Trace(FrontCamera(300.0, 100), {}, options, {}).value();
  std::vector<int> samples;
  std::vector<double> errors;
  std::vector<double> reported;
  const TaskContext task{[&](std::string_view, double done, double total) {
                           EXPECT_EQ(total, 44.0);
                           reported.push_back(done);
                         },
                         {}};
  const RgbImage again = tracer
                             ->Trace(FrontCamera(300.0, 100), {}, options, task,
                                     [&](const TracePass& pass) {
                                       samples.push_back(pass.samples);
                                       double error = 0.0;
                                       for (std::size_t k = 0; k < final.rgb.size(); ++k) {
                                         error += (pass.image.rgb[k] - final.rgb[k]).squaredNorm();
                                       }
                                       errors.push_back(error);
                                     })
                             .value();
  EXPECT_EQ(again.rgb, final.rgb);
  EXPECT_EQ(samples, (std::vector<int>{1, 2, 4, 8, 16, 32, 44}));
  EXPECT_TRUE(std::is_sorted(errors.rbegin(), errors.rend()));
  EXPECT_EQ(errors.back(), 0.0);
  EXPECT_TRUE(std::is_sorted(reported.begin(), reported.end()));
  EXPECT_EQ(reported.back(), 44.0);
}

TEST(Trace, StopsWhenAskedTo) {
  const Result<Tracer> tracer = Tracer::Make(MixedScene());
  ASSERT_TRUE(tracer.has_value());
  std::stop_source source;
  int passes = 0;
  const Result<RgbImage> image =
      tracer->Trace(FrontCamera(300.0, 100), {}, {}, {{}, source.get_token()}, [&](const TracePass&) {
        ++passes;
        source.request_stop();
      });
  ASSERT_FALSE(image.has_value());
  EXPECT_NE(image.error().Text().find("stopped"), std::string::npos);
  EXPECT_EQ(passes, 1);
}

TEST(Trace, DenoisingBringsAFewSamplesCloserToManySamples) {
  const Result<Tracer> tracer = Tracer::Make(MixedScene());
  ASSERT_TRUE(tracer.has_value());
  const Camera camera = FrontCamera(300.0, 100);
  TraceOptions options;
  options.width = options.height = 64;
  options.threads = 1;
  options.samples = 512;
  options.denoising = Denoising::kOff;
  const RgbImage converged = tracer->Trace(camera, {}, options, {}).value();
  const auto error = [&](int samples, Denoising denoising) {
    options.samples = samples;
    options.denoising = denoising;
    const RgbImage image = tracer->Trace(camera, {}, options, {}).value();
    double sum = 0.0;
    for (std::size_t k = 0; k < image.rgb.size(); ++k) sum += (image.rgb[k] - converged.rgb[k]).squaredNorm();
    return std::sqrt(sum);
  };
  for (const int samples : {4, 16}) {
    const double noisy = error(samples, Denoising::kOff);
    const double clean = error(samples, Denoising::kOn);
    RecordProperty("factor_" + std::to_string(samples), std::to_string(noisy / clean));
    EXPECT_LT(clean, noisy / 1.5) << samples;
  }
}

TEST(Trace, NoPixelIsEverNotANumber) {
  std::mt19937_64 engine(8);
  const auto uniform = [&engine] { return static_cast<double>(engine() >> 11) * 0x1.0p-53 * 2.0 - 1.0; };
  for (int round = 0; round < 6; ++round) {
    Scene scene;
    Material brushed = White(Finish::kBrushed, 0.0F);
    Material milky = White(Finish::kTranslucent, 1.0F);
    milky.translucency = 1.0F;
    for (const Material& material : {SkinMaterial(), MetalMaterial(LinearFromHex(0xffd791)), brushed, milky,
                                     PlasticMaterial(LinearRgb::Zero()), ExactLens({0.0F, 0.5F, 1.0F})}) {
      TriangleMesh mesh;
      for (std::uint32_t k = 0; k < 100; ++k) {
        const double size = std::pow(10.0, 4.0 * uniform());
        const Eigen::Vector3d middle = 200.0 * Eigen::Vector3d(uniform(), uniform(), uniform());
        for (int c = 0; c < 3; ++c) {
          mesh.vertices.push_back(middle + size * Eigen::Vector3d(uniform(), uniform(), uniform()));
        }
        mesh.faces.push_back({3 * k, 3 * k + 1, 3 * k + (k % 7 == 0 ? 1 : 2)});
      }
      scene.items.push_back(Item(mesh, material));
    }
    scene.lenses.push_back(RoundLens(60.0 * Eigen::Vector3d(uniform(), uniform(), uniform()), LensCoating::kMirror));
    scene.lenses.push_back(RoundLens(60.0 * Eigen::Vector3d(uniform(), uniform(), uniform()), LensCoating::kNone));
    Camera camera = FrontCamera(300.0, 64);
    camera.projection = round % 2 == 0 ? Projection::kPerspective : Projection::kOrthographic;
    camera.half_height = round % 2 == 0 ? 0.4 : 150.0;
    TraceOptions options;
    options.width = 48;
    options.height = 36;
    options.samples = 4;
    options.threads = 1;
    options.dispersion = round % 3 == 0 ? Dispersion::kOn : Dispersion::kOff;
    options.denoising = round % 2 == 0 ? Denoising::kOn : Denoising::kOff;
    const Lighting lighting{Environment::Preset(static_cast<LightPreset>(round % 3)),
                            {{Eigen::Vector3d::UnitZ(), LinearRgb::Ones()}}};
    const RgbImage image = Traced(scene, camera, lighting, options);
    for (const LinearRgb& rgb : image.rgb) EXPECT_TRUE(rgb.allFinite() && rgb.minCoeff() >= 0.0F);
    for (const float alpha : image.alpha) EXPECT_TRUE(alpha >= 0.0F && alpha <= 1.0F);
  }
}

TEST(Trace, ACameraInsideTheHeadSeesItFromWithin) {
  Camera camera = FrontCamera(0.0, 64);
  camera.projection = Projection::kPerspective;
  camera.half_height = 0.5;
  const RgbImage image = Traced(SphereScene(SkinMaterial()), camera, {}, TrueLight(24, 4));
  for (std::size_t k = 0; k < image.rgb.size(); ++k) {
    EXPECT_LE(image.depth[k], 40.01F);
    EXPECT_EQ(image.alpha[k], 1.0F);
    EXPECT_LT(image.rgb[k].maxCoeff(), 1e-3F);  // a closed head is dark inside: nothing leaks between the faces
  }
}

TEST(Trace, RefusesWhatCannotBeDrawnAsTheZBufferDoes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Camera camera = FrontCamera(100.0, 10);
  for (const double bad : {nan, std::numeric_limits<double>::infinity(), 1e300, 2e6}) {
    Scene scene = SphereScene(SkinMaterial());
    scene.items[0].mesh.vertices[7].z() = bad;
    const Result<Tracer> tracer = Tracer::Make(scene);
    ASSERT_FALSE(tracer.has_value());
    EXPECT_EQ(tracer.error().Text(), Render(scene, camera, PlainOptions(8, 8), {}).error().Text());
  }
  Scene scene = SphereScene(SkinMaterial());
  scene.items[0].mesh.faces[3][1] = 1'000'000;
  EXPECT_FALSE(Tracer::Make(scene).has_value());
  scene = {};
  scene.lenses.push_back(RoundLens({0, 0, 0}, LensCoating::kNone));
  scene.lenses[0].form.back.lens_from_surface.translation().z() = 4.0;  // before its front
  EXPECT_FALSE(Tracer::Make(scene).has_value());

  const Result<Tracer> tracer = Tracer::Make(SphereScene(SkinMaterial()));
  ASSERT_TRUE(tracer.has_value());
  const auto fails = [&](auto&& change) {
    TraceOptions options = TrueLight(8, 1);
    Lighting lighting;
    Camera aimed = camera;
    change(options, lighting, aimed);
    return !tracer->Trace(aimed, lighting, options, {}).has_value();
  };
  EXPECT_FALSE(fails([](TraceOptions&, Lighting&, Camera&) {}));
  EXPECT_TRUE(fails([](TraceOptions& options, Lighting&, Camera&) { options.width = 0; }));
  EXPECT_TRUE(fails([](TraceOptions& options, Lighting&, Camera&) { options.height = 8193; }));
  EXPECT_TRUE(fails([](TraceOptions& options, Lighting&, Camera&) { options.samples = 0; }));
  EXPECT_TRUE(fails([](TraceOptions& options, Lighting&, Camera&) { options.samples = 65537; }));
  EXPECT_TRUE(fails([](TraceOptions& options, Lighting&, Camera&) { options.max_bounces = -1; }));
  EXPECT_TRUE(fails([](TraceOptions& options, Lighting&, Camera&) { options.max_bounces = 65; }));
  EXPECT_TRUE(fails([&](TraceOptions& options, Lighting&, Camera&) { options.backdrop.edge[0] = -1.0F; }));
  EXPECT_TRUE(fails([&](TraceOptions&, Lighting& lighting, Camera&) {
    lighting.lights.push_back({Eigen::Vector3d::Zero(), LinearRgb::Ones()});
  }));
  EXPECT_TRUE(fails([&](TraceOptions&, Lighting&, Camera& aimed) { aimed.near_mm = 0.0; }));
}

TEST(Trace, LensesLargerThanTheirRimAndHalfInTheHeadDraw) {
  Scene scene;
  scene.items.push_back(Item(SphereMesh({0, 0, 0}, 40.0, 48), SkinMaterial()));
  // Rims of 18 mm; the lenses stand out of them by far and reach into the head.
  for (const double x : {-20.0, 20.0}) {
    scene.items.push_back(Item(SphereMesh({x, 44, 0}, 3.0, 16), MetalMaterial(LinearRgb::Ones())));
    for (const double away : {44.0, 30.0}) {
      SolidLens lens = RoundLens({x, away, 0.0}, LensCoating::kMirror);
      for (Eigen::Vector2d& p : lens.outline.points) p *= 1.6;
      scene.lenses.push_back(lens);
    }
  }
  for (const char* view : {"front", "0,10", "270,0"}) {
    const Camera camera = FrameCamera(BoundsOf(scene), ParseView(view).value(), {}).value();
    const RgbImage image = Traced(scene, camera, {}, TrueLight(40, 8));
    for (const LinearRgb& rgb : image.rgb) ASSERT_TRUE(rgb.allFinite() && rgb.minCoeff() >= 0.0F) << view;
  }
}

TEST(Trace, EmptyMeshesAndFacesWithoutAreaDraw) {
  Scene scene;
  scene.items.push_back(Item({}, SkinMaterial()));
  scene.items.push_back(Item({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}, {0, 0, 0}}}, SkinMaterial()));
  scene.items.push_back(Item({}, ExactLens(LinearRgb::Ones())));
  const RgbImage image = Traced(scene, FrontCamera(100.0, 16), {}, TrueLight(16, 2));
  for (const LinearRgb& rgb : image.rgb) EXPECT_TRUE(rgb.allFinite());
}

TEST(Trace, NothingIsMissedWhereTheMaskOfThePictureSaysNothingIs) {
  // Against the same scene with a lens far outside the picture's middle, which makes no difference, and against the
  // environment behind, for which every pixel is traced: what is covered must be the same.
  Scene scene;
  std::mt19937_64 engine(3);
  const auto uniform = [&engine] { return static_cast<double>(engine() >> 11) * 0x1.0p-53 * 2.0 - 1.0; };
  TriangleMesh mesh;
  for (std::uint32_t k = 0; k < 60; ++k) {
    const Eigen::Vector3d middle = 60.0 * Eigen::Vector3d(uniform(), uniform(), uniform());
    for (int c = 0; c < 3; ++c)
      mesh.vertices.push_back(middle + 12.0 * Eigen::Vector3d(uniform(), uniform(), uniform()));
    mesh.faces.push_back({3 * k, 3 * k + 1, 3 * k + 2});
  }
  scene.items.push_back(Item(mesh, White(Finish::kMatte, 1.0F)));
  for (const double distance : {200.0, 60.0, 10.0, 1e6}) {
    Camera camera = FrontCamera(distance, 100);
    camera.projection = Projection::kPerspective;
    camera.half_height = distance < 1e5 ? 0.5 : 1e-4;
    TraceOptions options = TrueLight(40, 4);
    options.max_bounces = 0;
    const RgbImage all = Traced(scene, camera, Furnace(), options);
    options.background = TraceOptions::Background::kBackdrop;
    const RgbImage masked = Traced(scene, camera, Furnace(), options);
    EXPECT_EQ(all.alpha, masked.alpha);
    EXPECT_EQ(all.depth, masked.depth);
  }
}

TEST(Trace, TenMillionTrianglesRender) {
  if (std::getenv("ANNULUS_LONG") == nullptr) GTEST_SKIP() << "takes half a minute and 4 GiB: set ANNULUS_LONG";
  Scene scene;
  scene.items.push_back(Item(SphereMesh({0.0, 0.0, 0.0}, 40.0, 3164), SkinMaterial()));
  ASSERT_GT(scene.items[0].mesh.faces.size(), 10'000'000U);
  TraceOptions options = TrueLight(64, 4);
  const RgbImage image = Traced(scene, FrontCamera(300.0, 100), {}, options);
  EXPECT_NEAR(image.depth[image.Index(32, 32)], 260.0F, 0.1F);
  for (const LinearRgb& rgb : image.rgb) EXPECT_TRUE(rgb.allFinite() && rgb.minCoeff() >= 0.0F);
}

}  // namespace
}  // namespace annulus
