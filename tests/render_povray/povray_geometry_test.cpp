#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "base/units.h"
#include "picture.h"
#include "tests/render/shapes.h"
#include "tests/support/face_scene.h"

namespace annulus {
namespace {

using test::EyeRay;
using test::Povray;
using test::PovraySampling;
using test::PovrayView;
using test::Shot;

Camera CameraFrom(const Scene& scene, const char* view, Projection projection) {
  Framing framing;
  framing.projection = projection;
  framing.vertical_field_of_view = 0.5;
  return *FrameCamera(BoundsOf(scene), *ParseView(view), framing);
}

PovraySampling Pixels(int width, int height) {
  PovraySampling sampling;
  sampling.width = width;
  sampling.height = height;
  return sampling;
}

/// The nearer meeting point of a ray and a sphere.
std::optional<Eigen::Vector3d> MeetSphere(const EyeRay& ray, const Eigen::Vector3d& centre, double radius) {
  const Eigen::Vector3d from_centre = ray.origin - centre;
  const double a = ray.direction.squaredNorm();
  const double half_b = ray.direction.dot(from_centre);
  const double discriminant = half_b * half_b - a * (from_centre.squaredNorm() - radius * radius);
  if (discriminant <= 0.0) return std::nullopt;
  return ray.origin + (-half_b - std::sqrt(discriminant)) / a * ray.direction;
}

TEST(PovrayScene, ShowsALambertSphereAsItsClosedForm) {
  if (!test::HasPovray()) GTEST_SKIP() << "no povray here";
  const Eigen::Vector3d centre(12.0, -7.0, 31.0);
  const LinearRgb albedo(0.8F, 0.45F, 0.2F);
  Shot shot;
  shot.scene.items.push_back(Item(SphereMesh(centre, 40.0, 300), test::Matte(albedo)));
  for (Eigen::Vector3d& vertex : shot.scene.items[0].mesh.vertices) {
    shot.scene.items[0].normals.push_back((vertex - centre).normalized());
  }
  const Eigen::Vector3d towards = Eigen::Vector3d(0.6, 0.7, 0.3).normalized();
  shot.lighting.lights.push_back({towards, LinearRgb(1.1F, 0.9F, 1.0F)});
  const PovraySampling sampling = Pixels(150, 100);
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    shot.camera = CameraFrom(shot.scene, "70,25", projection);
    shot.camera.eye_in_station += Eigen::Vector3d(9.0, 0.0, 4.0);  // off the middle
    const RgbImage image = Povray(shot, {}, sampling, "lit");
    double worst = 0.0;
    for (int y = 0; y < sampling.height; ++y) {
      for (int x = 0; x < sampling.width; ++x) {
        const EyeRay ray = test::RayThrough(shot.camera, x, y, sampling);
        const std::optional<Eigen::Vector3d> hit = MeetSphere(ray, centre, 40.0);
        LinearRgb expected = LinearRgb::Zero();
        if (hit) {
          const Eigen::Vector3d normal = (*hit - centre).normalized();
          if (-normal.dot(ray.direction.normalized()) < 0.15) continue;  // facets show at the edge
          const double cosine = std::max(0.0, normal.dot(towards));
          if (cosine > 0.0 && cosine < 0.05) continue;  // facets shade each other at the terminator
          expected = static_cast<float>(cosine) * albedo.cwiseProduct(shot.lighting.lights[0].radiance);
        }
        const LinearRgb seen = image.rgb[image.Index(x, y)];
        worst = std::max(worst, static_cast<double>((seen - expected).cwiseAbs().maxCoeff()));
      }
    }
    EXPECT_LT(worst, 1e-3);
  }
}

/// Snell's law at a surface; the direction need not be a unit vector.
std::optional<EyeRay> RefractAt(const LensSurface& surface, const EyeRay& ray, double index_ratio) {
  const std::optional<SurfaceHit> hit = Meet(surface, ray.origin, ray.direction);
  if (!hit) return std::nullopt;
  const Eigen::Vector3d along = ray.direction.normalized();
  const double cosine = -along.dot(hit->normal);
  const double inside = 1.0 - (1.0 - cosine * cosine) * index_ratio * index_ratio;
  if (inside <= 0.0) return std::nullopt;
  return EyeRay{hit->point, index_ratio * along + (index_ratio * cosine - std::sqrt(inside)) * hit->normal};
}

TEST(PovrayScene, LensesRefractBySnellsLawAtBothSurfaces) {
  // Behind each lens a slanted wall: the depth at which a pixel sees it says where its ray went.
  if (!test::HasPovray()) GTEST_SKIP() << "no povray here";
  const SpheroCylinder orders[] = {{-6.0, 0.0, kPi}, {5.0, 0.0, kPi}, {-1.0, -3.0, 0.5}, {2.0, -1.0, 2.0}};
  const PovraySampling sampling = Pixels(90, 70);
  for (const SpheroCylinder& order : orders) {
    Result<SolidLens> lens = test::EllipticLens(order, 1.6, {2.0, -3.0});
    ASSERT_TRUE(lens) << lens.error().Text();
    test::Place(*lens, {5.0, 10.0, 100.0}, 20.0);
    Shot shot;
    const Eigen::Vector3d corner(-300.0, -160.0, -200.0);
    const Eigen::Vector3d u(600.0, 140.0, 0.0);
    const Eigen::Vector3d v(0.0, -110.0, 600.0);
    const Eigen::Vector3d wall_normal = u.cross(v);
    shot.scene.items.push_back(Item(QuadMesh(corner, u, v), test::Matte(LinearRgb::Ones())));
    shot.scene.lenses.push_back(*lens);
    shot.camera =
        *FrameCamera(Eigen::AlignedBox3d(Eigen::Vector3d(-25.0, 20.0, 80.0), Eigen::Vector3d(35.0, 40.0, 120.0)),
                     *ParseView("80,7"), {});
    const Eigen::Matrix3d& camera_from_station = shot.camera.camera_from_station;
    const std::vector<double> depth = test::PovrayDepth(shot, 100.0, 800.0, sampling);
    const Eigen::Isometry3d lens_from_station = lens->station_from_lens.inverse();
    int compared = 0;
    int apart = 0;
    for (int y = 0; y < sampling.height; ++y) {
      for (int x = 0; x < sampling.width; ++x) {
        const EyeRay ray = test::RayThrough(shot.camera, x, y, sampling);
        const EyeRay in_lens{lens_from_station * ray.origin, lens_from_station.linear() * ray.direction};
        const std::optional<EyeRay> inside = RefractAt(lens->form.front, in_lens, 1.0 / lens->form.index);
        if (!inside || std::hypot(inside->origin.x() / 25.0, inside->origin.y() / 19.0) > 1.0) continue;
        const std::optional<EyeRay> behind = RefractAt(lens->form.back, *inside, lens->form.index);
        if (!behind || std::hypot(behind->origin.x() / 25.0, behind->origin.y() / 19.0) > 1.0) continue;
        const Eigen::Vector3d origin = lens->station_from_lens * behind->origin;
        const Eigen::Vector3d direction = lens->station_from_lens.linear() * behind->direction;
        const double t = wall_normal.dot(corner - origin) / wall_normal.dot(direction);
        const Eigen::Vector3d hit = origin + t * direction;
        const double expected = camera_from_station.row(2).dot(hit - shot.camera.eye_in_station);
        const double seen = depth[static_cast<std::size_t>(y * sampling.width + x)];
        apart += std::abs(seen - expected) < 0.02 ? 0 : 1;  // 16 bits over 700 mm: 0.011 mm
        ++compared;
      }
    }
    EXPECT_GT(compared, 1200);
    // povray misses a root of a torus' quartic here and there; a sphere's never.
    EXPECT_LE(apart, order.cylinder == 0.0 ? 0 : compared / 200) << order.sphere << " " << order.cylinder;
  }
}

TEST(PovrayScene, GlassReflectsAndAbsorbsAsFresnelAndBeerSay) {
  // A plane-parallel plate of t mm before a bright sky: the sum over all passages there and back, square on:
  // T + R·background, with r = ((n − 1)/(n + 1))², a = transmittance of the plate: (1 − r)²·a / (1 − r²a²) passes.
  // povray does not absorb what a face throws back into the glass: two passages less in each round trip's share.
  if (!test::HasPovray()) GTEST_SKIP() << "no povray here";
  const double index = 1.5;
  SolidLens plate = *test::EllipticLens({0.0, 0.0, kPi}, index, {0.0, 0.0});
  plate.form.front = {};
  plate.form.back = {};
  plate.form.back.lens_from_surface.translation().z() = -4.0;
  plate.finish.transmittance = LinearRgb(0.9F, 0.7F, 0.5F);
  test::Place(plate, {0.0, 0.0, 0.0}, 10.0);
  Shot shot;
  shot.scene.lenses.push_back(plate);
  shot.camera = FrontCamera(200.0, 80);
  shot.camera.half_height = 30.0;
  shot.camera.camera_from_station.row(0) = plate.station_from_lens.linear().col(0).transpose();
  shot.camera.camera_from_station.row(1) = plate.station_from_lens.linear().col(1).transpose();
  shot.camera.camera_from_station.row(2) = -plate.station_from_lens.linear().col(2).transpose();
  shot.camera.eye_in_station = plate.station_from_lens * Eigen::Vector3d(0.0, 0.0, 200.0);
  shot.lighting.environment = Environment::Uniform(LinearRgb(0.5F, 0.5F, 0.5F));
  const RgbImage image = Povray(shot, {}, Pixels(80, 80), "plate");
  const double r = std::pow((index - 1.0) / (index + 1.0), 2);
  for (int channel = 0; channel < 3; ++channel) {
    const double a = std::pow(static_cast<double>(plate.finish.transmittance[channel]), 4.0 / 2.0);
    const double once = (1.0 - r) * (1.0 - r);
    const double to_front = r * once * a;     // back, front: a on the last way only
    const double to_back = r * r * once * a;  // back, front, back
    EXPECT_NEAR(image.rgb[image.Index(40, 40)][channel], 0.5 * (r + once * a + to_front + to_back), 2e-4);
  }
}

TEST(ZBuffer, CoversWhatPovrayCoversAtPovraysDepth) {
  if (!test::HasPovray()) GTEST_SKIP() << "no povray here";
  Shot shot;
  shot.scene = *test::FaceScene(160, 120, {});
  const PovraySampling sampling = Pixels(200, 200);
  const RenderOptions options = PlainOptions(sampling.width, sampling.height);
  for (const char* view : {"front", "left45", "20,-30"}) {
    shot.camera = CameraFrom(shot.scene, view, Projection::kPerspective);
    const RgbImage seen = *Render(shot.scene, shot.camera, options, {});
    const double middle = shot.camera.ToCamera(BoundsOf(shot.scene).center()).z();
    const std::vector<double> depth = test::PovrayDepth(shot, middle - 200.0, middle + 200.0, sampling);
    int either = 0;
    int both = 0;
    double sum = 0.0;
    for (std::size_t i = 0; i < depth.size(); ++i) {
      const bool ours = seen.depth[i] < kNoDepth;
      const bool theirs = depth[i] < middle + 199.9;
      either += ours || theirs ? 1 : 0;
      if (!ours || !theirs) continue;
      ++both;
      sum += std::abs(static_cast<double>(seen.depth[i]) - depth[i]);
    }
    EXPECT_GT(both, 10000);
    EXPECT_GE(both, 0.999 * either) << view;
    EXPECT_LT(sum / both, 0.01) << view;
  }
}

TEST(ZBuffer, NormalsAreThoseThatPovrayShades) {
  // One light behind a parallel camera throws no shadow that it sees: the picture is the normals' part towards the eye.
  if (!test::HasPovray()) GTEST_SKIP() << "no povray here";
  Shot shot;
  shot.scene = *test::FaceScene(160, 120, {});
  shot.scene.items[0].material.colour = LinearRgb::Ones();
  shot.camera = CameraFrom(shot.scene, "60,10", Projection::kOrthographic);
  shot.lighting.lights.push_back({-shot.camera.camera_from_station.row(2).transpose(), LinearRgb::Ones()});
  const PovraySampling sampling = Pixels(200, 200);
  const RgbImage image = Povray(shot, {}, sampling, "lit");
  const Layer layer = *RenderLayer(shot.scene, shot.camera, PlainOptions(sampling.width, sampling.height), {});
  int compared = 0;
  double sum = 0.0;
  for (int y = layer.window.row; y < layer.window.row + layer.window.height; ++y) {
    for (int x = layer.window.column; x < layer.window.column + layer.window.width; ++x) {
      const auto i = static_cast<std::size_t>((y - layer.window.row) * layer.window.width + x - layer.window.column);
      const float theirs = image.rgb[image.Index(x, y)].x();
      if (!(layer.depth[i] < kNoDepth) || theirs == 0.0F) continue;
      sum += std::abs(static_cast<double>(layer.normal[i].z() - theirs));
      ++compared;
    }
  }
  EXPECT_GT(compared, 10000);
  EXPECT_LT(sum / compared, 3e-4);
}

}  // namespace
}  // namespace annulus
