#include "render/tone.h"

#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

constexpr float kKnee = 0.75F;
constexpr float kRoom = 1.0F - kKnee;

float BeforeSoftLimit(float limited) {
  constexpr float kLargest = 0.9999F;
  if (limited <= kKnee) return limited;
  return kKnee - kRoom * std::log(1.0F - (std::min(limited, kLargest) - kKnee) / kRoom);
}

}  // namespace

float SoftLimit(float value) {
  return value <= kKnee ? value : kKnee + kRoom * (1.0F - std::exp((kKnee - value) / kRoom));
}

LinearRgb SoftLimit(const LinearRgb& light) { return {SoftLimit(light[0]), SoftLimit(light[1]), SoftLimit(light[2])}; }

LinearRgb BeforeSoftLimit(const LinearRgb& limited) {
  return {BeforeSoftLimit(limited[0]), BeforeSoftLimit(limited[1]), BeforeSoftLimit(limited[2])};
}

}  // namespace annulus
