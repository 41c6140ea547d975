#include "modeling/glasses/head_distance.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/ensure.h"
#include "base/frames.h"

namespace annulus {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSampleStep = 2.0;  // mm between samples in z
constexpr int kColumns = 360;
constexpr double kFar = 1e3;      // mm: what is not there is this far away
constexpr double kDetour = 20.0;  // mm: a gap above this is searched with every second sample
constexpr double kBeside = 1.0;   // mm: no search for a point with a radial gap less than this
constexpr int kNewtonSteps = 12;

/// Point, first and second derivatives of r(theta, z) as a surface in space.
struct SurfaceJet {
  Vector3d point, by_theta, by_z, by_theta_theta, by_theta_z, by_z_z;
};

SurfaceJet JetInSpace(const RadiusJet& jet, double theta, double z) {
  const Vector3d radial(std::cos(theta), std::sin(theta), 0.0);
  const Vector3d across(-radial.y(), radial.x(), 0.0);
  return {jet.r * radial + z * Vector3d::UnitZ(),    jet.r_theta * radial + jet.r * across,
          jet.r_z * radial + Vector3d::UnitZ(),      (jet.r_theta_theta - jet.r) * radial + 2.0 * jet.r_theta * across,
          jet.r_theta_z * radial + jet.r_z * across, jet.r_z_z * radial};
}

/// Newton's step to the foot of the perpendicular, or Gauss and Newton's where the distance is not convex.
Vector2d StepToFoot(const SurfaceJet& s, const Vector3d& p) {
  const Vector3d off = s.point - p;
  const Vector2d slope(off.dot(s.by_theta), off.dot(s.by_z));
  Matrix2d first;
  first << s.by_theta.squaredNorm(), s.by_theta.dot(s.by_z), s.by_theta.dot(s.by_z), s.by_z.squaredNorm();
  Matrix2d second;
  second << off.dot(s.by_theta_theta), off.dot(s.by_theta_z), off.dot(s.by_theta_z), off.dot(s.by_z_z);
  const Matrix2d full = first + second;
  const bool is_convex = full(0, 0) > 0.1 * first(0, 0) && full.determinant() > 0.05 * first.determinant();
  return -(is_convex ? full : first).inverse() * slope;
}

}  // namespace

HeadDistance::HeadDistance(const SplineSurface& head, double z_low, double z_high)
    : surface_(&head), z_low_(std::max(z_low, head.z_min())) {
  const double top = std::min(z_high, head.z_max());
  ENSURE(z_low_ < top, "the heights lie on the surface");
  const ClampedCubicBasis& z_basis = head.z_basis();
  for (std::size_t k = 0; k + 1 < z_basis.breakpoints().size(); ++k) {
    const double start = z_basis.breakpoints()[k];
    heights_.push_back({start, z_basis.breakpoints()[k + 1] - start, z_basis.Cubics(k)});
  }
  for (double z = head.z_min(); z <= head.z_max(); z += 1.0) first_interval_.push_back(z_basis.Interval(z));
  rows_ = static_cast<int>((top - z_low_) / kSampleStep) + 1;
  for (int column = 0; column < kColumns; ++column) {
    const double theta = kTwoPi * column / kColumns;
    columns_.push_back({std::cos(theta), std::sin(theta)});
  }
  radius_.reserve(static_cast<std::size_t>(rows_) * kColumns);
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      radius_.push_back(head.Radius(kTwoPi * column / kColumns, z_low_ + row * kSampleStep));
    }
  }
}

const HeadDistance::HeightInterval& HeadDistance::IntervalAt(double z) const {
  const double above = std::clamp(z - heights_.front().start, 0.0, static_cast<double>(first_interval_.size() - 1));
  std::size_t k = first_interval_[static_cast<std::size_t>(above)];
  while (k + 1 < heights_.size() && z >= heights_[k + 1].start) ++k;
  return heights_[k];
}

