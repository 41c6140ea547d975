#include "tests/support/povray_scene.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <numeric>

#include "base/units.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus::test {
namespace {

constexpr const char* kAttempted = "write a scene for povray";
/// Where parallel lights stand, mm from the origin: behind everything.
constexpr double kLightDistance = 1e5;

tl::unexpected<Error> Refuse(const std::string& seen) {
  return Fail(kAttempted, seen, "use only what both programs define alike");
}

std::string VectorText(const Eigen::Vector3d& v) {
  return fmt::format("<{:.15g},{:.15g},{:.15g}>", v.x(), v.y(), v.z());
}
std::string ColourText(const LinearRgb& c) { return VectorText(c.cast<double>()); }

/// povray's matrix takes rows: the images of the axes, then the shift.
std::string MatrixText(const Eigen::Isometry3d& outer_from_inner) {
  std::string text = "matrix <";
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      text += fmt::format("{}{:.12g}", column + row > 0 ? "," : "", outer_from_inner.matrix()(row, column));
    }
  }
  return text + ">";
}

/// The rotation whose columns are where povray's own x, y, z go.
Eigen::Isometry3d Axes(const Eigen::Vector3d& x, const Eigen::Vector3d& y, const Eigen::Vector3d& z) {
  Eigen::Isometry3d axes = Eigen::Isometry3d::Identity();
  axes.linear().col(0) = x;
  axes.linear().col(1) = y;
  axes.linear().col(2) = z;
  return axes;
}

std::string CameraText(const Camera& camera, double aspect) {
  const Eigen::Vector3d right = camera.camera_from_station.row(0).transpose();
  const Eigen::Vector3d up = camera.camera_from_station.row(1).transpose();
  const Eigen::Vector3d forward = camera.camera_from_station.row(2).transpose();
  // povray's rays pass direction + (x - 1/2) right + (1/2 - y) up with x, y = 0 … 1 across the picture.
  return fmt::format("camera {{ {} location {} direction {} right {} up {} }}\n",
                     camera.projection == Projection::kPerspective ? "perspective" : "orthographic",
                     VectorText(camera.eye_in_station), VectorText(forward),
                     VectorText(2.0 * camera.half_height * aspect * right), VectorText(2.0 * camera.half_height * up));
}

// --- light
// ------------------------------------------------------------------------------------------------------------

std::string ParallelLight(const Eigen::Vector3d& towards, const LinearRgb& radiance) {
  return fmt::format("light_source {{ {} rgb {} parallel point_at <0,0,0> }}\n", VectorText(kLightDistance * towards),
                     ColourText(radiance));
}

/// The light frame of environment.h turns with the camera's azimuth.
Eigen::Matrix3d StationFromLight(const Camera& camera) {
  Eigen::Vector3d right = camera.camera_from_station.row(0).transpose();
  right.z() = 0.0;
  right.normalize();
  Eigen::Matrix3d station_from_light;
  station_from_light.col(0) = right;
  station_from_light.col(1) = Eigen::Vector3d::UnitZ();
  station_from_light.col(2) = right.cross(Eigen::Vector3d::UnitZ());
  return station_from_light;
}

/// Environment as far lights: a rank-1 lattice (golden ratio) in the environment's own draws.
std::string SkyLights(const Environment& environment, const Camera& camera, const PovraySceneOptions& options) {
  constexpr double kGoldenShare = 0.6180339887498949;
  const Eigen::Matrix3d station_from_light = StationFromLight(camera);
  std::string text;
  const auto fraction = [](double value) { return static_cast<float>(std::min(value - std::floor(value), 0.9999999)); };
  for (int k = 0; k < options.sky_lights; ++k) {
    const float u = fraction((k + 0.5) / options.sky_lights);
    const float v = fraction(kGoldenShare * (k + 0.5));
    const Environment::Draw draw = environment.Sample(u, v);
    // A far light's radiance is what white matte reflects of it: L / (π · density) per draw.
    const LinearRgb radiance = draw.radiance / (draw.density * static_cast<float>(kPi * options.sky_lights));
    text += ParallelLight(station_from_light * draw.direction.cast<double>(), radiance);
  }
  return text;
}

