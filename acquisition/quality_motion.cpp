#include "acquisition/quality_motion.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace annulus {
namespace {

constexpr double kStep = 0.3;    // of the radius between two directions: beyond it they are two surfaces
constexpr double kReach = 12.0;  // mm to the next level of the reference
constexpr std::size_t kFewestPoints = 30;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kVoid = -1.0F;  // a reference that looks there and sees nothing on this side

/// Whether two neighbouring radii are of one surface.
bool Continuous(double a, double b) { return std::abs(a - b) < kStep * 0.5 * (a + b) * 0.5 + 2.0; }

/// Directions as cosines and sines.
struct Directions {
  explicit Directions(const QualityGrid& grid) {
    for (std::size_t c = 0; c < grid.columns(); ++c) {
      cosine.push_back(std::cos(grid.Theta(c)));
      sine.push_back(std::sin(grid.Theta(c)));
    }
  }
  std::vector<double> cosine, sine;
};

/// The reference's radius in any direction, and its slope; NaN off the surface.
struct CurvePoint {
  double radius, slope;
};
CurvePoint CurveAt(std::span<const float> reference, double theta, double step) {
  const std::size_t n = reference.size();
  const double place = WrapAngle(theta) / step;
  const std::size_t column = static_cast<std::size_t>(place) % n;
  const double share = place - std::floor(place);
  const double a = reference[column];
  const double b = reference[(column + 1) % n];
  if (!(a > 0.0 && b > 0.0) || !Continuous(a, b)) return {std::numeric_limits<double>::quiet_NaN(), 0.0};
  return {a + share * (b - a), (b - a) / step};
}

using Vector4 = Eigen::Matrix<double, 4, 1>;

/// One point of the level brought back by a shift, its distance from the reference, and how that depends on the shift.
struct PointMiss {
  double miss = std::numeric_limits<double>::quiet_NaN();  ///< Radial, mm.
  double scale = 1.0;                                      ///< Radial over perpendicular distance.
  Vector4 by_shift = Vector4::Zero();
};
PointMiss MissOf(double x, double y, const Vector4& shift, std::span<const float> reference, double step) {
  PointMiss point;
  const double dx = x - shift[0];
  const double dy = y - shift[1];
  const double shrink = 1.0 - shift[3];
  const double qx = shrink * (dx + shift[2] * dy);
  const double qy = shrink * (dy - shift[2] * dx);
  const double radius = std::hypot(qx, qy);
  if (!(radius > 1.0)) return point;
  const CurvePoint curve = CurveAt(reference, std::atan2(qy, qx), step);
  if (std::isnan(curve.radius)) return point;
  point.miss = radius - curve.radius;
  // Gradient of radius - curve(theta) with respect to the place: e_r - (slope / r) e_theta.
  const double tilt = curve.slope / radius;
  const double gx = (qx + tilt * qy) / radius;
  const double gy = (qy - tilt * qx) / radius;
  point.scale = std::sqrt(1.0 + tilt * tilt);
  point.by_shift << -gx, -gy, gx * qy - gy * qx, -(gx * qx + gy * qy);
  return point;
}

/// What a level may do: generous, and enough to hold what a section does not show (the turn of a circle).
const Vector4 kPriorSigma{200.0, 200.0, 0.15, 0.03};

double HuberScale(std::vector<double>& misses) {
  constexpr double kFloor = 1.0;  // mm
  return std::max(kFloor, 1.345 * 1.4826 * MedianOf(misses));
}

/// Middle of the points seen, which a turn is about.
Eigen::Vector2d MiddleOf(std::span<const float> radii, const Directions& directions) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (std::size_t c = 0; c < radii.size(); ++c) {
    if (!(radii[c] > 0.0F)) continue;
    sum += static_cast<double>(radii[c]) * Eigen::Vector2d(directions.cosine[c], directions.sine[c]);
    count += 1.0;
  }
  return count > 0.0 ? Eigen::Vector2d(sum / count) : sum;
}

