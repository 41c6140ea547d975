#include "render/light_presets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/units.h"
#include "render/studio.h"

namespace annulus {
namespace {

float SmoothStep(float from, float to, float value) {
  const float t = std::clamp((value - from) / (to - from), 0.0F, 1.0F);
  return t * t * (3.0F - 2.0F * t);
}

/// 1 within `half` of 0, falling to 0 over `soft` on both sides of the edge.
float SoftSlab(float position, float half, float soft) {
  return 1.0F - SmoothStep(half - soft, half + soft, std::abs(position));
}

LinearRgb Mixed(const LinearRgb& from, const LinearRgb& to, float share) { return from + share * (to - from); }

/// A rectangular lamp far away, brightest in its middle, as a diffuser before a bulb is.
struct Softbox {
  Eigen::Vector3f middle;  // unit
  Eigen::Vector3f right;   // unit, along its width
  Eigen::Vector3f up;      // unit, along its height
  Eigen::Vector2f half;    // tangents of half the angles
  LinearRgb radiance;
};

Softbox MakeSoftbox(const Eigen::Vector3f& towards, const Eigen::Vector2f& half, const LinearRgb& radiance) {
  const Eigen::Vector3f middle = towards.normalized();
  const Eigen::Vector3f right = Eigen::Vector3f(0.0F, 1.0F, 0.02F).cross(middle).normalized();
  return {middle, right, middle.cross(right), half, radiance};
}

LinearRgb SoftboxRadiance(const Softbox& lamp, const Eigen::Vector3f& d) {
  constexpr float kSoftEdge = 0.025F;
  const float along = d.dot(lamp.middle);
  if (along < 0.1F) return LinearRgb::Zero();
  const float x = d.dot(lamp.right) / along;
  const float y = d.dot(lamp.up) / along;
  const float shape = SoftSlab(x, lamp.half.x(), kSoftEdge) * SoftSlab(y, lamp.half.y(), kSoftEdge);
  if (shape <= 0.0F) return LinearRgb::Zero();
  const float from_middle = x * x / (lamp.half.x() * lamp.half.x()) + y * y / (lamp.half.y() * lamp.half.y());
  return shape * (1.15F - 0.22F * std::min(2.0F, from_middle)) * lamp.radiance;
}

/// The lamps of studio.h, with the places and sizes that its mirror images have.
LinearRgb StudioRadiance(const Eigen::Vector3f& d) {
  static const std::array<Softbox, 4> kLamps = {
      MakeSoftbox({-0.62F, 0.52F, 0.58F}, {0.42F, 0.52F}, {4.7F, 4.45F, 4.1F}),
      MakeSoftbox({0.86F, 0.10F, 0.50F}, {0.13F, 0.70F}, {1.5F, 1.6F, 1.8F}),
      MakeSoftbox({0.05F, 0.97F, 0.25F}, {0.70F, 0.28F}, {0.8F, 0.8F, 0.8F}),
      MakeSoftbox({0.62F, 0.42F, -0.66F}, {0.35F, 0.60F}, {2.2F, 2.3F, 2.5F}),
  };
  LinearRgb sum = 0.34F * StudioWalls(d, 0.0F);
  for (const Softbox& lamp : kLamps) sum += SoftboxRadiance(lamp, d);
  return sum;
}

/// The shop, in metres from the eyes of the person, x right, y up, z towards the viewer.
LinearRgb ShopCeiling(const Eigen::Vector3f& p) {
  // Panels 0.3 m x 1.2 m in rows across, every 1.6 m; further ones are lost in haze.
  const float across = p.x() - 1.6F * std::round(p.x() / 1.6F);
  const float along = p.z() - 0.4F - 2.0F * std::round((p.z() - 0.4F) / 2.0F);
  const float far = std::exp(-0.03F * (p.x() * p.x() + p.z() * p.z()));
  const float panel = SoftSlab(across, 0.60F, 0.03F) * SoftSlab(along, 0.15F, 0.03F);
  return Mixed({0.50F, 0.48F, 0.45F}, {6.6F, 6.3F, 5.9F}, panel * far);
}

LinearRgb ShopWall(float across, float up) {
  // Lit shelves 0.35 m apart, with dark things on them.
  const float shelf = up - 0.35F * std::round(up / 0.35F);
  const float strip = SoftSlab(shelf - 0.14F, 0.025F, 0.02F);
  const float things =
      0.35F + 0.65F * SmoothStep(-0.3F, 0.5F, std::cos(19.0F * across) * std::cos(5.3F * across + 0.7F));
  const float within = SoftSlab(up - 0.1F, 0.95F, 0.05F);
  const LinearRgb board = things * LinearRgb(0.55F, 0.50F, 0.44F);
  return Mixed({0.48F, 0.46F, 0.43F}, Mixed(board, {2.0F, 1.8F, 1.5F}, strip), within);
}

LinearRgb ShopWindow(const Eigen::Vector3f& p) {
  const float pane = SoftSlab(p.y() - 0.35F, 1.15F, 0.04F) * SoftSlab(p.z() - 0.9F, 1.8F, 0.04F);
  const float bar = 1.0F - SoftSlab(p.z() - 0.9F - 1.2F * std::round((p.z() - 0.9F) / 1.2F), 0.04F, 0.03F);
  const LinearRgb outside = Mixed({2.2F, 2.3F, 2.3F}, {5.4F, 6.0F, 7.0F}, SmoothStep(-0.4F, 0.6F, p.y()));
  return Mixed(ShopWall(p.z(), p.y()), outside, pane * bar);
}

LinearRgb ShopRadiance(const Eigen::Vector3f& d) {
  // A room of 5.2 m x 7 m, 2.9 m high, seen from 1.55 m above its floor.
  const Eigen::Vector3f wall(d.x() < 0.0F ? 2.4F : 2.8F, d.y() < 0.0F ? 1.55F : 1.35F, d.z() < 0.0F ? 3.2F : 3.8F);
  const Eigen::Vector3f steps = wall.array() / d.array().abs().max(1e-6F);
  const float nearest = steps.minCoeff();
  const Eigen::Vector3f p = nearest * d;
  if (nearest == steps.y()) {
    if (d.y() > 0.0F) return ShopCeiling(p);
    return Mixed({0.30F, 0.25F, 0.20F}, {0.20F, 0.17F, 0.14F}, SmoothStep(0.5F, 4.0F, p.norm()));
  }
  if (nearest == steps.z()) return ShopWall(p.x(), p.y());
  return d.x() < 0.0F ? ShopWindow(p) : ShopWall(p.z(), p.y());
}

const Eigen::Vector3f& SunDirection() {
  static const Eigen::Vector3f kSun = Eigen::Vector3f(-0.55F, 0.62F, 0.56F).normalized();
  return kSun;
}

LinearRgb DaylightRadiance(const Eigen::Vector3f& d) {
  constexpr auto kDegree = static_cast<float>(kPi / 180.0);
  // Angle to the sun's middle; the chord keeps its precision near 0.
  const float from_sun = 2.0F * std::asin(std::min(1.0F, 0.5F * (d - SunDirection()).norm()));
  const float disc = 1.0F - SmoothStep(1.2F * kDegree, 3.0F * kDegree, from_sun);
  const float glow = std::exp(-from_sun / 0.22F);
  const float height = std::max(0.0F, d.y());
  const LinearRgb zenith(0.16F, 0.28F, 0.56F);
  const LinearRgb horizon(0.62F, 0.70F, 0.80F);
  const LinearRgb sky = Mixed(horizon, zenith, 1.0F - std::exp(-3.2F * height)) + glow * LinearRgb(1.3F, 1.2F, 1.0F);
  const LinearRgb ground = Mixed({0.40F, 0.39F, 0.36F}, {0.26F, 0.25F, 0.22F}, SmoothStep(0.0F, 0.8F, -d.y()));
  return Mixed(ground, sky, SmoothStep(-0.03F, 0.03F, d.y())) + disc * LinearRgb(790.0F, 735.0F, 655.0F);
}

}  // namespace

LinearRgb PresetRadiance(LightPreset preset, const Eigen::Vector3f& direction) {
  switch (preset) {
    case LightPreset::kStudio:
      return StudioRadiance(direction);
    case LightPreset::kShop:
      return ShopRadiance(direction);
    case LightPreset::kDaylight:
      break;
  }
  return DaylightRadiance(direction);
}

}  // namespace annulus
