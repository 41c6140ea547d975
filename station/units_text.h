#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "modeling/table/table.h"

namespace annulus {

/// The unit in which a customer reads lengths. Files are always in millimetres.
enum class LengthUnit { kMillimetre, kCentimetre, kInch };

/// "mm", "cm" or "inch"; nothing for other names.
[[nodiscard]] std::optional<LengthUnit> LengthUnitFromName(std::string_view name);

/// Inches in whole eighths, rounded to the nearest: "33 3/8", "1/2", "-7", "0".
[[nodiscard]] std::string InchEighthsText(double mm);

/// A measurement as a person reads it.
struct ValueText {
  std::string value;   ///< "846.2", "84.6", "33 3/8"; "–" where it is not finite.
  std::string half95;  ///< Half width of its 95 % interval, in decimals of the same unit; "–" where it is not known.
  std::string unit;    ///< "mm", "cm", "in", "cm²", "in²", "L", "in³", "°".
};

/// The measurement in `unit`: lengths to 0.1 mm, 1 mm or an eighth of an inch; areas in cm² or in², volumes in litres
/// or in³, angles in degrees.
[[nodiscard]] ValueText DescribeValue(const Measurement& measurement, LengthUnit unit);

}  // namespace annulus
