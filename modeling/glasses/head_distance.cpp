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
constexpr int kNewtonSteps = 12;

/// Point, first and second derivatives of r(theta, z) as a surface in space.
struct SurfaceJet {
  Vector3d point, by_theta, by_z, by_theta_theta, by_theta_z, by_z_z;
};

SurfaceJet JetAt(const SplineSurface& surface, double theta, double z) {
  const RadiusJet jet = surface.Jet(theta, z);
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

HeadGap HeadDistance::FirstOrder(const Vector3d& p) const {
  const double radius = std::hypot(p.x(), p.y());
  if (p.z() < surface_->z_min() || p.z() > surface_->z_max() || radius < 1e-9) {
    return {radius < 1e-9 ? -kFar : kFar, Vector3d::UnitY()};
  }
  const RadiusJet jet = surface_->Jet(std::atan2(p.y(), p.x()), p.z());
  const double slope = jet.r_theta / std::max(jet.r, 1.0);
  const double length = std::sqrt(1.0 + slope * slope + jet.r_z * jet.r_z);
  const Vector3d radial(p.x() / radius, p.y() / radius, 0.0);
  const Vector3d across(-radial.y(), radial.x(), 0.0);
  return {(radius - jet.r) / length, (radial - slope * across - jet.r_z * Vector3d::UnitZ()) / length};
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
  const double radial_gap = radius - surface_->Radius(theta, foot_z);
  const double reach = std::hypot(radial_gap, p.z() - foot_z) + kSampleStep;
  Vector2d place = NearestSample(p, theta, reach);
  SurfaceJet jet = JetAt(*surface_, place.x(), place.y());
  double distance = (jet.point - p).norm();
  for (int k = 0; k < kNewtonSteps; ++k) {
    Vector2d step = StepToFoot(jet, p);
    const double size = std::max(std::abs(step.x()) * std::max(radius, 1.0), std::abs(step.y()));
    if (size > kSampleStep) step *= kSampleStep / size;
    const Vector2d next(place.x() + step.x(), std::clamp(place.y() + step.y(), low, high));
    const SurfaceJet there = JetAt(*surface_, next.x(), next.y());
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