/// What is seen where nothing is. Only an even environment can be written.
Result<std::string> Background(const Environment& environment) {
  const LinearRgb seen = environment.Radiance(Eigen::Vector3f::UnitZ());
  for (int k = 0; k < 64; ++k) {
    const float height = -1.0F + (static_cast<float>(k) + 0.5F) / 32.0F;
    const float across = std::sqrt(1.0F - height * height);
    const auto turn = 2.4F * static_cast<float>(k);
    const Eigen::Vector3f direction(across * std::cos(turn), height, across * std::sin(turn));
    if ((environment.Radiance(direction) - seen).cwiseAbs().maxCoeff() > 1e-6F) {
      return Refuse("the environment is not even, so its background cannot be shown");
    }
  }
  return fmt::format("background {{ rgb {} }}\n", ColourText(seen));
}

// --- lenses
// -----------------------------------------------------------------------------------------------------------

/// The side of one surface on which the glass is, in the lens frame; `behind`: the eye's side of the surface.
Result<std::string> SideOf(const LensSurface& surface, bool behind) {
  const double u = surface.curvature_u;
  const double v = surface.curvature_v;
  const Eigen::Isometry3d shift(Eigen::Translation3d(0.0, 0.0, v == 0.0 ? 0.0 : -1.0 / v));
  // Behind a surface that is hollow towards the front is outside its sphere.
  const char* side = (u < 0.0) == behind ? " inverse" : "";
  if (u == 0.0 && v == 0.0) {
    return fmt::format("plane {{ <0,0,1>, 0{} {} }}", behind ? "" : " inverse", MatrixText(surface.lens_from_surface));
  }
  if (u == v) {
    return fmt::format("sphere {{ <0,0,0>, {:.12g}{} {} }}", std::abs(1.0 / u), side,
                       MatrixText(surface.lens_from_surface * shift));
  }
  if (v == 0.0) {
    const Eigen::Isometry3d centre(Eigen::Translation3d(0.0, 0.0, -1.0 / u));
    return fmt::format("cylinder {{ <0,-1000,0>, <0,1000,0>, {:.12g}{} {} }}", std::abs(1.0 / u), side,
                       MatrixText(surface.lens_from_surface * centre));
  }
  if (std::abs(u) < std::abs(v)) return Refuse("a torus has its stronger curvature along v");
  // povray's ring turns about its y; ours about u.
  const Eigen::Isometry3d turn = Axes({0.0, 1.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, 1.0});
  return fmt::format("torus {{ {:.12g}, {:.12g} sturm{} {} }}", std::abs(1.0 / v - 1.0 / u), std::abs(1.0 / u), side,
                     MatrixText(surface.lens_from_surface * shift * turn));
}

