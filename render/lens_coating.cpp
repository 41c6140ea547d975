#include "render/lens_coating.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/fresnel.h"

namespace annulus {
namespace {

/// Thickness for which LensFinish states its transmittances, mm.
constexpr double kReferenceThickness = 2.0;

/// Fraunhofer's and the mercury and cadmium lines, nm.
constexpr double kLineD = 587.5618;
constexpr double kLineF = 486.1327;
constexpr double kLineC = 656.2725;
constexpr double kLineE = 546.0740;
constexpr double kLineF2 = 479.9914;
constexpr double kLineC2 = 643.8469;

/// What an anti-reflective coat reflects at normal incidence: luminance 0.006.
LinearRgb AntiReflective() { return {0.0042F, 0.0066F, 0.0053F}; }

LinearRgb Coated(const LinearRgb& at_normal, double bare, double index) {
  const double bare_at_normal = std::pow((index - 1.0) / (index + 1.0), 2);
  const auto rise = static_cast<float>(std::clamp((bare - bare_at_normal) / (1.0 - bare_at_normal), 0.0, 1.0));
  return at_normal + rise * (LinearRgb::Ones() - at_normal);
}

double InverseSquare(double wavelength) { return 1.0 / (wavelength * wavelength); }

/// Cauchy's B, nm².
double Steepness(double index, double abbe, double short_line, double long_line) {
  return (index - 1.0) / (abbe * (InverseSquare(short_line) - InverseSquare(long_line)));
}

/// Mean over x0 … x1 of x clamped to 0 … 1.
double MeanOfRamp(double x0, double x1) {
  const double low = std::min(x0, x1);
  const double high = std::max(x0, x1);
  const double from = std::clamp(low, 0.0, 1.0);
  if (!(high > low)) return from;
  const double to = std::clamp(high, 0.0, 1.0);
  const double above = std::max(0.0, high - std::max(low, 1.0));
  return ((to - from) * 0.5 * (to + from) + above) / (high - low);
}

}  // namespace

LensSplit SplitAt(const LensFinish& finish, LensPart part, double cosine, bool entering, double index) {
  const double bare = FresnelReflectance(cosine, entering ? 1.0 / index : index);
  LinearRgb reflected = LinearRgb::Constant(static_cast<float>(bare));
  if (finish.coating != LensCoating::kNone && part != LensPart::kEdge) {
    const bool is_mirror = finish.coating == LensCoating::kMirror && part == LensPart::kFront;
    reflected = Coated(is_mirror ? finish.mirror : AntiReflective(), bare, index);
  }
  return {reflected, LinearRgb::Ones() - reflected};
}

LinearRgb GlassTransmittance(const LensFinish& finish, double from, double to, double length) {
  const double height = finish.gradient_from - finish.gradient_to;
  const double lower =
      height > 0.0 ? MeanOfRamp((finish.gradient_from - from) / height, (finish.gradient_from - to) / height) : 0.0;
  LinearRgb passed;
  for (int channel = 0; channel < 3; ++channel) {
    const double absorbance = (1.0 - lower) * std::log(static_cast<double>(finish.transmittance[channel])) +
                              lower * std::log(static_cast<double>(finish.lower_transmittance[channel]));
    passed[channel] = static_cast<float>(std::exp(absorbance * length / kReferenceThickness));
  }
  return passed;
}

LinearRgb StraightTransmittance(const LensSolid& lens, const LensRay& ray) {
  constexpr int kMostCrossings = 8;
  constexpr double kPast = 1e-9;  // mm; no crossing twice
  LinearRgb passed = LinearRgb::Ones();
  LensRay rest = ray;
  double behind = rest.t_min;
  for (int crossing = 0; crossing < kMostCrossings; ++crossing) {
    const auto next = lens.Next(rest);
    if (!next) break;
    // Both ends of a straight way are met as by the refracted ray: with the cosine in air.
    const double cosine = std::abs(next->normal.dot(ray.direction));
    passed = passed.cwiseProduct(SplitAt(lens.finish(), next->part, cosine, true, lens.index()).passed);
    if (!next->entering) {
      const Eigen::Vector3d entry = ray.origin + behind * ray.direction;
      passed = passed.cwiseProduct(
          GlassTransmittance(lens.finish(), lens.Height(entry), lens.Height(next->point), next->t - behind));
    }
    behind = next->t;
    rest.t_min = next->t + kPast;
    rest.from.reset();
  }
  return passed;
}

double IndexAt(double index_d, double abbe, double wavelength) {
  return index_d + Steepness(index_d, abbe, kLineF, kLineC) * (InverseSquare(wavelength) - InverseSquare(kLineD));
}

DLineGlass FromELine(double index_e, double abbe_e) {
  const double steepness = Steepness(index_e, abbe_e, kLineF2, kLineC2);
  const double index = index_e + steepness * (InverseSquare(kLineD) - InverseSquare(kLineE));
  return {index, (index - 1.0) / (steepness * (InverseSquare(kLineF) - InverseSquare(kLineC)))};
}

WavelengthDraw DrawWavelength(double u) {
  // Raised cosines about the dominant wavelengths of the sRGB primaries, each of mean 1 over the range.
  constexpr double kShortest = 415.0;
  constexpr double kLongest = 685.0;
  constexpr std::array<double, 3> kCentre{612.0, 548.0, 465.0};
  constexpr std::array<double, 3> kHalfWidth{72.0, 66.0, 50.0};
  WavelengthDraw draw;
  draw.wavelength = kShortest + u * (kLongest - kShortest);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const double off = (draw.wavelength - kCentre[channel]) / kHalfWidth[channel];
    const double bump = std::abs(off) < 1.0 ? 0.5 * (1.0 + std::cos(std::numbers::pi * off)) : 0.0;
    draw.weight[static_cast<Eigen::Index>(channel)] =
        static_cast<float>(bump * (kLongest - kShortest) / kHalfWidth[channel]);
  }
  return draw;
}

}  // namespace annulus
