#include "modeling/landmarks/level_vertex.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/ensure.h"
#include "base/frames.h"

namespace annulus {
namespace {

constexpr double kStep = 2.5;  // mm between the heights looked at
constexpr std::size_t kNodes = 9;

/// Node k of a window, -1 … 1.
double Node(std::size_t k) { return -1.0 + 2.0 * static_cast<double>(k) / static_cast<double>(kNodes - 1); }

/// Weighted sum of a function over the nodes of a window.
HeightFunction Weighted(const HeightFunction& function, double half, const std::array<double, kNodes>& weights) {
  return {[function, half, weights](double z) {
            double sum = 0.0;
            for (std::size_t k = 0; k < kNodes; ++k) {
              if (weights[k] != 0.0) sum += weights[k] * function.value(z + half * Node(k));
            }
            return sum;
          },
          [function, half, weights](double z, double weight, GradientSum& sum) {
            for (std::size_t k = 0; k < kNodes; ++k) {
              if (weights[k] != 0.0) function.add_gradient(z + half * Node(k), weight * weights[k], sum);
            }
          }};
}

bool Crosses(double below, double above, Crossing crossing) {
  if (crossing != Crossing::kFalling && below <= 0.0 && above > 0.0) return true;
  return crossing != Crossing::kRising && below >= 0.0 && above < 0.0;
}

/// Root of value - target in [low, high] with different signs at the ends: the Illinois variant of regula falsi.
double Root(const std::function<double(double)>& excess, double low, double high) {
  double at_low = excess(low);
  double at_high = excess(high);
  if (at_low == 0.0) return low;
  for (int k = 0; k < 60 && high - low > 1e-9; ++k) {
    const double secant = (low * at_high - high * at_low) / (at_high - at_low);
    const double z = secant > low && secant < high ? secant : 0.5 * (low + high);
    const double at_z = excess(z);
    if (at_z == 0.0) return z;
    if ((at_z > 0.0) == (at_high > 0.0)) {
      high = z;
      at_high = at_z;
      at_low *= 0.5;
    } else {
      low = z;
      at_low = at_z;
      at_high *= 0.5;
    }
  }
  return std::abs(at_low) < std::abs(at_high) ? low : high;
}

}  // namespace

HeightFunction TapeOver(const SectionSampler& sampler) {
  return {[sampler](double z) { return TapeLength(sampler.Points(z)); },
          [sampler](double z, double weight, GradientSum& sum) {
            const std::vector<Eigen::Vector2d> points = sampler.Points(z);
            const std::vector<std::size_t> hull = HullOfSection(points);
            for (std::size_t k = 0; k < hull.size(); ++k) {
              const std::size_t at = hull[k];
              const Eigen::Vector2d before = points[at] - points[hull[(k + hull.size() - 1) % hull.size()]];
              const Eigen::Vector2d after = points[at] - points[hull[(k + 1) % hull.size()]];
              const double theta = sampler.directions()[at];
              const Eigen::Vector2d outward(std::cos(theta), std::sin(theta));
              sum.AddRadius(theta, z, weight * outward.dot(before.normalized() + after.normalized()));
            }
          }};
}

HeightFunction ReachOver(const SectionSampler& sampler, double toward, double half_sector) {
  std::vector<double> sector;
  for (const double theta : sampler.directions()) {
    if (std::abs(AngleDifference(theta, toward)) <= half_sector) sector.push_back(theta);
  }
  ENSURE(!sector.empty(), "an outline is seen somewhere");
  // A sampler wants three directions; doubled ones change no largest value.
  while (sector.size() < 3) sector.push_back(sector.back());
  const SectionSampler within(sampler.surface(), std::move(sector));
  const Eigen::Vector2d direction(std::cos(toward), std::sin(toward));
  return {[within, direction](double z) {
            double reach = -std::numeric_limits<double>::infinity();
            for (const Eigen::Vector2d& p : within.Points(z)) reach = std::max(reach, p.dot(direction));
            return reach;
          },
          [within, direction](double z, double weight, GradientSum& sum) {
            const std::vector<Eigen::Vector2d> points = within.Points(z);
            const auto farthest =
                std::max_element(points.begin(), points.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
                  return a.dot(direction) < b.dot(direction);
                });
            const double theta = within.directions()[static_cast<std::size_t>(farthest - points.begin())];
            sum.AddRadius(theta, z, weight * Eigen::Vector2d(std::cos(theta), std::sin(theta)).dot(direction));
          }};
}

