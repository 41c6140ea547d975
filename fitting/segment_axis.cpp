#include "fitting/segment_axis.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>
#include <vector>

#include "base/frames.h"

namespace annulus {
namespace {

constexpr double kHuber = 10.0;  // mm

using Parameters = Eigen::Matrix<double, 6, 1>;

/// A cone about a slanted line, with t = (z - middle) / half height in [-1, 1]: centre (p0 + p1 t, p2 + p3 t), radius
/// p4 + p5 t, all in mm.
struct Cone {
  Parameters p = Parameters::Zero();
  double middle = 0.0;
  double half = 1.0;

  [[nodiscard]] double T(double z) const { return (z - middle) / half; }
  /// Distance from the cone in the horizontal plane, mm, outside positive; and its derivative by p.
  [[nodiscard]] double Residual(const SurfaceSample& sample, Parameters& derivative) const {
    const double t = T(sample.z);
    const Eigen::Vector3d point = sample.Point();
    const Eigen::Vector2d d(point.x() - p[0] - p[1] * t, point.y() - p[2] - p[3] * t);
    const double length = std::max(d.norm(), 1e-9);
    derivative << -d.x() / length, -d.x() / length * t, -d.y() / length, -d.y() / length * t, -1.0, -t;
    return length - p[4] - p[5] * t;
  }
  [[nodiscard]] SegmentAxis Axis() const {
    SegmentAxis axis;
    axis.slope = Eigen::Vector2d(p[1], p[3]) / half;
    axis.at_zero = Eigen::Vector2d(p[0], p[2]) - middle * axis.slope;
    return axis;
  }
};

/// The line through the middle of the points, moved away from the ring by as much as the arc is wide.
Cone Start(std::span<const SurfaceSample> samples, double z_min, double z_max) {
  Cone cone;
  cone.middle = 0.5 * (z_min + z_max);
  cone.half = 0.5 * (z_max - z_min);
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d sums = Eigen::Matrix2d::Zero();  // rows: 1, t; columns: x, y
  for (const SurfaceSample& sample : samples) {
    const Eigen::Vector2d basis(1.0, cone.T(sample.z));
    moments += basis * basis.transpose();
    sums += basis * sample.Point().head<2>().transpose();
  }
  const Eigen::Matrix2d line = moments.ldlt().solve(sums);
  const Eigen::Vector2d outward = line.row(0).transpose().normalized();
  double across = 0.0;  // spread along the tangent, mm²
  for (const SurfaceSample& sample : samples) {
    const Eigen::Vector2d off = sample.Point().head<2>() - (line.row(0) + cone.T(sample.z) * line.row(1)).transpose();
    const double along = off.x() * outward.y() - off.y() * outward.x();
    across += along * along / static_cast<double>(samples.size());
  }
  const double radius = 1.4 * std::sqrt(across);  // a half circle's sd across is radius/√2
  cone.p << line(0, 0) - 0.6 * radius * outward.x(), line(1, 0), line(0, 1) - 0.6 * radius * outward.y(), line(1, 1),
      radius, 0.0;
  return cone;
}

/// Robust cost and the Gauss–Newton system at `cone`.
struct Step {
  double cost = 0.0;
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Parameters gradient = Parameters::Zero();
};

Step Linearise(std::span<const SurfaceSample> samples, const Cone& cone) {
  Step step;
  Parameters derivative;
  for (const SurfaceSample& sample : samples) {
    const double e = cone.Residual(sample, derivative);
    const double size = std::abs(e);
    const double weight = size <= kHuber ? 1.0 : kHuber / size;
    step.cost += size <= kHuber ? 0.5 * e * e : kHuber * (size - 0.5 * kHuber);
    step.normal += weight * derivative * derivative.transpose();
    step.gradient += weight * e * derivative;
  }
  return step;
}

/// Samples of one level after the other, on a level by theta from the middle of the piece.
std::vector<std::size_t> LevelOrder(std::span<const SurfaceSample> samples) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const SurfaceSample& sample : samples) middle += sample.Point().head<2>();
  const double theta = std::atan2(middle.y(), middle.x());
  std::vector<std::size_t> order(samples.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const SurfaceSample& p = samples[a];
    const SurfaceSample& q = samples[b];
    if (p.sweep != q.sweep) return p.sweep < q.sweep;
    if (p.level != q.level) return p.level < q.level;
    return AngleDifference(p.theta, theta) < AngleDifference(q.theta, theta);
  });
  return order;
}

