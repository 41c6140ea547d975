#include "render/colour.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>

namespace annulus {
namespace {

constexpr std::size_t kThresholdCount = 255;

/// Entry k is the linear value at which the byte changes from k to k + 1.
std::array<float, kThresholdCount> MakeByteThresholds() {
  std::array<float, kThresholdCount> thresholds{};
  for (std::size_t k = 0; k < kThresholdCount; ++k) {
    thresholds[k] = static_cast<float>(LinearFromSrgb((static_cast<double>(k) + 0.5) / 255.0));
  }
  return thresholds;
}

}  // namespace

double LinearFromSrgb(double encoded) {
  const double value = encoded > 0.0 ? std::min(encoded, 1.0) : 0.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

double SrgbFromLinear(double linear) {
  const double value = linear > 0.0 ? std::min(linear, 1.0) : 0.0;
  return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
}

std::uint8_t SrgbByteFromLinear(float linear) {
  static const std::array<float, kThresholdCount> kThresholds = MakeByteThresholds();
  const float value = linear > 0.0F ? linear : 0.0F;  // nan becomes 0
  const auto above = std::upper_bound(kThresholds.begin(), kThresholds.end(), value);
  return static_cast<std::uint8_t>(above - kThresholds.begin());
}

Result<LinearRgb> ParseHexColour(std::string_view text) {
  const std::string_view digits = text.starts_with('#') ? text.substr(1) : text;
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  if (digits.size() != 6 || error != std::errc() || end != digits.data() + digits.size()) {
    return Fail("read a colour", "'" + std::string(text) + "' is not six hexadecimal digits",
                "write it as #rrggbb, for example #8a5a2b");
  }
  return LinearFromHex(value);
}

LinearRgb LinearFromHex(std::uint32_t rrggbb) {
  const auto component = [rrggbb](unsigned shift) {
    return static_cast<float>(LinearFromSrgb(static_cast<double>((rrggbb >> shift) & 0xFFU) / 255.0));
  };
  return {component(16), component(8), component(0)};
}

}  // namespace annulus
