#include "fitting/sway_levels.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/ensure.h"
#include "base/frames.h"
#include "fitting/sample_grid.h"

namespace annulus {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kSteepest =
    1.5;  // of the surface against the level, around or upwards: beyond it a point is no witness

double MedianOf(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A point of a level after the moving back.
struct Point {
  double theta, radius, z;
};

/// Straight line r = at + slope·(z − z0) through weighted points.
struct LineFit {
  double at = kNan, slope = 0.0;
};

LineFit FitLine(std::span<const std::pair<double, double>> points, std::span<const double> weights, double z0) {
  double w = 0.0, wz = 0.0, wzz = 0.0, wr = 0.0, wzr = 0.0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double z = points[k].first - z0;
    w += weights[k];
    wz += weights[k] * z;
    wzz += weights[k] * z * z;
    wr += weights[k] * points[k].second;
    wzr += weights[k] * z * points[k].second;
  }
  if (!(w > 0.0)) return {};
  const double spread = wzz - wz * wz / w;
  if (!(spread > 1.0 * w)) return {};  // mm²: no line through one height
  const double slope = (wzr - wz * wr / w) / spread;
  return {(wr - slope * wz) / w, slope};
}

double Tricube(double u) {
  const double a = 1.0 - std::abs(u * u * u);
  return a > 0.0 ? a * a * a : 0.0;
}

}  // namespace

std::vector<SweptLevel> LevelsOf(std::span<const SurfaceSample> samples) {
  std::map<std::pair<std::uint16_t, std::uint32_t>, SweptLevel> levels;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const SurfaceSample& sample = samples[k];
    if (!IsUsable(sample) || !(sample.weight > 0.0F)) continue;
    SweptLevel& level = levels[{sample.sweep, sample.level}];
    level.sweep = sample.sweep;
    level.level = sample.level;
    level.time_s += sample.time_s;
    level.z += sample.z;
    level.samples.push_back(k);
  }
  std::vector<SweptLevel> result;
  for (auto& [key, level] : levels) {
    level.time_s /= static_cast<double>(level.samples.size());
    level.z /= static_cast<double>(level.samples.size());
    result.push_back(std::move(level));
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const SweptLevel& a, const SweptLevel& b) { return a.time_s < b.time_s; });
  return result;
}

LevelCurve CurveOf(std::span<const SurfaceSample> samples, const SweptLevel& level, const SwayMotion& motion,
                   std::size_t columns) {
  std::vector<Point> points;
  points.reserve(level.samples.size());
  for (const std::size_t k : level.samples) {
    const Eigen::Vector3d p = RestFromStation(samples[k].Point(), motion);
    points.push_back({WrapAngle(std::atan2(p.y(), p.x())), p.head<2>().norm(), p.z()});
  }
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.theta < b.theta; });
  LevelCurve curve{std::vector<double>(columns, kNan), std::vector<double>(columns, kNan)};
  const double step = kTwoPi / static_cast<double>(columns);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Point& a = points[k];
    Point b = points[(k + 1) % points.size()];
    if (k + 1 == points.size()) b.theta += kTwoPi;
    const double gap = b.theta - a.theta;
    // A gap of more than a missing return is not bridged, nor a jump from one surface to another.
    if (gap > 2.2 * step || std::abs(a.radius - b.radius) > kSteepest * step * 0.5 * (a.radius + b.radius) + 2.0) {
      continue;
    }
    for (double c = std::ceil(a.theta / step); c * step <= b.theta; c += 1.0) {
      const double share = gap > 0.0 ? (c * step - a.theta) / gap : 0.0;
      const std::size_t column = static_cast<std::size_t>(c) % columns;
      curve.radius[column] = a.radius + share * (b.radius - a.radius);
      curve.height[column] = a.z + share * (b.z - a.z);
    }
  }
  return curve;
}