/// The cylinder over the outline, in the lens frame, hardly longer than the lens: povray's torus shows its inner leaf
/// too, some 30 mm behind the vertex.
std::string PrismText(const SolidLens& lens) {
  const LensOutline& outline = lens.outline;
  Eigen::AlignedBox1d reach(lens.form.back.Sag(0.0, 0.0), lens.form.front.Sag(0.0, 0.0));
  for (const Eigen::Vector2d& point : outline.points) {
    for (const LensSurface* surface : {&lens.form.front, &lens.form.back}) {
      reach.extend(Eigen::Vector<double, 1>(surface->Sag(point.x(), point.y())));
    }
  }
  std::string text = fmt::format("prism {{ linear_sweep linear_spline {:.9g}, {:.9g}, {}", reach.min()[0] - 1.0,
                                 reach.max()[0] + 1.0, outline.points.size() + 1);
  for (std::size_t i = 0; i <= outline.points.size(); ++i) {
    const Eigen::Vector2d& point = outline.points[i % outline.points.size()];
    text += fmt::format("{}<{:.9g},{:.9g}>", i % 8 == 0 ? ",\n" : ", ", point.x(), point.y());
  }
  // povray sweeps the x-z plane along y.
  return text + " " + MatrixText(Axes({1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, {0.0, 1.0, 0.0})) + " }";
}

/// The share of light that one face passes on its straight way to a rough surface: the mean over the lights.
double PassedByFace(const SolidLens& lens, const Lighting& lighting) {
  const Eigen::Vector3d axis = lens.station_from_lens.linear().col(2);
  double passed = 0.0;
  double weight = 0.0;
  for (const FarLight& light : lighting.lights) {
    const double cosine = std::abs(axis.dot(light.towards));
    const double inside = std::sqrt(1.0 - (1.0 - cosine * cosine) / (lens.form.index * lens.form.index));
    const double s = (cosine - lens.form.index * inside) / (cosine + lens.form.index * inside);
    const double p = (lens.form.index * cosine - inside) / (lens.form.index * cosine + inside);
    const double light_weight = light.radiance.sum();
    passed += light_weight * (1.0 - 0.5 * (s * s + p * p));
    weight += light_weight;
  }
  return weight > 0.0 ? passed / weight : 1.0;
}

/// povray dims by exp(-(1 - fade_color) · depth / fade_distance).
std::string InteriorText(const SolidLens& lens) {
  const LinearRgb absorbance = -lens.finish.transmittance.array().log().matrix();
  return fmt::format("interior {{ ior {:.12g} fade_power 1001 fade_distance 2 fade_color rgb {} }}", lens.form.index,
                     ColourText(LinearRgb::Ones() - absorbance));
}

Result<std::string> LensText(const SolidLens& lens, const Lighting& lighting, const PovraySceneOptions& options,
                             double grey) {
  const LensFinish& finish = lens.finish;
  if (finish.coating != LensCoating::kNone) return Refuse("a lens is coated");
  if (finish.gradient_from != finish.gradient_to) return Refuse("a lens has a gradient");
  const Result<std::string> front = SideOf(lens.form.front, true);
  if (!front) return front;
  const Result<std::string> back = SideOf(lens.form.back, false);
  if (!back) return back;
  const std::string solid = fmt::format("intersection {{\n{}\n{}\n{}\n{}\n", *front, *back, PrismText(lens),
                                        MatrixText(lens.station_from_lens));
  if (options.view == PovrayView::kParts) {
    return solid + fmt::format("pigment {{ rgb {:.9g} }} finish {{ emission 1 diffuse 0 }} }}\n", grey);
  }
  std::string text = solid + "pigment { rgbt 1 } ";
  text += options.view == PovrayView::kLit && options.glass == PovrayGlass::kFresnel
              ? "finish { diffuse 0 reflection { 0, 1 fresnel on } conserve_energy }\n"
              : "finish { diffuse 0 }\n";
  text +=
      (options.view == PovrayView::kLit ? InteriorText(lens) : fmt::format("interior {{ ior {} }}", lens.form.index));
  text += " no_shadow }\n";
  if (options.view != PovrayView::kLit) return text;
  return text + solid +
         fmt::format("pigment {{ rgb 0 transmit {:.9g} }} finish {{ diffuse 0 }}\n", PassedByFace(lens, lighting)) +
         InteriorText(lens) + " no_image no_reflection no_radiosity }\n";
}

// --- items
// ------------------------------------------------------------------------------------------------------------

template <class Values>
void AppendVectors(std::string& text, const char* name, const Values& values) {
  text += fmt::format("{} {{ {}", name, values.size());
  std::size_t count = 0;
  for (const Eigen::Vector3d& v : values) {
    fmt::format_to(std::back_inserter(text), "{}<{:.7g},{:.7g},{:.7g}>", count++ % 4 == 0 ? ",\n" : ",", v.x(), v.y(),
                   v.z());
  }
  text += " }\n";
}

std::string MeshText(const SceneItem& item) {
  std::string text = "mesh2 {\n";
  AppendVectors(text, "vertex_vectors", item.mesh.vertices);
  AppendVectors(text, "normal_vectors", item.normals.empty() ? VertexNormals(item.mesh) : item.normals);
  text += fmt::format("face_indices {{ {}", item.mesh.faces.size());
  std::size_t count = 0;
  for (const auto& face : item.mesh.faces) {
    fmt::format_to(std::back_inserter(text), "{}<{},{},{}>", count++ % 8 == 0 ? ",\n" : ",", face[0], face[1], face[2]);
  }
  return text + " }\n";
}

std::string DepthPigment(const Camera& camera, const PovraySceneOptions& options) {
  // gradient x is the fraction of x within 0 … 1: laid from the near to the far plane it is the depth.
  const double range = options.far_mm - options.near_mm;
  Eigen::Matrix4d station_from_pattern = Eigen::Matrix4d::Identity();
  const Eigen::Vector3d forward = camera.camera_from_station.row(2).transpose();
  station_from_pattern.topLeftCorner<3, 1>() = range * forward;
  station_from_pattern.block<3, 1>(0, 1) = camera.camera_from_station.row(0).transpose();
  station_from_pattern.block<3, 1>(0, 2) = camera.camera_from_station.row(1).transpose();
  station_from_pattern.topRightCorner<3, 1>() = camera.eye_in_station + options.near_mm * forward;
  Eigen::Isometry3d placed;
  placed.matrix() = station_from_pattern;
  return fmt::format(
      "pigment {{ gradient x color_map {{ [0 rgb 0] [1 rgb 1] }} {} }} finish {{ emission 1 diffuse 0 }}",
      MatrixText(placed));
}

Result<std::string> ItemText(const SceneItem& item, const Camera& camera, const PovraySceneOptions& options,
                             double grey) {
  if (item.material.finish != Finish::kMatte) return Refuse("'" + item.group + "' is not matte");
  if (item.material.texture.pattern != TexturePattern::kPlain || item.lower || !item.colours.empty()) {
    return Refuse("'" + item.group + "' has more than one colour");
  }
  std::string look;
  switch (options.view) {
    case PovrayView::kLit:
      look = fmt::format("pigment {{ rgb {} }} finish {{ diffuse 1 }}", ColourText(item.material.colour));
      break;
    case PovrayView::kDepth:
      look = DepthPigment(camera, options);
      break;
    case PovrayView::kParts:
      look = fmt::format("pigment {{ rgb {:.9g} }} finish {{ emission 1 diffuse 0 }}", grey);
      break;
  }
  return MeshText(item) + look + " }\n";
}

}  // namespace

