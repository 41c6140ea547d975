#pragma once

#include "render/colour.h"
#include "render/texture.h"

namespace annulus {

/// How a surface answers light. The z-buffer (Shade) and the path tracer (bsdf.h) read the same materials.
enum class Finish {
  kMatte,        ///< Lambert's diffuse reflection only.
  kPlastic,      ///< Opaque acetate or moulded plastic: diffuse body colour under a clear surface (index 1.5).
  kTranslucent,  ///< Milky acetate: as kPlastic, but part of the body's light comes through from behind.
  kMetal,        ///< Polished metal: coloured mirror, no diffuse part.
  kBrushed,      ///< Metal with fine grooves along the part: its highlight is drawn out across them.
  kSkin,         ///< Soft diffuse with light bleeding round the terminator; also for a neutral body.
  kLens,         ///< Sheet of a lens: transmits `transmittance`, mirrors a little.
};

/// What a surface is made of.
struct Material {
  Finish finish = Finish::kPlastic;
  LinearRgb colour = LinearRgb(0.5F, 0.5F, 0.5F);         ///< Diffuse albedo, or the metal's reflectance, 0 … 1.
  float roughness = 0.3F;                                 ///< GGX width, 0 (mirror) … 1 (chalk).
  LinearRgb transmittance = LinearRgb(1.0F, 1.0F, 1.0F);  ///< Of one passage through a lens, per channel, 0 … 1.
  Texture texture{};                                      ///< Laid over `colour`; not for lenses.
  float translucency = 0.0F;  ///< kTranslucent: share of the diffuse light that comes through from behind, 0 … 1.
  /// kLens: the lens' spherical power, D, −30 … 30, for the z-buffer's pseudo ray tracing (paper 000, §4).
  float lens_power = 0.0F;
  /// kLens: transmittance at the lower end of a gradient, and where the gradient runs, as heights of the solid
  /// coordinate z, mm; none if from == to.
  LinearRgb lower_transmittance = LinearRgb(1.0F, 1.0F, 1.0F);
  float gradient_from = 0.0F;  ///< At and above it `transmittance`.
  float gradient_to = 0.0F;    ///< At and below it `lower_transmittance`; <= gradient_from.
};

/// Glossy plastic of a colour.
[[nodiscard]] Material PlasticMaterial(const LinearRgb& colour);
/// Polished metal; `colour` is its reflectance (gold about #ffd791, silver about #f7f4eb).
[[nodiscard]] Material MetalMaterial(const LinearRgb& colour);
/// Skin of a natural tone.
[[nodiscard]] Material SkinMaterial();
/// A neutral, warm-grey body.
[[nodiscard]] Material NeutralBodyMaterial();
/// A lens dyed with `tint` so deeply that it passes `transmittance` (0 … 1, luminous) of white light. The dye follows
/// Beer's law: a pale lens is hardly coloured, a dark one strongly. White, grey and black tints give a grey lens.
[[nodiscard]] Material LensSheetMaterial(const LinearRgb& tint, double transmittance);

/// A point to be shaded. Camera frame of camera.h with z turned towards the eye: x right, y up, z to the viewer.
struct ShadingPoint {
  Eigen::Vector3f normal;                           ///< Unit, on the viewer's side.
  Eigen::Vector3f to_eye;                           ///< Unit.
  Eigen::Vector3f along = Eigen::Vector3f::Zero();  ///< Of the grooves of kBrushed; need not be unit; zero: any.
};

/// Light that leaves an opaque surface towards the eye under the studio's lights, linear, softly limited to below 1.
/// `colour` (0 … 1) takes the place of the material's: texture and vertex colours applied. Requires a finish other than
/// kLens.
[[nodiscard]] LinearRgb Shade(const Material& material, const LinearRgb& colour, const ShadingPoint& point);
/// The same in the material's own colour.
[[nodiscard]] LinearRgb Shade(const Material& material, const ShadingPoint& point);

/// Light that a lens surface adds by mirroring the studio's lamps; exactly 0 where none is mirrored.
[[nodiscard]] LinearRgb LensHighlight(const ShadingPoint& point);

}  // namespace annulus
