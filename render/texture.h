#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "render/colour.h"

namespace annulus {

/// Patterns of a frame's material (paper 000, §6.1: five textures, one of them plain). All are solid: the pattern runs
/// through the body as in a sheet of cellulose acetate, and a cut shows its section.
enum class TexturePattern {
  kPlain,
  kTortoiseshell,  ///< Dark clouds in an amber ground, layered across the sheet.
  kHorn,           ///< Long streaks.
  kPearl,          ///< Flakes of lighter and darker tone, as mother-of-pearl acetate.
  kCarved,         ///< Fine parallel lines, as an engraved or woven laminate.
};

/// A pattern and what it is laid with.
struct Texture {
  TexturePattern pattern = TexturePattern::kPlain;
  LinearRgb second = LinearRgb(0.02F, 0.01F, 0.006F);  ///< The pattern's own colour; the ground is the material's.
  float scale = 1.0F;                                  ///< Size of the pattern, 0.1 … 10; 1 is a usual sheet.
  std::uint32_t seed = 0;                              ///< Which part of the sheet the frame is cut from.
};

/// The colour at `solid` (mm, the body's own coordinates: see SceneItem::solid) of a body of ground colour `ground`.
/// Finite, within 0 … 1 per channel where ground and second are. The same everywhere for kPlain.
[[nodiscard]] LinearRgb TextureColour(const Texture& texture, const LinearRgb& ground, const Eigen::Vector3f& solid);

}  // namespace annulus