double PartGrey(std::size_t index, std::size_t count) {
  return static_cast<double>(index + 1) / static_cast<double>(count);
}

Result<std::string> PovrayScene(const Scene& scene, const Camera& camera, const Lighting& lighting,
                                const PovraySceneOptions& options) {
  std::string text = "#version 3.7;\n";
  text += "global_settings { assumed_gamma 1.0 max_trace_level 24 adc_bailout 0.0004 ambient_light 0 " +
          options.settings + " }\n";
  text += "#default { finish { ambient 0 diffuse 0 emission 0 } }\n";
  text += CameraText(camera, options.aspect);
  if (options.view == PovrayView::kLit) {
    for (const FarLight& light : lighting.lights) text += ParallelLight(light.towards, light.radiance);
    text += SkyLights(lighting.environment, camera, options);
    if (options.background == PovraySceneOptions::Background::kEnvironment) {
      const Result<std::string> background = Background(lighting.environment);
      if (!background) return background;
      text += *background;
    }
  } else {
    text += options.view == PovrayView::kDepth ? "background { rgb 1 }\n" : "background { rgb 0 }\n";
  }
  const std::size_t count = scene.items.size() + scene.lenses.size();
  for (std::size_t i = 0; i < scene.items.size(); ++i) {
    const Result<std::string> item = ItemText(scene.items[i], camera, options, PartGrey(i, count));
    if (!item) return item;
    text += *item;
  }
  for (std::size_t i = 0; i < scene.lenses.size(); ++i) {
    const Result<std::string> lens =
        LensText(scene.lenses[i], lighting, options, PartGrey(scene.items.size() + i, count));
    if (!lens) return lens;
    text += *lens;
  }
  return text;
}

}  // namespace annulus::test