Vector4 SolveShift(std::span<const float> radii, std::span<const float> reference, const Directions& directions,
                   double step, std::size_t& points) {
  constexpr int kRounds = 8;
  Vector4 shift = Vector4::Zero();
  std::vector<PointMiss> seen;
  std::vector<double> misses;
  for (int round = 0; round < kRounds; ++round) {
    seen.clear();
    misses.clear();
    for (std::size_t c = 0; c < radii.size(); ++c) {
      const double r = radii[c];
      if (!(r > 0.0)) continue;
      const double next = radii[(c + 1) % radii.size()];
      if (!(next > 0.0) || !Continuous(r, next)) continue;
      const PointMiss point = MissOf(r * directions.cosine[c], r * directions.sine[c], shift, reference, step);
      if (std::isnan(point.miss)) continue;
      seen.push_back(point);
      misses.push_back(std::abs(point.miss) / point.scale);
    }
    points = seen.size();
    if (points < kFewestPoints) return shift;
    const double huber = HuberScale(misses);
    Eigen::Matrix4d normal = kPriorSigma.array().square().inverse().matrix().asDiagonal();
    Vector4 right = -(normal * shift);
    for (const PointMiss& point : seen) {
      const double distance = std::abs(point.miss) / point.scale;
      const double weight = (distance > huber ? huber / distance : 1.0) / (point.scale * point.scale);
      normal += weight * point.by_shift * point.by_shift.transpose();
      right -= weight * point.miss * point.by_shift;
    }
    const Vector4 change = normal.ldlt().solve(right);
    if (!change.allFinite()) break;
    shift += change;
    shift[2] = std::clamp(shift[2], -0.5, 0.5);
    shift[3] = std::clamp(shift[3], -0.1, 0.1);
    if (change.head<2>().norm() < 1e-3 && std::abs(change[2]) < 1e-5) break;
  }
  return shift;
}

/// A level's residuals: its points brought back, put into the reference's directions.
std::vector<float> ResidualsOf(std::span<const float> radii, std::span<const float> reference,
                               const Directions& directions, const LevelShift& shift, double step) {
  const std::size_t n = radii.size();
  std::vector<float> residual(n, kNan);
  const Vector4 by(shift.x, shift.y, shift.yaw, shift.growth);
  for (std::size_t c = 0; c < n; ++c) {
    const double r = radii[c];
    if (r > 0.0) {
      const PointMiss point = MissOf(r * directions.cosine[c], r * directions.sine[c], by, reference, step);
      if (!std::isnan(point.miss)) {
        residual[c] = static_cast<float>(point.miss);
      } else if (reference[c] == kVoid) {
        residual[c] = kInfinite;
      }
    } else if (reference[c] > 0.0F) {
      residual[c] = -kInfinite;
    }
  }
  return residual;
}

/// Mean without the largest twentieth: levels in which an arm moved are none of the person's sway. Reorders.
double TrimmedMean(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  const std::size_t kept = std::max<std::size_t>(1, values.size() - values.size() / 20);
  return std::accumulate(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(kept), 0.0) /
         static_cast<double>(kept);
}

/// Lag at which the autocorrelation of a curve has fallen to exp(-1/2): the length of a Gaussian covariance.
double CorrelationLength(const std::vector<std::pair<double, Eigen::Vector2d>>& curve) {
  constexpr double kBin = 20.0;  // mm
  constexpr std::size_t kBins = 60;
  constexpr double kLongest = kBin * kBins;
  std::vector<double> product(kBins, 0.0);
  std::vector<std::size_t> count(kBins, 0);
  const std::size_t stride = std::max<std::size_t>(1, curve.size() / 200);
  for (std::size_t a = 0; a < curve.size(); a += stride) {
    for (std::size_t b = a; b < curve.size(); b += stride) {
      const auto bin = static_cast<std::size_t>(std::abs(curve[a].first - curve[b].first) / kBin);
      if (bin >= kBins) continue;
      product[bin] += curve[a].second.dot(curve[b].second);
      ++count[bin];
    }
  }
  if (count[0] == 0 || !(product[0] > 0.0)) return kLongest;
  const double whole = product[0] / static_cast<double>(count[0]);
  for (std::size_t bin = 1; bin < kBins; ++bin) {
    if (count[bin] < 5) continue;
    if (product[bin] / static_cast<double>(count[bin]) < std::exp(-0.5) * whole) {
      return kBin * (static_cast<double>(bin) + 0.5);
    }
  }
  return kLongest;
}

}  // namespace

ReferenceSweep::ReferenceSweep(const QualityGrid& grid, std::uint16_t sweep) : grid_(grid) {
  for (std::size_t k = 0; k < grid.levels().size(); ++k) {
    if (grid.levels()[k].sweep == sweep) levels_.push_back(k);
  }
  std::stable_sort(levels_.begin(), levels_.end(),
                   [&](std::size_t a, std::size_t b) { return grid.levels()[a].z < grid.levels()[b].z; });
}

