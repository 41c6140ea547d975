#include "render/look.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"

namespace annulus {
namespace {

/// Milky acetate: how much of the body's light comes through from behind.
constexpr float kMilky = 0.45F;
/// Beer's law over a length of nothing says nothing.
constexpr double kThinnest = 0.1;
/// The glass length that LensFinish speaks of, mm.
constexpr double kFinishThickness = 2.0;
/// No dye is quite black.
constexpr double kLeastTransmittance = 1.0e-6;

/// The same dye in another length of glass, clamped to what LensFinish holds.
LinearRgb AfterLength(const LinearRgb& transmittance, double exponent) {
  const Eigen::Array3d held = transmittance.cast<double>().array().max(kLeastTransmittance).min(1.0);
  return held.pow(exponent).max(kLeastTransmittance).min(1.0).cast<float>().matrix();
}

LinearRgb PassOf(const LensLook& lens, double transmittance) {
  return LensSheetMaterial(lens.tint, transmittance).transmittance;
}

bool HasGradient(const LensLook& lens) { return lens.lower_transmittance != lens.transmittance; }

}  // namespace

Material MaterialOf(const PartLook& part) {
  const bool is_metal = part.finish == Finish::kMetal || part.finish == Finish::kBrushed;
  ENSURE(is_metal || part.finish == Finish::kPlastic || part.finish == Finish::kTranslucent,
         "a frame is of plastic, milky plastic, metal or brushed metal");
  Material material = is_metal ? MetalMaterial(part.colour) : PlasticMaterial(part.colour);
  material.finish = part.finish;
  material.texture = part.texture;
  if (part.finish == Finish::kTranslucent) material.translucency = kMilky;
  if (part.finish == Finish::kBrushed) material.roughness = 0.32F;
  return material;
}

Material SheetMaterialOf(const LensLook& lens, double top, double bottom) {
  Material material = LensSheetMaterial(lens.tint, lens.transmittance);
  material.lower_transmittance = material.transmittance;
  if (HasGradient(lens)) {
    material.lower_transmittance = PassOf(lens, lens.lower_transmittance);
    material.gradient_from = static_cast<float>(std::max(top, bottom));
    material.gradient_to = static_cast<float>(std::min(top, bottom));
  }
  material.lens_power = static_cast<float>(lens.power);
  if (lens.coating == LensCoating::kMirror) material.colour = lens.mirror;
  return material;
}

LensFinish LensFinishOf(const LensLook& lens, double top, double bottom, double thickness) {
  const double exponent = kFinishThickness / std::max(thickness, kThinnest);
  LensFinish finish;
  finish.transmittance = AfterLength(PassOf(lens, lens.transmittance), exponent);
  finish.lower_transmittance = finish.transmittance;
  if (HasGradient(lens)) {
    finish.lower_transmittance = AfterLength(PassOf(lens, lens.lower_transmittance), exponent);
    finish.gradient_from = std::max(top, bottom);
    finish.gradient_to = std::min(top, bottom);
  }
  finish.coating = lens.coating;
  finish.mirror = lens.mirror;
  return finish;
}

}  // namespace annulus
