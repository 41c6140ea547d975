#include "modeling/measure/systematic.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/ensure.h"
#include "base/frames.h"

namespace annulus {
namespace {

/// The height at which coefficient j of a clamped cubic spline stands: the mean of its three inner knots.
std::vector<double> GrevilleHeights(const ClampedCubicBasis& basis) {
  const std::vector<double>& breaks = basis.breakpoints();
  const auto knot = [&](std::size_t k) {  // without the outermost of either end
    return breaks[std::min(k < 2 ? 0 : k - 2, breaks.size() - 1)];
  };
  std::vector<double> heights;
  for (std::size_t j = 0; j < basis.count(); ++j) heights.push_back((knot(j) + knot(j + 1) + knot(j + 2)) / 3.0);
  return heights;
}

/// The number's derivatives with respect to the errors: columns gather the coefficients' derivatives.
struct Sensitivity {
  Eigen::VectorXd theta;       ///< By a radius offset at each theta knot.
  double height_scale = 0.0;   ///< By a relative error of heights.
  double height_offset = 0.0;  ///< By an error common to all heights.
  std::vector<double> row_z;   ///< Heights of the rows of coefficients that matter, mm.
  std::vector<double> x;       ///< By a displacement along x of each of these rows.
  std::vector<double> y;       ///< By a displacement along y.
  std::vector<double> lean_x;  ///< By a lean along x, per rad: what lies in front of the axis goes down.
  std::vector<double> lean_y;
  std::vector<double> yaw;  ///< By a turn about the ring's axis, per rad.
};

Sensitivity Gather(const SplineSurface& surface, const Gradient& gradient) {
  const std::size_t width = surface.theta_basis().count();
  const std::vector<double> heights = GrevilleHeights(surface.z_basis());
  Sensitivity s;
  s.theta = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(width));
  std::size_t last_row = heights.size();
  for (Gradient::InnerIterator entry(gradient); entry; ++entry) {
    const auto index = static_cast<std::size_t>(entry.index());
    const std::size_t row = index / width;
    const double theta = surface.theta_basis().spacing() * static_cast<double>(index % width);
    const double z = heights[row];
    if (row != last_row) {
      s.row_z.push_back(z);
      for (std::vector<double>* by : {&s.x, &s.y, &s.lean_x, &s.lean_y, &s.yaw}) by->push_back(0.0);
      last_row = row;
    }
    const RadiusJet jet = surface.Jet(theta, z);
    const double by_c = entry.value();
    s.theta[static_cast<Eigen::Index>(index % width)] += by_c;
    s.height_scale -= by_c * jet.r_z * z;
    s.height_offset -= by_c * jet.r_z;
    const double slope = jet.r > 0.0 ? jet.r_theta / jet.r : 0.0;  // on the axis a level has no tangential direction
    s.x.back() += by_c * (std::cos(theta) + slope * std::sin(theta));
    s.y.back() += by_c * (std::sin(theta) - slope * std::cos(theta));
    s.lean_x.back() += by_c * jet.r_z * jet.r * std::cos(theta);
    s.lean_y.back() += by_c * jet.r_z * jet.r * std::sin(theta);
    s.yaw.back() -= by_c * jet.r_theta;
  }
  return s;
}

/// From derivatives by offsets at theta knots to derivatives by the offsets of n directions. A knot takes the offsets
/// by a hat as wide as the larger of both spacings: linear interpolation, or a mean.
Eigen::VectorXd ByDirection(const Eigen::VectorXd& by_knot, Eigen::Index directions) {
  const double step = kTwoPi / static_cast<double>(directions);
  const double spacing = kTwoPi / static_cast<double>(by_knot.size());
  const double reach = std::max(step, spacing) / step;  // in directions
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(directions);
  std::vector<std::pair<Eigen::Index, double>> weights;
  for (Eigen::Index knot = 0; knot < by_knot.size(); ++knot) {
    const double centre = static_cast<double>(knot) * spacing / step;
    weights.clear();
    double total = 0.0;
    for (double k = std::ceil(centre - reach); k <= centre + reach; k += 1.0) {
      const double weight = std::max(0.0, 1.0 - std::abs(k - centre) / reach);
      const auto direction = static_cast<Eigen::Index>(k) % directions;
      weights.emplace_back(direction < 0 ? direction + directions : direction, weight);
      total += weight;
    }
    for (const auto& [direction, weight] : weights) sum[direction] += by_knot[knot] * weight / total;
  }
  return sum;
}

double CalibrationVariance(const CalibrationErrors& errors, const Sensitivity& s) {
  const Eigen::VectorXd by = ByDirection(s.theta, errors.offset_covariance.rows());
  const double scale = s.height_scale * errors.height_scale_sigma;
  const double offset = s.height_offset * errors.height_offset_sigma;
  return by.dot(errors.offset_covariance * by) + scale * scale + offset * offset;
}

/// By the displacements at the sway's heights, in the order of its covariance: linear between two heights.
double FullSwayVariance(const SwayErrors& sway, const Sensitivity& s) {
  constexpr double kLowest = 100.0;  // mm: below it a section hardly moves, and its lean is not d/z
  const auto n = static_cast<Eigen::Index>(sway.heights.size());
  Eigen::VectorXd by = Eigen::VectorXd::Zero(3 * n);
  for (std::size_t row = 0; row < s.row_z.size(); ++row) {
    const double z = s.row_z[row];
    const auto above = std::upper_bound(sway.heights.begin() + 1, sway.heights.end() - 1, z);
    const double low = *(above - 1);
    const double share = std::clamp((z - low) / (*above - low), 0.0, 1.0);
    const Eigen::Index k = (above - sway.heights.begin()) - 1;
    const double lean = 1.0 / std::max(z, kLowest);
    const Eigen::Vector3d motion(s.x[row] + lean * s.lean_x[row], s.y[row] + lean * s.lean_y[row], s.yaw[row]);
    for (Eigen::Index a = 0; a < 3; ++a) {
      by[a * n + k] += (1.0 - share) * motion[a];
      by[a * n + k + 1] += share * motion[a];
    }
  }
  return by.dot(sway.covariance * by);
}

double SwayVariance(const SwayErrors& sway, const Sensitivity& s) {
  if (sway.full()) return FullSwayVariance(sway, s);
  double x = 0.0;
  double y = 0.0;
  for (std::size_t a = 0; a < s.row_z.size(); ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      const double distance = (s.row_z[a] - s.row_z[b]) / sway.correlation_length;
      const double together = (a == b ? 1.0 : 2.0) * std::exp(-0.5 * distance * distance);
      x += together * s.x[a] * s.x[b];
      y += together * s.y[a] * s.y[b];
    }
  }
  return sway.sigma_x * sway.sigma_x * x + sway.sigma_y * sway.sigma_y * y;
}