bool ReferenceSweep::At(double z, std::vector<float>& radii) const {
  const auto above = std::lower_bound(levels_.begin(), levels_.end(), z, [&](std::size_t level, double height) {
    return grid_.levels()[level].z < height;
  });
  const auto z_of = [&](auto place) { return grid_.levels()[*place].z; };
  constexpr double kSameHeight = 0.5;  // mm
  const auto as_it_is = [&](std::size_t level) {
    const auto row = grid_.Radii(level);
    radii.assign(row.begin(), row.end());
    for (float& radius : radii) radius = radius > 0.0F ? radius : kVoid;
    return true;
  };
  if (above != levels_.end() && z_of(above) - z < kSameHeight) return as_it_is(*above);
  if (above == levels_.begin()) return false;
  const auto below = above - 1;
  if (z - z_of(below) < kSameHeight) return as_it_is(*below);
  if (above == levels_.end() || z_of(above) - z > kReach || z - z_of(below) > kReach) return false;
  const double share = (z - z_of(below)) / (z_of(above) - z_of(below));
  radii.resize(grid_.columns());
  for (std::size_t c = 0; c < radii.size(); ++c) {
    const double a = grid_.Radius(*below, c);
    const double b = grid_.Radius(*above, c);
    radii[c] = a > 0.0 && b > 0.0 && Continuous(a, b) ? static_cast<float>(a + share * (b - a)) : kNan;
    if (!(a > 0.0) && !(b > 0.0)) radii[c] = kVoid;
  }
  return true;
}

LevelShift AlignLevel(const QualityGrid& grid, std::span<const float> radii, std::span<const float> reference) {
  const Directions directions(grid);
  std::size_t points = 0;
  const Vector4 shift = SolveShift(radii, reference, directions, grid.step(), points);
  LevelShift result{shift[0], shift[1], shift[2], shift[3], points};
  if (points < kFewestPoints) result.points = 0;
  return result;
}

std::vector<ComparedLevel> CompareSweeps(const QualityGrid& grid) {
  std::vector<ComparedLevel> compared;
  if (grid.levels().empty()) return compared;
  const std::uint16_t first = grid.levels().front().sweep;
  const ReferenceSweep reference(grid, first);
  const Directions directions(grid);
  std::vector<float> radii;
  for (std::size_t k = 0; k < grid.levels().size(); ++k) {
    if (grid.levels()[k].sweep == first || !reference.At(grid.levels()[k].z, radii)) continue;
    ComparedLevel level;
    level.level = k;
    level.shift = AlignLevel(grid, grid.Radii(k), radii);
    level.residual = ResidualsOf(grid.Radii(k), radii, directions, level.shift, grid.step());
    if (level.shift.points > 0) {
      // The shift of the section itself, not of the ring's axis, about which it turns.
      const Eigen::Vector2d middle = MiddleOf(grid.Radii(k), directions);
      level.shift.x += -level.shift.yaw * middle.y();
      level.shift.y += level.shift.yaw * middle.x();
    }
    compared.push_back(std::move(level));
  }
  return compared;
}

double ShiftOf(const ComparedLevel& level) { return std::hypot(level.shift.x, level.shift.y); }

std::optional<MotionQuality> MotionOf(const QualityGrid& grid, const std::vector<ComparedLevel>& compared) {
  constexpr std::size_t kFewestLevels = 10;
  std::map<std::uint16_t, std::vector<std::pair<double, Eigen::Vector2d>>> curves;
  MotionQuality motion;
  std::vector<double> x_squares;
  std::vector<double> y_squares;
  std::vector<double> sizes;
  std::vector<double> yaws;
  for (const ComparedLevel& level : compared) {
    if (level.shift.points == 0) continue;
    const QualityGrid::Level& at = grid.levels()[level.level];
    curves[at.sweep].emplace_back(at.z, Eigen::Vector2d(level.shift.x, level.shift.y));
    x_squares.push_back(level.shift.x * level.shift.x);
    y_squares.push_back(level.shift.y * level.shift.y);
    sizes.push_back(ShiftOf(level));
    yaws.push_back(std::abs(level.shift.yaw));
    ++motion.levels;
  }
  if (motion.levels < kFewestLevels) return std::nullopt;
  // A difference of two sweeps has twice the variance of one; a surface through all of them the variance of one over
  // their number.
  const double sweeps = 1.0 + static_cast<double>(curves.size());
  motion.sigma_x_mm = std::sqrt(0.5 / sweeps * TrimmedMean(x_squares));
  motion.sigma_y_mm = std::sqrt(0.5 / sweeps * TrimmedMean(y_squares));
  // The largest that is no chance: one in twenty levels moved further.
  const auto high = [](std::vector<double>& values) {
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 19 / 20);
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  motion.largest_mm = high(sizes);
  motion.largest_yaw_rad = high(yaws);
  double length = 0.0;
  for (const auto& [sweep, curve] : curves) length += CorrelationLength(curve);
  motion.correlation_length_mm = length / static_cast<double>(curves.size());
  return motion;
}

}  // namespace annulus
