#pragma once

#include "render/colour.h"

namespace annulus {

enum class Finish {
  kPlastic,  ///< Diffuse body colour under a clear dielectric surface (index 1.5).
  kMetal,    ///< Coloured mirror of the studio, no diffuse part.
  kSkin,     ///< Soft diffuse with light bleeding round the terminator; also for a neutral body.
  kLens,     ///< Thin transmitting surface; only `transmittance` counts.
};

/// What a surface is made of.
struct Material {
  Finish finish = Finish::kPlastic;
  LinearRgb colour = LinearRgb(0.5F, 0.5F, 0.5F);         ///< Diffuse albedo, or the metal's reflectance, 0 … 1.
  float roughness = 0.3F;                                 ///< GGX width, 0 (mirror) … 1 (chalk).
  LinearRgb transmittance = LinearRgb(1.0F, 1.0F, 1.0F);  ///< Of one passage through a lens, per channel, 0 … 1.
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
[[nodiscard]] Material LensMaterial(const LinearRgb& tint, double transmittance);

/// A point to be shaded. Camera frame of camera.h with z turned towards the eye: x right, y up, z to the viewer.
struct ShadingPoint {
  Eigen::Vector3f normal;  ///< Unit, on the viewer's side.
  Eigen::Vector3f to_eye;  ///< Unit.
};

/// Light that leaves an opaque surface towards the eye under the studio's lights, linear, softly limited to below 1.
/// Requires a finish other than kLens.
[[nodiscard]] LinearRgb Shade(const Material& material, const ShadingPoint& point);

/// Light that a lens surface adds by mirroring the studio's lamps; exactly 0 where none is mirrored.
[[nodiscard]] LinearRgb LensHighlight(const ShadingPoint& point);

}  // namespace annulus