HeightFunction SumOf(const HeightFunction& a, const HeightFunction& b) {
  return {[a, b](double z) { return a.value(z) + b.value(z); },
          [a, b](double z, double weight, GradientSum& sum) {
            a.add_gradient(z, weight, sum);
            b.add_gradient(z, weight, sum);
          }};
}

HeightFunction SlopeOf(const HeightFunction& function, double half) {
  double squares = 0.0;
  for (std::size_t k = 0; k < kNodes; ++k) squares += Node(k) * Node(k);
  std::array<double, kNodes> weights{};
  for (std::size_t k = 0; k < kNodes; ++k) weights[k] = Node(k) / (squares * half);
  return Weighted(function, half, weights);
}

HeightFunction TangentOf(const HeightFunction& function, double half) {
  // Normal equations of the odd terms s, s³; the even ones do not matter to the slope at s = 0.
  double second = 0.0;
  double fourth = 0.0;
  double sixth = 0.0;
  for (std::size_t k = 0; k < kNodes; ++k) {
    second += std::pow(Node(k), 2);
    fourth += std::pow(Node(k), 4);
    sixth += std::pow(Node(k), 6);
  }
  const double determinant = second * sixth - fourth * fourth;
  std::array<double, kNodes> weights{};
  for (std::size_t k = 0; k < kNodes; ++k) {
    weights[k] = (sixth * Node(k) - fourth * std::pow(Node(k), 3)) / (determinant * half);
  }
  return Weighted(function, half, weights);
}

HeightFunction BendOf(const HeightFunction& function, double half) {
  // The parabola's highest coefficient is that of the orthogonal polynomial s² - mean(s²); twice it, over half².
  double mean = 0.0;
  for (std::size_t k = 0; k < kNodes; ++k) mean += Node(k) * Node(k) / static_cast<double>(kNodes);
  double squares = 0.0;
  for (std::size_t k = 0; k < kNodes; ++k) squares += std::pow(Node(k) * Node(k) - mean, 2);
  std::array<double, kNodes> weights{};
  for (std::size_t k = 0; k < kNodes; ++k) {
    weights[k] = 2.0 * (Node(k) * Node(k) - mean) / (squares * half * half);
  }
  return Weighted(function, half, weights);
}

std::optional<Estimate> FindCrossing(const SplineSurface& surface, const HeightFunction& function,
                                     const LevelQuery& query) {
  const auto excess = [&](double z) { return function.value(z) - query.value; };
  const double toward = query.to < query.from ? -1.0 : 1.0;
  const auto steps = static_cast<std::size_t>(std::ceil(std::abs(query.to - query.from) / kStep));
  double z = query.from;
  double here = excess(z);
  for (std::size_t k = 1; k <= steps; ++k) {
    const double next_z = k == steps ? query.to : query.from + toward * kStep * static_cast<double>(k);
    const double next = excess(next_z);
    const bool crosses = toward > 0.0 ? Crosses(here, next, query.crossing) : Crosses(next, here, query.crossing);
    if (crosses) {
      const double root = Root(excess, std::min(z, next_z), std::max(z, next_z));
      constexpr double kDifference = 0.25;  // mm
      const double slope = (excess(root + kDifference) - excess(root - kDifference)) / (2.0 * kDifference);
      if (slope == 0.0) return std::nullopt;
      GradientSum gradient(surface);
      function.add_gradient(root, -1.0 / slope, gradient);
      return Estimate{root, gradient.Get()};
    }
    z = next_z;
    here = next;
  }
  return std::nullopt;
}

std::optional<Estimate> FindLevelVertex(const SplineSurface& surface, const HeightFunction& function, double start,
                                        double half, Extremum which) {
  const double low = std::max(start - 2.0 * half, surface.z_min() + half);
  const double high = std::min(start + 2.0 * half, surface.z_max() - half);
  if (!(low < high) || start < low || start > high) return std::nullopt;
  const HeightFunction slope = TangentOf(function, half);
  const Crossing crossing = which == Extremum::kLargest ? Crossing::kFalling : Crossing::kRising;
  // The slope at the start says on which side the extremum lies.
  const bool above = (slope.value(start) > 0.0) == (which == Extremum::kLargest);
  return FindCrossing(surface, slope, {start, above ? high : low, 0.0, crossing});
}

}  // namespace annulus
