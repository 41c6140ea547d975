#include "render/material.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "base/ensure.h"
#include "base/units.h"
#include "render/studio.h"
#include "render/tone.h"

namespace annulus {
namespace {

/// Reflectance at normal incidence of plastic, lacquer and lens glass: ((n - 1) / (n + 1))^2 with n = 1.5.
constexpr float kDielectricReflectance = 0.04F;

/// Schlick's approximation: the share of (1 - R0) that grazing incidence adds.
float GrazingShare(float cosine) {
  const float m = std::clamp(1.0F - cosine, 0.0F, 1.0F);
  const float m2 = m * m;
  return m2 * m2 * m;
}

float DielectricFresnel(float cosine) {
  return kDielectricReflectance + (1.0F - kDielectricReflectance) * GrazingShare(cosine);
}

/// Microfacet lobe D * V of Trowbridge-Reitz (GGX), V by the height-correlated form of Smith's shadowing; the light's
/// cosine included, Fresnel left out. alpha = roughness^2.
float GgxLobe(float n_dot_l, float n_dot_v, float n_dot_h, float alpha) {
  const float a2 = alpha * alpha;
  const float d = n_dot_h * n_dot_h * (a2 - 1.0F) + 1.0F;
  const float distribution = a2 / (static_cast<float>(kPi) * d * d);
  const float shadow_l = n_dot_v * std::sqrt(n_dot_l * n_dot_l * (1.0F - a2) + a2);
  const float shadow_v = n_dot_l * std::sqrt(n_dot_v * n_dot_v * (1.0F - a2) + a2);
  return distribution * 0.5F / (shadow_l + shadow_v) * n_dot_l;
}

Eigen::Vector3f Mirrored(const ShadingPoint& point) {
  return 2.0F * point.normal.dot(point.to_eye) * point.normal - point.to_eye;
}

/// Highlights of the far lights on a dielectric.
LinearRgb LightHighlights(const Material& material, const ShadingPoint& point, float n_dot_v) {
  const float roughness = std::clamp(material.roughness, 0.12F, 1.0F);  // the lights are not points
  LinearRgb sum = LinearRgb::Zero();
  for (const DirectionalLight& light : StudioLights()) {
    const float n_dot_l = point.normal.dot(light.direction);
    if (n_dot_l <= 0.0F) continue;
    const Eigen::Vector3f half = (light.direction + point.to_eye).normalized();
    const float fresnel = DielectricFresnel(half.dot(point.to_eye));
    const float lobe = GgxLobe(n_dot_l, n_dot_v, std::max(0.0F, point.normal.dot(half)), roughness * roughness);
    sum += fresnel * lobe * static_cast<float>(kPi) * light.radiance;
  }
  return sum;
}

LinearRgb MatteLight(const Eigen::Vector3f& normal) {
  LinearRgb sum = StudioAmbient(normal);
  for (const DirectionalLight& light : StudioLights()) {
    sum += std::max(0.0F, normal.dot(light.direction)) * light.radiance;
  }
  return sum;
}

/// Light scattered under the skin reaches past the terminator, red the furthest.
LinearRgb SkinLight(const Eigen::Vector3f& normal) {
  static const Eigen::Array3f kReach(0.26F, 0.14F, 0.09F);
  LinearRgb sum = StudioAmbient(normal);
  for (const DirectionalLight& light : StudioLights()) {
    const Eigen::Array3f wrapped = ((normal.dot(light.direction) + kReach) / (1.0F + kReach)).max(0.0F);
    sum += (wrapped * (0.55F + 0.45F * wrapped) * light.radiance.array()).matrix();
  }
  return sum;
}

LinearRgb DiffuseLight(const Material& material, const Eigen::Vector3f& normal) {
  if (material.finish == Finish::kSkin) return SkinLight(normal);
  if (material.finish != Finish::kTranslucent) return MatteLight(normal);
  return (1.0F - material.translucency) * MatteLight(normal) + material.translucency * MatteLight(-normal);
}

LinearRgb ShadeDielectric(const Material& material, const LinearRgb& colour, const ShadingPoint& point) {
  const float n_dot_v = std::max(1e-3F, point.normal.dot(point.to_eye));
  const float fresnel = DielectricFresnel(n_dot_v) * (1.0F - 0.7F * material.roughness);
  const LinearRgb light = DiffuseLight(material, point.normal);
  const Eigen::Vector3f mirrored = Mirrored(point);
  LinearRgb walls = StudioWalls(mirrored, material.roughness);
  if (material.finish != Finish::kSkin) walls += 0.6F * StudioLamps(mirrored, material.roughness);
  // Skin is not a closed film: most of its gloss is broken by pores and fine hair.
  const float gloss = material.finish == Finish::kSkin ? 0.35F : 1.0F;
  return (1.0F - fresnel) * colour.cwiseProduct(light) + gloss * LightHighlights(material, point, n_dot_v) +
         fresnel * walls;
}

LinearRgb ShadeMetal(const Material& material, const LinearRgb& colour, const ShadingPoint& point) {
  const float grazing = GrazingShare(std::max(0.0F, point.normal.dot(point.to_eye)));
  const LinearRgb reflectance = colour + grazing * (LinearRgb::Ones() - colour);
  const Eigen::Vector3f mirrored = Mirrored(point);
  const LinearRgb seen = StudioWalls(mirrored, material.roughness) + 0.8F * StudioLamps(mirrored, material.roughness);
  return reflectance.cwiseProduct(seen);
}

/// Across the grooves of a brushed surface, within it.
Eigen::Vector3f AcrossGrooves(const ShadingPoint& point) {
  for (const Eigen::Vector3f& along :
       {point.along, Eigen::Vector3f(1.0F, 0.0F, 0.0F), Eigen::Vector3f(0.0F, 1.0F, 0.0F)}) {
    const Eigen::Vector3f across = point.normal.cross(along);
    const float length = across.norm();
    if (length > 1e-3F) return across / length;
  }
  return Eigen::Vector3f::Zero();
}

/// The walls of the grooves lean to both sides: what the surface mirrors is drawn out across them, a fan of mirrors.
LinearRgb ShadeBrushed(const Material& material, const LinearRgb& colour, const ShadingPoint& point) {
  constexpr std::array<float, 7> kLean = {-1.8F, -1.1F, -0.5F, 0.0F, 0.5F, 1.1F, 1.8F};
  constexpr std::array<float, 7> kShare = {0.04F, 0.12F, 0.21F, 0.26F, 0.21F, 0.12F, 0.04F};  // about Gaussian, sum 1
  const Eigen::Vector3f across = AcrossGrooves(point);
  const float spread = 0.08F + 0.6F * material.roughness;
  const float rest = 0.08F + 0.4F * material.roughness;  // blur along the grooves, and between the mirrors
  LinearRgb seen = LinearRgb::Zero();
  for (std::size_t k = 0; k < kLean.size(); ++k) {
    const Eigen::Vector3f normal = (point.normal + spread * kLean[k] * across).normalized();
    const Eigen::Vector3f mirrored = 2.0F * normal.dot(point.to_eye) * normal - point.to_eye;
    seen += kShare[k] * (StudioWalls(mirrored, rest) + 0.8F * StudioLamps(mirrored, rest));
  }
  const float grazing = GrazingShare(std::max(0.0F, point.normal.dot(point.to_eye)));
  return (colour + grazing * (LinearRgb::Ones() - colour)).cwiseProduct(seen);
}

/// Relative luminance of the sRGB primaries (IEC 61966-2-1).
double LuminanceOf(const Eigen::Array3d& rgb) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }

/// A dye passes something and stops something in every channel.
constexpr double kDeepestTint = 0.02;
constexpr double kPalestTint = 0.97;
/// Beyond it every dye is black: 0.97^4096 < 1e-54.
constexpr double kThickestDye = 4096.0;

}  // namespace

