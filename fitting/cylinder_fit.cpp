#include "fitting/cylinder_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/ensure.h"

namespace annulus {
namespace {

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

constexpr const char* kAttempted = "fit a cylinder";
constexpr std::size_t kFewestReturns = 20;
constexpr double kNormal = 1.4826;  // sd of a normal distribution over its median magnitude
constexpr double kConvergedMm = 1e-6;

double Median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The circle x² + y² = 2ax + 2by + c through weighted points (Kåsa 1976): linear, good enough to start from.
CylinderPose CircleThrough(const std::vector<Eigen::Vector3d>& points, const std::vector<char>& counts) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (counts[k] == 0) continue;
    const Eigen::Vector3d row(2.0 * points[k].x(), 2.0 * points[k].y(), 1.0);
    normal += row * row.transpose();
    right += row * points[k].head<2>().squaredNorm();
  }
  const Eigen::Vector3d solution = normal.ldlt().solve(right);
  CylinderPose pose;
  pose.x_mm = solution.x();
  pose.y_mm = solution.y();
  pose.radius_mm = std::sqrt(std::max(0.0, solution.z() + solution.head<2>().squaredNorm()));
  return pose;
}

/// A start that bears a third of the returns being something else: circles through ever fewer points.
CylinderPose Start(const std::vector<Eigen::Vector3d>& points) {
  constexpr int kRounds = 12;
  std::vector<char> counts(points.size(), 1);
  CylinderPose pose;
  for (int round = 0; round < kRounds; ++round) {
    pose = CircleThrough(points, counts);
    std::vector<double> off(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      off[k] = std::abs((points[k].head<2>() - Eigen::Vector2d(pose.x_mm, pose.y_mm)).norm() - pose.radius_mm);
    }
    const double limit = 3.0 * std::max(kNormal * Median(off), 0.1);
    for (std::size_t k = 0; k < points.size(); ++k) counts[k] = off[k] <= limit ? 1 : 0;
  }
  return pose;
}

/// Whether what the centre sees leaves no gap of two thirds of a turn.
bool CoversAnArc(const std::vector<Eigen::Vector3d>& points, const CylinderPose& pose) {
  std::vector<double> angles;
  for (const Eigen::Vector3d& point : points)
    angles.push_back(std::atan2(point.y() - pose.y_mm, point.x() - pose.x_mm));
  std::sort(angles.begin(), angles.end());
  double gap = angles.front() + kTwoPi - angles.back();
  for (std::size_t k = 1; k < angles.size(); ++k) gap = std::max(gap, angles[k] - angles[k - 1]);
  return gap < 2.0 / 3.0 * kTwoPi;
}

/// Derivative of the predicted distance: moving the surface by δ along its normal n moves the hit by δ / (n·u).
Vector5 JacobianOf(const CylinderHit& hit, const Ray& ray) {
  const double facing = hit.normal.dot(ray.direction);  // < 0
  Vector5 jacobian;
  jacobian << hit.normal.x(), hit.normal.y(), hit.normal.x() * hit.foot_height_mm, hit.normal.y() * hit.foot_height_mm,
      1.0;
  return jacobian / facing;
}

/// One fit: normal equations and steps of the pose.
class CylinderFitter {
 public:
  CylinderFitter(const std::vector<CylinderReturn>& returns, const CylinderFitOptions& options)
      : returns_(returns), options_(options) {}

  Result<CylinderFitSummary> Fit() {
    RETURN_IF_ERROR(Begin());
    for (; summary_.iterations < options_.max_iterations && !summary_.converged; ++summary_.iterations) {
      Measure();
      if (!Step()) return Fail(kAttempted, "the returns do not determine it", "scan it over more than one height");
    }
    Measure();
    summary_.covariance *= summary_.sigma_mm * summary_.sigma_mm;
    return summary_;
  }

 private:
  Status Begin() {
    std::vector<Eigen::Vector3d> points;
    for (const CylinderReturn& one : returns_) {
      points.push_back(one.ray.origin + one.distance_mm * one.ray.direction);
      if (!points.back().allFinite()) return Fail(kAttempted, "a return is not a number", "leave out missing returns");
    }
    if (points.size() < kFewestReturns) {
      return Fail(kAttempted, std::to_string(points.size()) + " returns", "scan it where the ring passes it");
    }
    summary_.pose = Start(points);
    if (!CoversAnArc(points, summary_.pose)) {
      return Fail(kAttempted, "it is seen from one side only", "place it near the middle of the ring");
    }
    double sum_z = 0.0;
    for (const Eigen::Vector3d& point : points) sum_z += point.z();
    summary_.pose.z_reference_mm = sum_z / static_cast<double>(points.size());
    if (options_.known_radius_mm) summary_.pose.radius_mm = *options_.known_radius_mm;
    summary_.residuals_mm.resize(points.size());
    hits_.resize(points.size());
    return {};
  }

