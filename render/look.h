#pragma once

#include <Eigen/Core>

#include "render/colour.h"
#include "render/material.h"
#include "render/solid_lens.h"

namespace annulus {

/// What the upper or the lower half of a frame is made of (paper 000, §6.1).
struct PartLook {
  LinearRgb colour = LinearFromHex(0x2b1a12);
  Finish finish = Finish::kPlastic;  ///< kPlastic, kTranslucent, kMetal or kBrushed.
  Texture texture{};
};

/// What its lenses look like.
struct LensLook {
  LinearRgb tint = LinearFromHex(0x6f5a48);  ///< Of the dye.
  double transmittance = 0.85;               ///< Luminous, of the lens' middle thickness, 0 … 1.
  double lower_transmittance = 0.85;         ///< At the lower edge; equal: no gradient.
  LensCoating coating = LensCoating::kAntiReflective;
  LinearRgb mirror = LinearRgb(0.45F, 0.50F, 0.60F);  ///< kMirror only.
  double power = 0.0;  ///< D: where no prescription says more, −30 … 30.
};

/// A colour laid on the skin.
struct MakeUpLayer {
  LinearRgb colour = LinearRgb::Zero();
  double strength = 0.0;  ///< 0 (none) … 1 (opaque).
};
/// The paper's last open point: make-up beside the glasses.
struct MakeUp {
  MakeUpLayer lips;
  MakeUpLayer cheeks;
  MakeUpLayer brows;
};

/// All that is chosen beside shapes.
struct Look {
  PartLook upper{};
  PartLook lower{};
  LensLook lens{};
  LinearRgb skin = LinearFromHex(0xdfb8a0);
  MakeUp make_up{};
};

/// The material of a half of the frame.
[[nodiscard]] Material MaterialOf(const PartLook& part);
/// The material of a lens' sheet for the z-buffer, its gradient between `top` and `bottom` (solid z, mm).
[[nodiscard]] Material SheetMaterialOf(const LensLook& lens, double top, double bottom);
/// The finish of a solid lens for the tracer, its gradient between `top` and `bottom` (lens y, mm). `thickness`: the
/// mean length of a ray in the glass, mm, for which the transmittances hold.
[[nodiscard]] LensFinish LensFinishOf(const LensLook& lens, double top, double bottom, double thickness);

}  // namespace annulus