Material PlasticMaterial(const LinearRgb& colour) {
  Material material;
  material.finish = Finish::kPlastic;
  material.colour = colour;
  material.roughness = 0.22F;
  return material;
}

Material MetalMaterial(const LinearRgb& colour) {
  Material material;
  material.finish = Finish::kMetal;
  material.colour = colour;
  material.roughness = 0.14F;
  return material;
}

Material SkinMaterial() {
  Material material;
  material.finish = Finish::kSkin;
  material.colour = LinearFromHex(0xdfb8a0);
  material.roughness = 0.48F;
  return material;
}

Material NeutralBodyMaterial() {
  Material material;
  material.finish = Finish::kSkin;
  material.colour = LinearFromHex(0xcfcac4);
  material.roughness = 0.55F;
  return material;
}

Material LensSheetMaterial(const LinearRgb& tint, double transmittance) {
  const Eigen::Array3d pass = tint.cast<double>().array().max(kDeepestTint).min(kPalestTint);
  const double wanted = std::clamp(transmittance, 0.0, 1.0);
  // Thickness at which the dye passes the wanted share of the light; the share falls as the thickness grows.
  double thin = 0.0;
  double thick = 1.0;
  while (LuminanceOf(pass.pow(thick)) > wanted && thick < kThickestDye) thick *= 2.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (thin + thick);
    (LuminanceOf(pass.pow(middle)) > wanted ? thin : thick) = middle;
  }
  Material material;
  material.finish = Finish::kLens;
  material.transmittance = pass.pow(0.5 * (thin + thick)).cast<float>().matrix();
  return material;
}

LinearRgb Shade(const Material& material, const LinearRgb& colour, const ShadingPoint& point) {
  ENSURE(material.finish != Finish::kLens, "a lens has no surface colour of its own");
  const auto light = [&]() -> LinearRgb {
    switch (material.finish) {
      case Finish::kMatte:
        return colour.cwiseProduct(MatteLight(point.normal));
      case Finish::kMetal:
        return ShadeMetal(material, colour, point);
      case Finish::kBrushed:
        return ShadeBrushed(material, colour, point);
      default:
        return ShadeDielectric(material, colour, point);
    }
  }();
  return SoftLimit(light);
}

LinearRgb Shade(const Material& material, const ShadingPoint& point) { return Shade(material, material.colour, point); }

LinearRgb LensHighlight(const ShadingPoint& point) {
  constexpr float kLensRoughness = 0.02F;
  const LinearRgb lamps = StudioLamps(Mirrored(point), kLensRoughness);
  // Front and back surface mirror the same lamp: 2 R / (1 + R) of two parallel faces.
  const float fresnel = DielectricFresnel(std::max(0.0F, point.normal.dot(point.to_eye)));
  return 2.0F * fresnel / (1.0F + fresnel) * lamps;
}

}  // namespace annulus
