#include "render/hvc.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Where CIE continues the cube root by its tangent, as a cube root: (6/29)³ = 0.00886.
constexpr double kTangentFrom = 6.0 / 29.0;
/// A channel may leave 0 … 1 by this and still be shown.
constexpr double kGamutSlack = 1.0e-7;
/// Below it a colour has no hue.
constexpr double kGreyChroma = 1.0e-3;

double Adams(double a) {
  const double root = a > kTangentFrom * kTangentFrom * kTangentFrom
                          ? std::cbrt(a)
                          : a / (3.0 * kTangentFrom * kTangentFrom) + 4.0 / 29.0;
  return 11.6 * root - 1.6;
}

double FromAdams(double v) {
  const double root = (v + 1.6) / 11.6;
  return root > kTangentFrom ? root * root * root : 3.0 * kTangentFrom * kTangentFrom * (root - 4.0 / 29.0);
}

/// Linear sRGB to X, Y, Z over those of white under illuminant C. Rows sum to 1.
const Matrix3d& WhiteRelativeXyz() {
  static const Matrix3d kMatrix = [] {
    Matrix3d xyz;  // IEC 61966-2-1
    xyz << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
    Matrix3d cone;  // Bradford's
    cone << 0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296;
    const Vector3d white = xyz * Vector3d::Ones();
    const Vector3d white_c(0.31006 / 0.31616, 1.0, (1.0 - 0.31006 - 0.31616) / 0.31616);
    const Vector3d gain = (cone * white_c).cwiseQuotient(cone * white);
    Matrix3d relative = white_c.cwiseInverse().asDiagonal() * cone.inverse() * gain.asDiagonal() * cone * xyz;
    // To the last bit, so that greys have no chroma.
    for (int row = 0; row < 3; ++row) relative.row(row) /= relative.row(row).sum();
    return relative;
  }();
  return kMatrix;
}

const Matrix3d& RgbFromWhiteRelativeXyz() {
  static const Matrix3d kMatrix = WhiteRelativeXyz().inverse();
  return kMatrix;
}

/// S of a unit vector (cos θ, sin θ); S of M is |M| times it.
Vector2d StretchOf(double theta) {
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  return {(8.880 + 0.966 * c) * c, (8.025 + 2.558 * s) * s};
}
Vector2d StretchSlope(double theta) {
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  return {-s * (8.880 + 2.0 * 0.966 * c), c * (8.025 + 2.0 * 2.558 * s)};
}

/// The angle θ at which the stretch points to `angle` (rad, −π … π). Both factors of the stretch are positive, so θ
/// lies in the same quadrant: Newton's method, halving the quadrant where a step would leave what is left of it.
double UnstretchedAngle(double angle) {
  const double quarter = 0.5 * kPi;
  double low = quarter * std::floor(angle / quarter);
  double high = low + quarter;
  const Vector2d wanted(std::cos(angle), std::sin(angle));
  const auto across = [&wanted](const Vector2d& s) { return wanted.x() * s.y() - wanted.y() * s.x(); };
  double theta = angle;
  for (int k = 0; k < 60; ++k) {
    const double miss = across(StretchOf(theta));
    if (miss == 0.0) break;
    (miss > 0.0 ? high : low) = theta;
    double next = theta - miss / across(StretchSlope(theta));
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const bool settled = std::abs(next - theta) <= 1e-15;
    theta = next;
    if (settled) break;
  }
  return theta;
}

Vector3d RgbOf(const Hvc& hvc) {
  const double angle = std::atan2(-std::sin(hvc.hue), std::cos(hvc.hue));
  const double theta = UnstretchedAngle(angle);
  const double length = hvc.chroma / StretchOf(theta).norm();
  const double m1 = length * std::cos(theta);
  const double m2 = length * std::sin(theta);
  return RgbFromWhiteRelativeXyz() *
         Vector3d(FromAdams(hvc.value + m1), FromAdams(hvc.value), FromAdams(hvc.value + m2 / 0.4));
}

bool IsShown(const Vector3d& rgb) { return rgb.minCoeff() >= -kGamutSlack && rgb.maxCoeff() <= 1.0 + kGamutSlack; }

LinearRgb Held(const Vector3d& rgb) { return rgb.cwiseMax(0.0).cwiseMin(1.0).cast<float>(); }

