#include "render/texture.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"

namespace annulus {
namespace {

/// Coordinates beyond it (mm) are held: far beyond any frame, and lattice indices stay within an int.
constexpr float kFarthest = 1.0e6F;
/// An octave of this wavelength (mm) or shorter is left out, of twice that is whole: pixels of 0.3 mm cannot show it.
constexpr float kShortestWave = 0.6F;

/// Mixes a lattice point and a channel into 32 bits. Integers only: the same on every machine.
std::uint32_t HashOf(int x, int y, int z, std::uint32_t channel) {
  std::uint32_t h = channel;
  h ^= static_cast<std::uint32_t>(x) * 0x8da6b343U;
  h ^= static_cast<std::uint32_t>(y) * 0xd8163841U;
  h ^= static_cast<std::uint32_t>(z) * 0xcb1ab31fU;
  h = (h ^ (h >> 15)) * 0x2c1b3c6dU;
  h = (h ^ (h >> 13)) * 0x297a2d39U;
  return h ^ (h >> 16);
}

/// A number of 0 … 1 (exclusive) from some bits of a hash.
float UnitFrom(std::uint32_t bits) { return static_cast<float>(bits & 0xFFFFU) * (1.0F / 65536.0F); }

/// The twelve edge directions of a cube, four of them twice.
constexpr std::array<std::array<float, 3>, 16> kGradients = {{{1, 1, 0},
                                                              {-1, 1, 0},
                                                              {1, -1, 0},
                                                              {-1, -1, 0},
                                                              {1, 0, 1},
                                                              {-1, 0, 1},
                                                              {1, 0, -1},
                                                              {-1, 0, -1},
                                                              {0, 1, 1},
                                                              {0, -1, 1},
                                                              {0, 1, -1},
                                                              {0, -1, -1},
                                                              {1, 1, 0},
                                                              {-1, 1, 0},
                                                              {0, -1, 1},
                                                              {0, -1, -1}}};

float Fade(float t) { return t * t * t * (t * (t * 6.0F - 15.0F) + 10.0F); }
float Mix(float from, float to, float share) { return from + share * (to - from); }

/// 0 below `low`, 1 above `high`, smooth between.
float Step(float low, float high, float value) {
  const float t = std::clamp((value - low) / (high - low), 0.0F, 1.0F);
  return t * t * (3.0F - 2.0F * t);
}

/// A lattice cell and the place in it.
struct Cell {
  int x;
  int y;
  int z;
  Eigen::Vector3f in;

