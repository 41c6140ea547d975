#include "render/colour_map.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

/// A colour of CIE 1976 L*a*b* in cylindrical form.
struct LabColour {
  double lightness = 0.0;  // 0 … 100
  double chroma = 0.0;
  double hue = 0.0;  // rad
};

/// CIE 15: inverse of L* = 116 f(Y / Yn) - 16 for one ratio.
double RatioFromLab(double f) {
  constexpr double kEdge = 6.0 / 29.0;
  return f > kEdge ? f * f * f : 3.0 * kEdge * kEdge * (f - 4.0 / 29.0);
}

/// L*C*h(ab) under D65 to linear sRGB (IEC 61966-2-1 matrix), clipped to the display's gamut.
LinearRgb LinearFromLab(const LabColour& colour) {
  const double f_y = (colour.lightness + 16.0) / 116.0;
  const double x = 0.95047 * RatioFromLab(f_y + colour.chroma * std::cos(colour.hue) / 500.0);
  const double y = RatioFromLab(f_y);
  const double z = 1.08883 * RatioFromLab(f_y - colour.chroma * std::sin(colour.hue) / 200.0);
  const Eigen::Vector3d rgb(3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                            -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                            0.0556434 * x - 0.2040259 * y + 1.0572252 * z);
  return rgb.cwiseMax(0.0).cwiseMin(1.0).cast<float>();
}

LabColour Diverging(double share) {
  const double from_middle = std::abs(2.0 * share - 1.0);
  const double hue = share < 0.5 ? RadiansFromDegrees(277.0) : RadiansFromDegrees(33.0);
  // Chroma rises quickly, lightness evenly: small residuals are already seen as coloured.
  return {96.0 - 54.0 * from_middle, 52.0 * std::pow(from_middle, 0.8), hue};
}

LabColour Sequential(double share) {
  const double hue = RadiansFromDegrees(305.0 - 205.0 * share);
  return {16.0 + 78.0 * share, 20.0 + 22.0 * std::sin(kPi * (0.15 + 0.7 * share)), hue};
}

}  // namespace

LinearRgb MapColour(ColourMap map, double share) {
  if (std::isnan(share)) return kNoDataColour;
  const double clamped = std::clamp(share, 0.0, 1.0);
  return LinearFromLab(map == ColourMap::kDiverging ? Diverging(clamped) : Sequential(clamped));
}

}  // namespace annulus