RadiusJet HeadDistance::Jet(double theta, double z) const {
  const PeriodicCubicBasis& around = surface_->theta_basis();
  const std::size_t width = around.count();
  const double turn = WrapAngle(theta) / around.spacing();
  const std::size_t column = std::min(static_cast<std::size_t>(turn), width - 1);
  const double t = turn - static_cast<double>(column);
  const double s = 1.0 - t;
  const double h = around.spacing();
  const std::array<double, 4> value{s * s * s / 6.0, (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
                                    (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0, t * t * t / 6.0};
  const std::array<double, 4> first{-s * s / (2.0 * h), (-4.0 * t + 3.0 * t * t) / (2.0 * h),
                                    (4.0 * s - 3.0 * s * s) / (2.0 * h), t * t / (2.0 * h)};
  const std::array<double, 4> second{s / (h * h), (3.0 * t - 2.0) / (h * h), (3.0 * s - 2.0) / (h * h), t / (h * h)};
  const std::array<std::size_t, 4> index{(column + width - 1) % width, column, (column + 1) % width,
                                         (column + 2) % width};
  const HeightInterval& height = IntervalAt(z);
  const double v = (z - height.start) / height.length;
  const auto row = static_cast<std::size_t>(&height - heights_.data());
  RadiusJet jet;
  for (std::size_t j = 0; j < 4; ++j) {
    const double* c = surface_->coefficients().data() + (row + j) * width;
    double s0 = 0.0;
    double s1 = 0.0;
    double s2 = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      s0 += value[i] * c[index[i]];
      s1 += first[i] * c[index[i]];
      s2 += second[i] * c[index[i]];
    }
    const auto& p = height.cubics[j];
    const double b0 = ((p[3] * v + p[2]) * v + p[1]) * v + p[0];
    const double b1 = ((3.0 * p[3] * v + 2.0 * p[2]) * v + p[1]) / height.length;
    const double b2 = (6.0 * p[3] * v + 2.0 * p[2]) / (height.length * height.length);
    jet.r += b0 * s0;
    jet.r_theta += b0 * s1;
    jet.r_theta_theta += b0 * s2;
    jet.r_z += b1 * s0;
    jet.r_theta_z += b1 * s1;
    jet.r_z_z += b2 * s0;
  }
  return jet;
}

HeadGap HeadDistance::FirstOrder(const Vector3d& p) const {
  const double radius = std::hypot(p.x(), p.y());
  if (p.z() < surface_->z_min() || p.z() > surface_->z_max() || radius < 1e-9) {
    return {radius < 1e-9 ? -kFar : kFar, Vector3d::UnitY()};
  }
  const RadiusJet jet = Jet(std::atan2(p.y(), p.x()), p.z());
  const double r = std::max(jet.r, 1.0);
  const double slope = jet.r_theta / r;
  const double length = std::sqrt(1.0 + slope * slope + jet.r_z * jet.r_z);
  const double distance = (radius - jet.r) / length;
  // d(length), by theta and by z: of the slopes, which change over the surface.
  const double by_theta = (slope * (jet.r_theta_theta / r - slope * slope) + jet.r_z * jet.r_theta_z) / length;
  const double by_z = (slope * (jet.r_theta_z / r - slope * jet.r_z / r) + jet.r_z * jet.r_z_z) / length;
  const Vector3d radial(p.x() / radius, p.y() / radius, 0.0);
  const Vector3d across(-radial.y(), radial.x(), 0.0);
  const Vector3d of_gap = radial - jet.r_theta / radius * across - jet.r_z * Vector3d::UnitZ();
  const Vector3d of_length = by_theta / radius * across + by_z * Vector3d::UnitZ();
  return {distance, (of_gap - distance * of_length) / length};
}

Vector2d HeadDistance::NearestSample(const Vector3d& p, double theta, double reach) const {
  const double radius = std::hypot(p.x(), p.y());
  const double turn = reach >= radius ? kPi : std::asin(reach / radius);
  const int step = reach > kDetour ? 2 : 1;
  const int low = std::clamp(static_cast<int>(std::floor((p.z() - reach - z_low_) / kSampleStep)), 0, rows_ - 1);
  const int high = std::clamp(static_cast<int>(std::ceil((p.z() + reach - z_low_) / kSampleStep)), 0, rows_ - 1);
  const int first = static_cast<int>(std::floor((theta - turn) * kColumns / kTwoPi));
  const int last = static_cast<int>(std::ceil((theta + turn) * kColumns / kTwoPi));
  double least = kFar * kFar;
  Vector2d best(theta, std::clamp(p.z(), z_low_, z_low_ + (rows_ - 1) * kSampleStep));
  for (int row = low; row <= high; row += step) {
    const double z = z_low_ + row * kSampleStep;
    const double up = z - p.z();
    const double* radii = radius_.data() + static_cast<std::size_t>(row) * kColumns;
    for (int column = first; column <= last; column += step) {
      const auto k = static_cast<std::size_t>(((column % kColumns) + kColumns) % kColumns);
      const double x = radii[k] * columns_[k].cosine - p.x();
      const double y = radii[k] * columns_[k].sine - p.y();
      const double square = x * x + y * y + up * up;
      if (square < least) {
        least = square;
        best = {kTwoPi * column / kColumns, z};
      }
    }
  }
  return best;
}

NearestOnHead HeadDistance::Nearest(const Vector3d& p) const {
  const double radius = std::hypot(p.x(), p.y());
  const double theta = std::atan2(p.y(), p.x());
  const double low = surface_->z_min();
  const double high = surface_->z_max();
  const double foot_z = std::clamp(p.z(), low, high);
  const bool is_beside = p.z() >= low && p.z() <= high;
  const double radial_gap = radius - Jet(theta, foot_z).r;
  const double reach = std::hypot(radial_gap, p.z() - foot_z) + kSampleStep;
  // So near, the foot of the perpendicular is beside the radial one.
  Vector2d place = reach < kSampleStep + kBeside ? Vector2d(theta, foot_z) : NearestSample(p, theta, reach);
  SurfaceJet jet = JetInSpace(Jet(place.x(), place.y()), place.x(), place.y());
  double distance = (jet.point - p).norm();
  for (int k = 0; k < kNewtonSteps; ++k) {
    Vector2d step = StepToFoot(jet, p);
    const double size = std::max(std::abs(step.x()) * std::max(radius, 1.0), std::abs(step.y()));
    if (size > kSampleStep) step *= kSampleStep / size;
    const Vector2d next(place.x() + step.x(), std::clamp(place.y() + step.y(), low, high));
    const SurfaceJet there = JetInSpace(Jet(next.x(), next.y()), next.x(), next.y());
    const double moved = (there.point - p).norm();
    if (moved > distance) break;
    place = next;
    jet = there;
    distance = moved;
    if (size < 1e-6) break;
  }
  const bool is_inside = is_beside && radial_gap < 0.0;
  return {is_inside ? -distance : distance, jet.point, WrapAngle(place.x()), place.y()};
}

}  // namespace annulus