  /// Residuals and their scale at the pose.
  void Measure() {
    std::vector<double> magnitudes;
    for (std::size_t k = 0; k < returns_.size(); ++k) {
      hits_[k] = CastOnCylinder(summary_.pose, returns_[k].ray);
      summary_.residuals_mm[k] =
          hits_[k] ? returns_[k].distance_mm - hits_[k]->distance_mm : std::numeric_limits<double>::quiet_NaN();
      if (hits_[k]) magnitudes.push_back(std::abs(summary_.residuals_mm[k]));
    }
    summary_.sigma_mm = magnitudes.empty() ? 0.0 : kNormal * Median(std::move(magnitudes));
  }

  /// Gauss-Newton on the reweighted residuals. False if the normal equations are singular.
  bool Step() {
    const double scale = options_.cut * std::max(summary_.sigma_mm, options_.smallest_sigma_mm);
    Matrix5 normal = Matrix5::Zero();
    Vector5 right = Vector5::Zero();
    summary_.used = 0;
    for (std::size_t k = 0; k < returns_.size(); ++k) {
      if (!hits_[k]) continue;
      const double share = summary_.residuals_mm[k] / scale;
      if (!(std::abs(share) < 1.0)) continue;
      const double weight = (1.0 - share * share) * (1.0 - share * share);
      const Vector5 jacobian = JacobianOf(*hits_[k], returns_[k].ray);
      normal += weight * jacobian * jacobian.transpose();
      right += weight * summary_.residuals_mm[k] * jacobian;
      ++summary_.used;
    }
    return summary_.used >= kFewestReturns && Apply(normal, right);
  }

  bool Apply(const Matrix5& normal, const Vector5& right) {
    const Eigen::Index free = options_.known_radius_mm ? 4 : 5;
    // In units in which every parameter moves the surface by about as much.
    const Eigen::VectorXd size = normal.diagonal().head(free).cwiseSqrt();
    if (!(size.minCoeff() > 0.0)) return false;
    const Eigen::MatrixXd scaled =
        size.cwiseInverse().asDiagonal() * normal.topLeftCorner(free, free) * size.cwiseInverse().asDiagonal();
    const Eigen::LDLT<Eigen::MatrixXd> solver(scaled);
    if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-9)) return false;
    const Eigen::VectorXd step =
        size.cwiseInverse().cwiseProduct(solver.solve(size.cwiseInverse().cwiseProduct(right.head(free))));
    CylinderPose& pose = summary_.pose;
    pose.x_mm += step(0);
    pose.y_mm += step(1);
    pose.slope_x += step(2);
    pose.slope_y += step(3);
    if (free == 5) pose.radius_mm += step(4);
    if (!step.allFinite() || !(pose.radius_mm > 0.0)) return false;
    summary_.covariance.topLeftCorner(free, free) = size.cwiseInverse().asDiagonal() *
                                                    solver.solve(Eigen::MatrixXd::Identity(free, free)) *
                                                    size.cwiseInverse().asDiagonal();
    const double height = 1000.0;  // mm; over which a slope is judged
    summary_.converged = step.head(2).cwiseAbs().maxCoeff() < kConvergedMm &&
                         height * step.segment(2, 2).cwiseAbs().maxCoeff() < kConvergedMm &&
                         (free == 4 || std::abs(step(4)) < kConvergedMm);
    return true;
  }

  const std::vector<CylinderReturn>& returns_;
  const CylinderFitOptions& options_;
  CylinderFitSummary summary_;
  std::vector<std::optional<CylinderHit>> hits_;
};

}  // namespace

double CylinderPose::tilt() const { return std::atan(std::hypot(slope_x, slope_y)); }

std::optional<CylinderHit> CastOnCylinder(const CylinderPose& pose, const Ray& ray) {
  const Eigen::Vector3d axis = Eigen::Vector3d(pose.slope_x, pose.slope_y, 1.0).normalized();
  const Eigen::Vector3d from_axis = ray.origin - Eigen::Vector3d(pose.x_mm, pose.y_mm, pose.z_reference_mm);
  const Eigen::Vector3d across = from_axis - from_axis.dot(axis) * axis;
  const Eigen::Vector3d way = ray.direction - ray.direction.dot(axis) * axis;
  const double a = way.squaredNorm();
  const double b = across.dot(way);
  const double c = across.squaredNorm() - pose.radius_mm * pose.radius_mm;
  const double discriminant = b * b - a * c;
  if (!(discriminant > 0.0) || !(c > 0.0) || b >= 0.0) return std::nullopt;
  const double distance = c / (-b + std::sqrt(discriminant));
  const Eigen::Vector3d normal = (across + distance * way) / pose.radius_mm;
  const double along = (from_axis + distance * ray.direction).dot(axis);
  return CylinderHit{distance, normal, along * axis.z()};
}

Result<CylinderFitSummary> FitCylinder(const std::vector<CylinderReturn>& returns, const CylinderFitOptions& options) {
  ENSURE(options.smallest_sigma_mm > 0.0 && options.cut > 0.0, "a robust fit has a scale");
  ENSURE(!options.known_radius_mm || *options.known_radius_mm > 0.0, "a cylinder has a radius");
  return CylinderFitter(returns, options).Fit();
}

}  // namespace annulus