bool SameLevel(const SurfaceSample& a, const SurfaceSample& b) { return a.sweep == b.sweep && a.level == b.level; }

double AngleAbout(const SurfaceSample& sample, const SegmentAxis& axis) {
  const Eigen::Vector2d d = sample.Point().head<2>() - axis.At(sample.z);
  return std::atan2(d.y(), d.x());
}

}  // namespace

Result<SegmentAxis> FindSegmentAxis(std::span<const SurfaceSample> samples) {
  constexpr std::size_t kFewest = 12;
  constexpr int kMaxSteps = 50;
  const std::string attempted = "find the axis of a limb";
  if (samples.size() < kFewest) {
    return Fail(attempted, "only " + std::to_string(samples.size()) + " returns", "scan with more levels");
  }
  const auto [low, high] = std::minmax_element(
      samples.begin(), samples.end(), [](const SurfaceSample& a, const SurfaceSample& b) { return a.z < b.z; });
  if (!(high->z - low->z >= 1.0)) return Fail(attempted, "all returns lie on one level", "scan with more levels");
  Cone cone = Start(samples, low->z, high->z);
  double damping = 1e-3;
  Step at = Linearise(samples, cone);
  for (int k = 0; k < kMaxSteps; ++k) {  // Levenberg–Marquardt
    Eigen::Matrix<double, 6, 6> damped = at.normal;
    damped.diagonal() *= 1.0 + damping;
    const Parameters move = -damped.ldlt().solve(at.gradient);
    Cone tried = cone;
    tried.p += move;
    const Step there = Linearise(samples, tried);
    if (!(there.cost <= at.cost)) {
      damping *= 10.0;
      if (damping > 1e8) break;
      continue;
    }
    cone = tried;
    at = there;
    damping = std::max(1e-9, 0.1 * damping);
    if (move.cwiseAbs().maxCoeff() < 1e-6) break;
  }
  constexpr double kThickest = 400.0;  // mm; a larger radius is no limb
  const bool sound = cone.p.allFinite() && cone.p[4] > 0.0 && std::abs(cone.p[4]) + std::abs(cone.p[5]) < kThickest;
  if (!sound) return Fail(attempted, "the returns lie too flat to tell what is behind them", "turn the limb");
  return cone.Axis();
}

std::vector<SurfaceSample> SamplesAboutAxis(std::span<const SurfaceSample> samples, const SegmentAxis& axis) {
  constexpr double kFinest = kTwoPi / 720.0;
  constexpr double kCoarsest = kTwoPi / 24.0;
  std::vector<double> steps;
  const std::vector<std::size_t> order = LevelOrder(samples);
  for (std::size_t k = 1; k < order.size(); ++k) {
    const SurfaceSample& before = samples[order[k - 1]];
    const SurfaceSample& here = samples[order[k]];
    if (!SameLevel(before, here)) continue;
    const double step = AngleDifference(AngleAbout(here, axis), AngleAbout(before, axis));
    if (step > 0.0) steps.push_back(step);
  }
  double step = kCoarsest;
  if (!steps.empty()) {
    const auto quarter = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 4);
    std::nth_element(steps.begin(), quarter, steps.end());
    step = std::clamp(*quarter, kFinest, kCoarsest);
  }
  const double directions = std::round(kTwoPi / step);
  std::vector<SurfaceSample> turned(samples.begin(), samples.end());
  for (SurfaceSample& sample : turned) {
    const double theta = WrapAngle(AngleAbout(sample, axis));
    sample.radius = (sample.Point().head<2>() - axis.At(sample.z)).norm();
    sample.theta = theta;
    sample.sensor = static_cast<std::uint16_t>(std::min(directions - 1.0, theta / kTwoPi * directions));
  }
  return turned;
}

double BackwardShare(std::span<const SurfaceSample> samples, const SegmentAxis& axis) {
  std::size_t pairs = 0;
  std::size_t backward = 0;
  const std::vector<std::size_t> order = LevelOrder(samples);
  for (std::size_t k = 1; k < order.size(); ++k) {
    const SurfaceSample& before = samples[order[k - 1]];
    const SurfaceSample& here = samples[order[k]];
    if (!SameLevel(before, here)) continue;
    ++pairs;
    if (AngleDifference(AngleAbout(here, axis), AngleAbout(before, axis)) < 0.0) ++backward;
  }
  return pairs > 0 ? static_cast<double>(backward) / static_cast<double>(pairs) : 0.0;
}

}  // namespace annulus