/// Round the six edges of the colour cube from red over yellow, green, cyan, blue, magenta; `place` 0 … 6.
Vector3d CubeEdge(double place) {
  static const std::array<Vector3d, 7> kCorners = {Vector3d(1, 0, 0), Vector3d(1, 1, 0), Vector3d(0, 1, 0),
                                                   Vector3d(0, 1, 1), Vector3d(0, 0, 1), Vector3d(1, 0, 1),
                                                   Vector3d(1, 0, 0)};
  const auto edge = static_cast<std::size_t>(std::clamp(place, 0.0, 5.999999));
  const double share = std::clamp(place - static_cast<double>(edge), 0.0, 1.0);
  return (1.0 - share) * kCorners[edge] + share * kCorners[edge + 1];
}

/// Turned to 0 … 2π.
double Turned(double angle) {
  const double turned = std::fmod(angle, 2.0 * kPi);
  return turned < 0.0 ? turned + 2.0 * kPi : turned;
}

}  // namespace

Hvc HvcFromRgb(const LinearRgb& colour) {
  const Vector3d xyz = WhiteRelativeXyz() * colour.cast<double>();
  const double value = Adams(xyz.y());
  const double m1 = Adams(xyz.x()) - value;
  const double m2 = 0.4 * (Adams(xyz.z()) - value);
  const double length = std::hypot(m1, m2);
  if (!(length > 0.0)) return {0.0, value, 0.0};
  const double s1 = (8.880 + 0.966 * m1 / length) * m1;
  const double s2 = (8.025 + 2.558 * m2 / length) * m2;
  return {Turned(std::atan2(-s2, s1)), value, std::hypot(s1, s2)};
}

LinearRgb RgbFromHvc(const Hvc& hvc) { return RgbOf(hvc).cast<float>(); }

double GreatestChroma(double hue, double value) {
  if (!(value > 0.0 && value < 10.0)) return 0.0;
  double inside = 0.0;
  double outside = 60.0;
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (inside + outside);
    (IsShown(RgbOf({hue, value, middle})) ? inside : outside) = middle;
  }
  return inside;
}

LinearRgb ShownRgb(const Hvc& hvc) {
  const Hvc held{hvc.hue, std::clamp(hvc.value, 0.0, 10.0), std::max(0.0, hvc.chroma)};
  const Vector3d rgb = RgbOf(held);
  if (IsShown(rgb)) return Held(rgb);
  return Held(RgbOf({held.hue, held.value, std::min(held.chroma, GreatestChroma(held.hue, held.value))}));
}

LinearRgb Brightened(const LinearRgb& colour, double share) {
  ENSURE(share >= -1.0 && share <= 1.0, "a share of -1 … 1");
  if (share == 0.0) return colour;
  Hvc hvc = HvcFromRgb(colour);
  hvc.value += share * (share > 0.0 ? 10.0 - hvc.value : hvc.value);
  return ShownRgb(hvc);
}

LinearRgb Vivified(const LinearRgb& colour, double share) {
  ENSURE(share >= -1.0 && share <= 1.0, "a share of -1 … 1");
  Hvc hvc = HvcFromRgb(colour);
  if (share == 0.0 || hvc.chroma < kGreyChroma) return colour;
  const double room = share < 0.0 ? hvc.chroma : std::max(0.0, GreatestChroma(hvc.hue, hvc.value) - hvc.chroma);
  hvc.chroma += share * room;
  return ShownRgb(hvc);
}

LinearRgb PureColour(double hue) {
  const auto hue_at = [](double place) { return HvcFromRgb(CubeEdge(place).cast<float>()).hue; };
  const double start = hue_at(0.0);
  const double wanted = Turned(hue - start);
  double low = 0.0;
  double high = 6.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (Turned(hue_at(middle) - start) < wanted ? low : high) = middle;
  }
  return Held(CubeEdge(0.5 * (low + high)));
}

std::string MunsellText(const Hvc& hvc) {
  static constexpr std::array<std::string_view, 10> kNames = {"R", "YR", "Y", "GY", "G", "BG", "B", "PB", "P", "RP"};
  std::array<char, 64> text{};
  if (!(hvc.chroma >= 0.15)) {
    std::snprintf(text.data(), text.size(), "N %.1f", hvc.value);
    return text.data();
  }
  const double steps = Turned(hvc.hue) * 50.0 / kPi;
  auto family = static_cast<std::size_t>(steps / 10.0) % kNames.size();
  double within = std::round((steps - 10.0 * std::floor(steps / 10.0)) * 10.0) / 10.0;
  if (within == 0.0) {  // 0 of a family is written as 10 of the one before
    family = (family + kNames.size() - 1) % kNames.size();
    within = 10.0;
  }
  std::snprintf(text.data(), text.size(), "%.1f%s %.1f/%.1f", within, std::string(kNames[family]).c_str(), hvc.value,
                hvc.chroma);
  return text.data();
}

}  // namespace annulus