SwaySurface::SwaySurface(const std::vector<LevelCurve>& curves, double reach) {
  ENSURE(!curves.empty(), "a surface needs a level");
  columns_ = curves.front().radius.size();
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const LevelCurve& curve : curves) {
    for (const double z : curve.height) {
      if (std::isnan(z)) continue;
      low = std::min(low, z);
      high = std::max(high, z);
    }
  }
  if (!(low <= high)) return;
  z_min_ = low;
  rows_ = static_cast<std::size_t>((high - low) / step_) + 2;
  nodes_.assign(rows_ * columns_, kNan);
  std::vector<std::pair<double, double>> points;
  for (std::size_t column = 0; column < columns_; ++column) {
    points.clear();
    for (const LevelCurve& curve : curves) {
      if (!std::isnan(curve.radius[column])) points.emplace_back(curve.height[column], curve.radius[column]);
    }
    std::sort(points.begin(), points.end());
    FitColumn(column, points, reach);
  }
}

void SwaySurface::FitColumn(std::size_t column, std::vector<std::pair<double, double>>& points, double reach) {
  constexpr std::size_t kFewest = 4;
  constexpr int kRounds = 2;
  std::size_t first = 0;
  std::size_t last = 0;
  std::vector<double> weights;
  std::vector<double> misses;
  for (std::size_t row = 0; row < rows_; ++row) {
    const double z = z_min_ + step_ * static_cast<double>(row);
    while (first < points.size() && points[first].first < z - reach) ++first;
    while (last < points.size() && points[last].first <= z + reach) ++last;
    if (last - first < kFewest) continue;
    const std::span window(points.data() + first, last - first);
    misses.clear();
    for (const auto& point : window) misses.push_back(point.second);
    LineFit line{MedianOf(misses), 0.0};
    for (int round = 0; round <= kRounds; ++round) {
      misses.clear();
      for (const auto& [at, r] : window) misses.push_back(std::abs(r - line.at - line.slope * (at - z)));
      std::vector<double> sorted = misses;
      const double cut = std::max(3.0, 4.685 * 1.4826 * MedianOf(sorted));  // bisquare
      weights.clear();
      for (std::size_t k = 0; k < window.size(); ++k) {
        const double u = misses[k] / cut;
        const double robust = u < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
        weights.push_back(robust * Tricube((window[k].first - z) / reach));
      }
      line = FitLine(window, weights, z);
      if (std::isnan(line.at)) break;
    }
    nodes_[row * columns_ + column] = line.at;
  }
}

std::optional<SwaySurface::Place> SwaySurface::At(std::size_t column, double z) const {
  const double place = (z - z_min_) / step_;
  if (!(place >= 0.0) || !(place < static_cast<double>(rows_ - 1))) return std::nullopt;
  const auto row = static_cast<std::size_t>(place);
  const double up = place - static_cast<double>(row);
  const auto level = [&](std::size_t c) { return Node(row, c) + up * (Node(row + 1, c) - Node(row, c)); };
  // Slope around by least squares over five directions.
  const auto beside = [&](std::size_t offset) { return level((column + columns_ + offset - 2) % columns_); };
  Place at;
  at.r = level(column);
  at.r_theta =
      (2.0 * (beside(4) - beside(0)) + beside(3) - beside(1)) * static_cast<double>(columns_) / (10.0 * kTwoPi);
  at.r_z = (Node(row + 1, column) - Node(row, column)) / step_;
  if (!(at.r > 1.0) || !(std::abs(at.r_theta) < kSteepest * at.r) || !(std::abs(at.r_z) < kSteepest)) {
    return std::nullopt;
  }
  return at;
}

std::optional<SwaySurface::Place> SwaySurface::Between(double theta, double z) const {
  const double place = WrapAngle(theta) / kTwoPi * static_cast<double>(columns_);
  const std::size_t column = static_cast<std::size_t>(place) % columns_;
  const double share = place - std::floor(place);
  const auto a = At(column, z);
  const auto b = At((column + 1) % columns_, z);
  if (!a || !b) return std::nullopt;
  return Place{a->r + share * (b->r - a->r), a->r_theta + share * (b->r_theta - a->r_theta),
               a->r_z + share * (b->r_z - a->r_z)};
}

