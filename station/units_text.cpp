#include "station/units_text.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "station/measurement_output.h"

namespace annulus {
namespace {

constexpr double kInch = 25.4;  // mm
constexpr const char* kNone = "–";

/// How numbers of one kind are written: divided by `size`, with so many decimals.
struct Scale {
  double size;
  const char* symbol;
  int value_decimals;
  int half_decimals;
};

Scale ScaleOf(std::string_view unit, LengthUnit length) {
  const bool inch = length == LengthUnit::kInch;
  if (unit == "mm2") return inch ? Scale{kInch * kInch, "in²", 1, 1} : Scale{100.0, "cm²", 1, 1};
  if (unit == "mm3") return inch ? Scale{kInch * kInch * kInch, "in³", 0, 1} : Scale{1e6, "L", 2, 3};
  if (unit == "deg") return {1.0, "°", 1, 1};
  if (inch) return {kInch, "in", 2, 2};
  return length == LengthUnit::kCentimetre ? Scale{10.0, "cm", 1, 2} : Scale{1.0, "mm", 1, 1};
}

std::string Rounded(double number, int decimals) {
  return std::isfinite(number) ? fmt::format("{:.{}f}", number, decimals) : std::string(kNone);
}

/// A half width is never shown as nothing: rounded up to the last decimal shown.
std::string RoundedUp(double half, int decimals) {
  const double step = std::pow(10.0, -decimals);
  return Rounded(std::ceil(half / step - 1e-9) * step + 0.0, decimals);  // + 0.0: never "-0.0"
}

}  // namespace

std::optional<LengthUnit> LengthUnitFromName(std::string_view name) {
  if (name == "mm") return LengthUnit::kMillimetre;
  if (name == "cm") return LengthUnit::kCentimetre;
  if (name == "inch") return LengthUnit::kInch;
  return std::nullopt;
}

std::string InchEighthsText(double mm) {
  const long eighths = std::lround(mm / kInch * 8.0);
  const long whole = std::labs(eighths) / 8;
  long part = std::labs(eighths) % 8;
  long base = 8;
  while (part != 0 && part % 2 == 0) {
    part /= 2;
    base /= 2;
  }
  std::string text = eighths < 0 ? "-" : "";
  if (whole != 0 || part == 0) text += std::to_string(whole);
  if (part != 0) text += fmt::format("{}{}/{}", whole != 0 ? " " : "", part, base);
  return text;
}

ValueText DescribeValue(const Measurement& measurement, LengthUnit unit) {
  const Scale scale = ScaleOf(measurement.unit, unit);
  const double value = measurement.value.value;
  const bool eighths = measurement.unit == "mm" && unit == LengthUnit::kInch && std::isfinite(value);
  return {eighths ? InchEighthsText(value) : Rounded(value / scale.size, scale.value_decimals),
          RoundedUp(HalfWidth95(measurement.value) / scale.size, scale.half_decimals), scale.symbol};
}

}  // namespace annulus
