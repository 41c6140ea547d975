#include "modeling/glasses/prescription.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

constexpr const char* kAttempt = "use the prescription";
constexpr const char* kAdvice = "ask the prescriber; nothing is made from an order in doubt";
constexpr std::size_t kLongestName = 200;

/// The double nearest to `value` as a decimal of six places, so that sums of decimals are decimals again.
double SixDecimals(double value) { return std::round(value * 1e6) / 1e6; }

tl::unexpected<Error> Refuse(std::string seen) { return Fail(kAttempt, std::move(seen), kAdvice); }

struct Range {
  const char* unit;
  double low;
  double high;
};
constexpr Range kSphere{"D", -30.0, 30.0};
constexpr Range kCylinder{"D", -15.0, 15.0};
constexpr Range kAxis{"°", 0.0, 180.0};
constexpr Range kAdd{"D", 0.25, 4.0};
constexpr Range kPd{"mm", 20.0, 45.0};
constexpr Range kHeight{"mm", 5.0, 60.0};
constexpr Range kRefractedVertex{"mm", 5.0, 25.0};
constexpr double kLargestPrism = 20.0;  // cm/m

Status InRange(const std::string& what, double value, const Range& range) {
  if (value >= range.low && value <= range.high) return {};  // NaN is not
  return Refuse(
      fmt::format("{} is {} {}, outside {} to {} {}", what, value, range.unit, range.low, range.high, range.unit));
}

Status InRange(const std::string& what, const std::optional<double>& value, const Range& range) {
  return value ? InRange(what, *value, range) : Status{};
}

Status ValidatePower(const EyePrescription& order, const std::string& eye) {
  RETURN_IF_ERROR(InRange(eye + " SPH", order.sphere, kSphere));
  RETURN_IF_ERROR(InRange(eye + " CYL", order.cylinder, kCylinder));
  RETURN_IF_ERROR(InRange(eye + " SPH + CYL", order.sphere + order.cylinder, kSphere));
  if (order.cylinder != 0.0 && !order.axis_deg) {
    return Refuse(fmt::format("{} CYL is {} D but it has no axis", eye, order.cylinder));
  }
  RETURN_IF_ERROR(InRange(eye + " axis", order.axis_deg, kAxis));
  return InRange(eye + " ADD", order.add, kAdd);
}

Status ValidateEye(const EyePrescription& order, const std::string& eye) {
  RETURN_IF_ERROR(ValidatePower(order, eye));
  const double prism = std::hypot(order.prism.in, order.prism.up);
  if (!(prism <= kLargestPrism)) {
    return Refuse(fmt::format("{} prism is {} cm/m, above {} cm/m", eye, prism, kLargestPrism));
  }
  RETURN_IF_ERROR(InRange(eye + " PD", order.pd, kPd));
  return InRange(eye + " fitting height", order.height, kHeight);
}

bool AllDigits(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

Status ValidateDate(const std::string& date) {
  const bool shaped = date.size() == 10 && date[4] == '-' && date[7] == '-' && AllDigits(date.substr(0, 4)) &&
                      AllDigits(date.substr(5, 2)) && AllDigits(date.substr(8, 2));
  if (!shaped) return Refuse(fmt::format("the date '{}' is not written YYYY-MM-DD", date.substr(0, 40)));
  const int year = std::stoi(date.substr(0, 4));
  const int month = std::stoi(date.substr(5, 2));
  const int day = std::stoi(date.substr(8, 2));
  const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  const std::array<int, 12> days{31, leap ? 29 : 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  const bool exists = year >= 1900 && year <= 2200 && month >= 1 && month <= 12 && day >= 1 &&
                      day <= days[static_cast<std::size_t>(month - 1)];
  if (!exists) return Refuse(fmt::format("the date {} does not exist between 1900 and 2200", date));
  return {};
}

}  // namespace

Prism PrismFromBase(double magnitude, double base_deg, Eye eye) {
  const double base = RadiansFromDegrees(base_deg);
  const double towards_left = SixDecimals(magnitude * std::cos(base));  // the viewer's right is the wearer's left
  return {eye == Eye::kRight ? towards_left : -towards_left, SixDecimals(magnitude * std::sin(base))};
}

Status Validate(const Prescription& prescription) {
  RETURN_IF_ERROR(ValidateEye(prescription.right, "right"));
  RETURN_IF_ERROR(ValidateEye(prescription.left, "left"));
  RETURN_IF_ERROR(ValidateDate(prescription.date));
  if (prescription.prescriber.empty() || prescription.prescriber.size() > kLongestName) {
    return Refuse(
        fmt::format("the prescriber's name has {} bytes, not 1 to {}", prescription.prescriber.size(), kLongestName));
  }
  if (prescription.centration_confirmed_by.size() > kLongestName) {
    return Refuse(fmt::format("the name of who confirmed the centration has {} bytes, more than {}",
                              prescription.centration_confirmed_by.size(), kLongestName));
  }
  return InRange("the vertex distance of the refraction", prescription.refracted_vertex, kRefractedVertex);
}

EyePrescription Transposed(const EyePrescription& order) {
  if (order.cylinder == 0.0) return order;
  EyePrescription transposed = order;
  transposed.sphere = SixDecimals(order.sphere + order.cylinder);
  transposed.cylinder = -order.cylinder;
  const double axis = order.axis_deg.value_or(180.0);
  transposed.axis_deg = SixDecimals(axis > 90.0 ? axis - 90.0 : axis + 90.0);
  return transposed;
}

EyePrescription InMinusCylinder(const EyePrescription& order) {
  return order.cylinder > 0.0 ? Transposed(order) : order;
}

EyePrescription InPlusCylinder(const EyePrescription& order) {
  return order.cylinder < 0.0 ? Transposed(order) : order;
}

Prescription WithMeasuredPupils(const Prescription& prescription, const MeasuredPupil& right,
                                const MeasuredPupil& left) {
  Prescription filled = prescription;
  const auto fill = [&filled](EyePrescription& order, const MeasuredPupil& pupil) {
    if (order.pd && order.height) return;
    if (!order.pd) order.pd = pupil.pd;
    if (!order.height) order.height = pupil.height;
    filled.centration_confirmed_by.clear();
  };
  fill(filled.right, right);
  fill(filled.left, left);
  return filled;
}

}  // namespace annulus