  explicit Cell(const Eigen::Vector3f& p) {
    const Eigen::Vector3f floor(std::floor(p.x()), std::floor(p.y()), std::floor(p.z()));
    x = static_cast<int>(floor.x());
    y = static_cast<int>(floor.y());
    z = static_cast<int>(floor.z());
    in = p - floor;
  }
};

/// Gradient noise of wavelength about 1, within -1 … 1, mean 0, continuous to the second derivative.
float Noise(const Eigen::Vector3f& p, std::uint32_t channel) {
  const Cell cell(p);
  const auto corner = [&cell, channel](int i, int j, int k) {
    const auto& g = kGradients[HashOf(cell.x + i, cell.y + j, cell.z + k, channel) & 15U];
    return g[0] * (cell.in.x() - static_cast<float>(i)) + g[1] * (cell.in.y() - static_cast<float>(j)) +
           g[2] * (cell.in.z() - static_cast<float>(k));
  };
  const float u = Fade(cell.in.x());
  const float v = Fade(cell.in.y());
  const float w = Fade(cell.in.z());
  const float near = Mix(Mix(corner(0, 0, 0), corner(1, 0, 0), u), Mix(corner(0, 1, 0), corner(1, 1, 0), u), v);
  const float far = Mix(Mix(corner(0, 0, 1), corner(1, 0, 1), u), Mix(corner(0, 1, 1), corner(1, 1, 1), u), v);
  return std::clamp(Mix(near, far, w), -1.0F, 1.0F);
}

/// What is left of an octave of wavelength `wave` (mm, before scaling) at this scale.
float Resolved(float wave, float scale) { return Step(kShortestWave, 2.0F * kShortestWave, wave * scale); }

/// Between two dyes as they mix in a melt: near the geometric mean at one half, so that between amber and dark brown
/// lies red-brown, not grey. Square root of (arithmetic mean x harmonic mean) of the shares.
LinearRgb DyeMix(const LinearRgb& from, const LinearRgb& to, float share) {
  constexpr float kTrace = 1.0e-6F;
  const Eigen::Array3f a = from.array() + kTrace;
  const Eigen::Array3f b = to.array() + kTrace;
  const Eigen::Array3f forth = (1.0F - share) * a + share * b;
  const Eigen::Array3f back = share * a + (1.0F - share) * b;
  const Eigen::Array3f mixed = (a * b * forth / back).sqrt() - kTrace;
  return mixed.max(from.array().min(to.array())).min(from.array().max(to.array())).matrix();
}

LinearRgb Blend(const LinearRgb& from, const LinearRgb& to, float share) { return from + share * (to - from); }

/// Dark clouds with soft edges in the ground colour: wide ones, dark cores in them, small spots beside.
LinearRgb Tortoiseshell(const Texture& texture, const LinearRgb& ground, const Eigen::Vector3f& p) {
  const std::uint32_t seed = texture.seed * 0x9e3779b9U;
  // Pressed in the sheet: longer across the front and through its thickness than high.
  const Eigen::Vector3f q(p.x() * 0.8F, p.y() * 0.55F, p.z());
  const float wide = Noise(q / 13.0F, seed + 1U);
  const float middle = Noise(q / 6.1F, seed + 2U);
  const float small = Resolved(2.6F, texture.scale) * Noise(q / 2.6F, seed + 3U);
  const float cloud = wide + 0.55F * middle + 0.12F * small;
  const float haze = 0.36F * Step(-0.40F, 0.25F, cloud - 0.25F * middle);
  const float core = Step(-0.02F, 0.28F, cloud);
  return DyeMix(ground, texture.second, std::max(haze, core));
}

/// Long streaks along the front and along the temples, in wider bands of light and dark.
LinearRgb Horn(const Texture& texture, const LinearRgb& ground, const Eigen::Vector3f& p) {
  const std::uint32_t seed = texture.seed * 0x9e3779b9U;
  const Eigen::Vector3f slow = p / 34.0F;
  const float bend = Noise(slow, seed + 11U);
  const float height = p.z() + 9.0F * bend;
  const float bands = Noise({slow.x(), slow.y(), height / 9.0F}, seed + 12U);
  const float streaks = Noise({p.x() / 26.0F, p.y() / 26.0F, height / 2.7F}, seed + 13U);
  const float fine = Resolved(1.3F, texture.scale) * Noise({p.x() / 14.0F, p.y() / 14.0F, height / 1.3F}, seed + 14U);
  const float tone = 0.8F * bands + 0.75F * streaks + 0.35F * fine;
  return DyeMix(ground, texture.second, Step(-0.55F, 0.65F, tone));
}

/// Flakes, each with its own tone and slope of tone, as if tilted against the light; their edges run into each other.
LinearRgb Pearl(const Texture& texture, const LinearRgb& ground, const Eigen::Vector3f& p) {
  const std::uint32_t seed = texture.seed * 0x9e3779b9U + 21U;
  // A slow swirl before the flakes are cut, so that their edges are not straight.
  const float swirl = Noise(p / 9.0F, seed);
  const Eigen::Vector3f q(p.x() / 5.2F + 0.8F * swirl, p.y() / 7.0F, p.z() / 3.6F - 0.6F * swirl);
  const Cell cell(q - Eigen::Vector3f::Constant(0.5F));
  // Between the kernels a middling tone shows through.
  constexpr float kGap = 0.02F;
  float sum = 0.5F * kGap;
  float weights = kGap;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1;
    const int j = (corner >> 1) & 1;
    const int k = corner >> 2;
    const std::uint32_t h = HashOf(cell.x + i, cell.y + j, cell.z + k, seed);
    const std::uint32_t g = h * 0x85ebca6bU;
    // Kernels sit within a quarter of their cell's centre and end before they leave the eight cells looked at.
    const Eigen::Vector3f centre(static_cast<float>(i) + 0.5F * UnitFrom(h) - 0.25F,
                                 static_cast<float>(j) + 0.5F * UnitFrom(h >> 8) - 0.25F,
                                 static_cast<float>(k) + 0.5F * UnitFrom(h >> 16) - 0.25F);
    const Eigen::Vector3f from = cell.in - centre;
    const float inside = std::max(0.0F, 1.0F - from.squaredNorm() / 0.5625F);
    const float squared = inside * inside;
    const float weight = squared * inside;
    const float slope_x = UnitFrom(g) - 0.5F;
    const float slope_z = UnitFrom(g >> 12) - 0.5F;
    sum += weight * (UnitFrom(g >> 6) + 1.3F * (slope_x * from.x() + slope_z * from.z()));
    weights += weight;
  }
  const float tone = sum / weights;
  return Blend(ground, texture.second, Step(-0.1F, 1.15F, tone));
}

/// Fine lines, gently waved, that run obliquely down the front and the temples and are crossed by fainter ones.
LinearRgb Carved(const Texture& texture, const LinearRgb& ground, const Eigen::Vector3f& p) {
  constexpr float kPeriod = 1.8F;
  const std::uint32_t seed = texture.seed * 0x9e3779b9U;
  const float wave = 0.9F * Noise(p / 11.0F, seed + 31U);
  const float along = 0.72F * (p.x() - p.y());
  // A smooth wave of period 1 without a sine: 16 t^2 (1 - t)^2 of the fraction.
  const auto ridge = [](float phase) {
    const float t = phase - std::floor(phase);
    const float bell = 4.0F * t * (1.0F - t);
    return bell * bell;
  };
  const float lines = ridge((along + p.z()) / kPeriod + wave);
  const float crossing = ridge((along - p.z()) / kPeriod - wave);
  const float shown = Resolved(kPeriod, texture.scale);
  const float cut = 0.68F * lines + 0.32F * lines * crossing;
  return Blend(ground, texture.second, Mix(0.45F, cut, shown));
}

/// Within reach and finite, in units of the pattern.
Eigen::Vector3f PlaceOf(const Texture& texture, const Eigen::Vector3f& solid) {
  const float scale = std::clamp(texture.scale, 0.1F, 10.0F);
  const auto held = [scale](float value) {
    return std::isnan(value) ? 0.0F : std::clamp(value, -kFarthest, kFarthest) / scale;
  };
  return {held(solid.x()), held(solid.y()), held(solid.z())};
}

}  // namespace

LinearRgb TextureColour(const Texture& texture, const LinearRgb& ground, const Eigen::Vector3f& solid) {
  switch (texture.pattern) {
    case TexturePattern::kPlain:
      return ground;
    case TexturePattern::kTortoiseshell:
      return Tortoiseshell(texture, ground, PlaceOf(texture, solid));
    case TexturePattern::kHorn:
      return Horn(texture, ground, PlaceOf(texture, solid));
    case TexturePattern::kPearl:
      return Pearl(texture, ground, PlaceOf(texture, solid));
    case TexturePattern::kCarved:
      return Carved(texture, ground, PlaceOf(texture, solid));
  }
  ENSURE(false, "a pattern of the enumeration");
  return ground;
}

}  // namespace annulus
