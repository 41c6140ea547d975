#pragma once

#include <string>

#include "base/result.h"
#include "render/camera.h"
#include "render/scene.h"
#include "render/trace.h"

namespace annulus::test {

/// What povray shows of a scene.
enum class PovrayView {
  kLit,    ///< The picture: matte things under the far lights, lenses with refraction and Fresnel's reflection.
  kDepth,  ///< Depth of what is seen, through lenses too: grey from 0 at `near_mm` to 1 at `far_mm` along the axis.
  kParts,  ///< Every thing glows in the grey of PartGrey; lenses are opaque too.
};

/// Glass that reflects or only refracts (for pictures without ghosts).
enum class PovrayGlass { kFresnel, kClear };

struct PovraySceneOptions {
  PovrayView view = PovrayView::kLit;
  PovrayGlass glass = PovrayGlass::kFresnel;
  double aspect = 1.0;     ///< Width : height of the picture.
  double near_mm = 0.0;    ///< kDepth.
  double far_mm = 1000.0;  ///< kDepth.
  /// Of how many parallel lights the environment is made, drawn with its own Sample at a regular lattice; 0: the
  /// environment is seen but does not light.
  int sky_lights = 0;
  /// What is seen where nothing is: the environment, which must then be even, or black.
  enum class Background { kEnvironment, kBlack } background = Background::kEnvironment;
  /// Text put into global_settings, for example a radiosity block.
  std::string settings;
};

/// The grey of item `index` in kParts, 0 … 1; lenses follow the items. Background is 0.
[[nodiscard]] double PartGrey(std::size_t index, std::size_t count);

/// `scene` in povray 3.7's language: one unit is 1 mm, station frame, linear colours (assumed_gamma 1), direct light
/// only (as TraceOptions::max_bounces = 0). Items: kMatte of one colour as smooth triangles. Far lights: parallel, with
/// shadows. Lenses: intersections of spheres, tori or planes with a prism over the outline, index and Beer's law in
/// the interior, reflection by povray's own Fresnel formula with the energy conserved; no coating, no gradient.
/// povray's own shadows of glass are dimmed by Beer's law but not by reflection: an unseen copy of the lens throws the
/// shadow, each face of which passes Fresnel's share of light for the angle between the lens' axis and the lights.
/// Fails on what cannot be said in povray: another finish, vertex colours, textures, a coating, a gradient, a torus
/// with the stronger curvature along v.
[[nodiscard]] Result<std::string> PovrayScene(const Scene& scene, const Camera& camera, const Lighting& lighting,
                                              const PovraySceneOptions& options);

}  // namespace annulus::test
