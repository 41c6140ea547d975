#pragma once

#include <compare>
#include <numbers>

namespace annulus {

/// A double that knows what it measures, so that two arguments cannot be swapped. Used by device, plan and
/// configuration interfaces; numeric kernels take plain doubles in mm, rad and s.
template <class Tag>
class Quantity {
 public:
  constexpr Quantity() = default;
  constexpr explicit Quantity(double value) : value_(value) {}
  [[nodiscard]] constexpr double value() const { return value_; }

  constexpr auto operator<=>(const Quantity&) const = default;
  constexpr Quantity operator-() const { return Quantity(-value_); }
  constexpr Quantity operator+(Quantity other) const { return Quantity(value_ + other.value_); }
  constexpr Quantity operator-(Quantity other) const { return Quantity(value_ - other.value_); }
  constexpr Quantity operator*(double factor) const { return Quantity(value_ * factor); }
  constexpr Quantity operator/(double divisor) const { return Quantity(value_ / divisor); }
  constexpr double operator/(Quantity other) const { return value_ / other.value_; }

 private:
  double value_ = 0.0;
};

using Millimetres = Quantity<struct MillimetresTag>;
using Radians = Quantity<struct RadiansTag>;
using Seconds = Quantity<struct SecondsTag>;
using MillimetresPerSecond = Quantity<struct MillimetresPerSecondTag>;
using Hertz = Quantity<struct HertzTag>;

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Degrees to radians; used at the edges only (files, command line, display).
constexpr double RadiansFromDegrees(double degrees) { return degrees * (kPi / 180.0); }
/// Radians to degrees; used at the edges only.
constexpr double DegreesFromRadians(double radians) { return radians * (180.0 / kPi); }

}  // namespace annulus