/// Takes from derivatives by the rows' displacements what a common displacement would do, from each as it is large.
void TakeOutCommon(std::vector<double>& by) {
  double sum = 0.0;
  double size = 0.0;
  for (const double derivative : by) {
    sum += derivative;
    size += std::abs(derivative);
  }
  if (!(size > 0.0)) return;
  for (double& derivative : by) derivative -= sum * std::abs(derivative) / size;
}

/// Rounding may leave a variance of 0 a little below it.
double Sigma(double variance) { return std::sqrt(std::max(0.0, variance)); }

SystematicSigmas SigmasOf(const SystematicErrors& errors, const Sensitivity& s) {
  SystematicSigmas sigmas;
  if (errors.calibration) sigmas.calibration = Sigma(CalibrationVariance(*errors.calibration, s));
  if (errors.sway) sigmas.sway = Sigma(SwayVariance(*errors.sway, s));
  return sigmas;
}

}  // namespace

SystematicSigmas SigmasFrom(const SystematicErrors& errors, const MeasuredSurface& body, const Estimate& estimate) {
  if (estimate.gradient.size() == 0) return {};
  ENSURE(estimate.gradient.size() == body.surface().coefficients().size(), "the gradient is by this surface");
  const Sensitivity s = Gather(body.surface(), estimate.gradient);
  return SigmasOf(errors, s);
}

SystematicSigmas SigmasOfInvariant(const SystematicErrors& errors, const MeasuredSurface& body,
                                   const Estimate& estimate) {
  if (estimate.gradient.size() == 0) return {};
  ENSURE(estimate.gradient.size() == body.surface().coefficients().size(), "the gradient is by this surface");
  Sensitivity s = Gather(body.surface(), estimate.gradient);
  if (errors.sway && errors.sway->full()) {
    for (std::vector<double>* by : {&s.x, &s.y, &s.yaw}) TakeOutCommon(*by);
  }
  return SigmasOf(errors, s);
}

}  // namespace annulus
