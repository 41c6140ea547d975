#include "render/studio.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

/// A rectangular lamp with a diffuser in front.
struct Softbox {
  Eigen::Vector3f direction;  // unit, to its middle
  Eigen::Vector3f right;      // unit, along its width
  Eigen::Vector3f up;         // unit, along its height
  float half_width = 0.0F;    // tangent of half the angle
  float half_height = 0.0F;
  LinearRgb radiance;
};

Softbox MakeSoftbox(const Eigen::Vector3f& towards, const Eigen::Vector2f& half_size, const LinearRgb& radiance) {
  const Eigen::Vector3f direction = towards.normalized();
  const Eigen::Vector3f right = Eigen::Vector3f(0.0F, 1.0F, 0.02F).cross(direction).normalized();
  return {direction, right, direction.cross(right), half_size.x(), half_size.y(), radiance};
}

float SmoothStep(float from, float to, float value) {
  const float t = std::clamp((value - from) / (to - from), 0.0F, 1.0F);
  return t * t * (3.0F - 2.0F * t);
}

/// 1 inside |position| < half, falling to 0 over `blur` on both sides of the edge.
float SoftSlab(float position, float half, float blur) {
  return 1.0F - SmoothStep(half - blur, half + blur, std::abs(position));
}

}  // namespace

const std::array<DirectionalLight, 3>& StudioLights() {
  static const std::array<DirectionalLight, 3> kLights = {{
      {Eigen::Vector3f(-0.66F, 0.52F, 0.54F).normalized(), LinearRgb(1.06F, 1.01F, 0.94F)},
      {Eigen::Vector3f(0.80F, 0.12F, 0.55F).normalized(), LinearRgb(0.15F, 0.165F, 0.19F)},
      {Eigen::Vector3f(0.62F, 0.42F, -0.66F).normalized(), LinearRgb(0.42F, 0.45F, 0.50F)},
  }};
  return kLights;
}

LinearRgb StudioAmbient(const Eigen::Vector3f& normal) {
  static const LinearRgb kCeiling(0.24F, 0.25F, 0.265F);
  static const LinearRgb kFloor(0.065F, 0.06F, 0.056F);
  const float up = 0.5F + 0.5F * normal.y();
  return kFloor + up * (kCeiling - kFloor);
}

LinearRgb StudioLamps(const Eigen::Vector3f& direction, float roughness) {
  static const std::array<Softbox, 4> kLamps = {
      MakeSoftbox({-0.62F, 0.52F, 0.58F}, {0.42F, 0.52F}, {3.2F, 3.1F, 2.95F}),
      MakeSoftbox({0.86F, 0.10F, 0.50F}, {0.13F, 0.70F}, {1.5F, 1.6F, 1.75F}),
      MakeSoftbox({0.05F, 0.97F, 0.25F}, {0.70F, 0.28F}, {1.7F, 1.7F, 1.7F}),
      MakeSoftbox({0.62F, 0.42F, -0.66F}, {0.35F, 0.60F}, {1.8F, 1.9F, 2.0F}),
  };
  const float blur = 0.03F + 0.6F * roughness;
  LinearRgb sum = LinearRgb::Zero();
  for (const Softbox& lamp : kLamps) {
    const float along = direction.dot(lamp.direction);
    if (along <= 0.1F) continue;
    const float shape = SoftSlab(direction.dot(lamp.right) / along, lamp.half_width, blur) *
                        SoftSlab(direction.dot(lamp.up) / along, lamp.half_height, blur);
    // A blurred lamp is larger but dimmer.
    const float dimmed =
        lamp.half_width * lamp.half_height / ((lamp.half_width + 0.5F * blur) * (lamp.half_height + 0.5F * blur));
    if (shape > 0.0F) sum += shape * dimmed * lamp.radiance;
  }
  return sum;
}

LinearRgb StudioWalls(const Eigen::Vector3f& direction, float roughness) {
  static const LinearRgb kCeiling(0.62F, 0.64F, 0.67F);
  static const LinearRgb kFloor(0.20F, 0.185F, 0.17F);
  const float blur = 0.18F + 0.8F * roughness;
  const float up = SmoothStep(-blur, blur, direction.y() - 0.05F);
  // A dark strip at the horizon gives metal its contrast.
  const float at_horizon = direction.y() / (0.22F + roughness);
  const float strip = 0.75F * (1.0F - std::min(roughness, 1.0F)) * std::max(0.0F, 1.0F - at_horizon * at_horizon);
  return (kFloor + up * (kCeiling - kFloor)) * (1.0F - strip);
}

}  // namespace annulus