SwayVector RadiusByMotion(const SwaySurface::Place& place, double theta, double z) {
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  const double slope = place.r_theta / place.r;
  const double by_x = c + slope * s;
  const double by_y = s - slope * c;
  const double down = place.r_z * place.r;
  return {(by_x * z + down * c) / kSwayHeight, (by_y * z + down * s) / kSwayHeight, -place.r_theta, by_x, by_y};
}

namespace {

using Vector6 = Eigen::Matrix<double, kSwayAxes + 1, 1>;
using Matrix6 = Eigen::Matrix<double, kSwayAxes + 1, kSwayAxes + 1>;

/// One direction of a level against the surface.
struct Witness {
  Vector6 by = Vector6::Zero();  ///< By motion, and by growth.
  double miss = 0.0;             ///< Radial, mm.
  double normal = 1.0;           ///< Distance along the normal over radial distance.
};

std::vector<Witness> WitnessesOf(const LevelCurve& curve, const SwaySurface& surface) {
  std::vector<Witness> witnesses;
  for (std::size_t column = 0; column < curve.radius.size(); ++column) {
    const double r = curve.radius[column];
    if (std::isnan(r)) continue;
    const double z = curve.height[column];
    const auto place = surface.At(column, z);
    if (!place) continue;
    const double theta = kTwoPi * static_cast<double>(column) / static_cast<double>(curve.radius.size());
    Witness witness;
    witness.by << RadiusByMotion(*place, theta, z), place->r;
    witness.miss = r - place->r;
    witness.normal = 1.0 / std::sqrt(1.0 + std::pow(place->r_theta / place->r, 2) + place->r_z * place->r_z);
    witnesses.push_back(witness);
  }
  return witnesses;
}

}  // namespace

LevelMotion ObserveLevel(const LevelCurve& curve, const SwaySurface& surface) {
  constexpr std::size_t kFewest = 30;
  constexpr int kRounds = 6;
  constexpr double kLeastSigma = 0.2;  // mm
  // A direction is interpolated between two returns: neighbours do not count in full.
  constexpr double kCount = 0.5;
  // What one level may do at most: holds what a section does not show, such as the turn of a circle, or what is lean
  // and what is shift.
  Vector6 most;
  most << 100.0, 100.0, 0.3, 100.0, 100.0, 0.02;
  const Vector6 weak = most.array().square().inverse();
  LevelMotion level;
  const std::vector<Witness> witnesses = WitnessesOf(curve, surface);
  level.points = witnesses.size();
  if (witnesses.size() < kFewest) return level;
  Vector6 motion = Vector6::Zero();
  Matrix6 information = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  std::vector<double> misses;
  for (int round = 0; round < kRounds; ++round) {
    misses.clear();
    for (const Witness& w : witnesses) misses.push_back(std::abs(w.miss - w.by.dot(motion)) * w.normal);
    level.sigma = std::max(kLeastSigma, 1.4826 * MedianOf(misses));
    const double cut = 4.685 * level.sigma;  // bisquare; the first rounds are wider
    const double wide = round < 2 ? 4.0 : 1.0;
    information.setZero();
    right.setZero();
    for (const Witness& w : witnesses) {
      const double u = std::abs(w.miss - w.by.dot(motion)) * w.normal / (wide * cut);
      if (u >= 1.0) continue;
      const double weight = kCount * std::pow((1.0 - u * u) * w.normal / level.sigma, 2);
      information += weight * w.by * w.by.transpose();
      right += weight * w.miss * w.by;
    }
    Matrix6 held = information;
    held.diagonal() += weak;
    motion = held.ldlt().solve(right);
  }
  // Growth out: a breath of a few per cent at the most.
  const double growth = information(kSwayAxes, kSwayAxes) + weak[kSwayAxes];
  const SwayVector with_growth = information.topRightCorner<kSwayAxes, 1>();
  level.information =
      information.topLeftCorner<kSwayAxes, kSwayAxes>() - with_growth * with_growth.transpose() / growth;
  level.right = right.head<kSwayAxes>() - with_growth * right[kSwayAxes] / growth;
  return level;
}

}  // namespace annulus
