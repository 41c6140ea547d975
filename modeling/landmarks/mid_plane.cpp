#include "modeling/landmarks/mid_plane.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/frames.h"

namespace annulus {
namespace {

constexpr double kBelowTip = 20.0;
constexpr double kAboveTip = 100.0;
constexpr double kRowStep = 5.0;
constexpr double kReach = RadiansFromDegrees(110.0);
constexpr double kColumnStep = RadiansFromDegrees(6.0);
constexpr double kCauchyScale = 2.0;  // mm
constexpr int kIterations = 12;
constexpr double kConverged = 1e-3;  // of the longest step
constexpr int kCutSteps = 8;

MidPlane Moved(const MidPlane& plane, const Eigen::Vector3d& step) {
  MidPlane moved = plane;
  moved.yaw += step[0];
  moved.offset += step[1];
  moved.lean += step[2];
  return moved;
}

/// How far the mirror images of the head's points stand out of the head, mm.
Eigen::VectorXd Differences(const HeadGrid& grid, const MidPlane& plane, const std::vector<Eigen::Vector3d>& points) {
  const Eigen::Vector3d normal = plane.right() - plane.lean * Eigen::Vector3d::UnitZ();
  const double squared = normal.squaredNorm();
  Eigen::VectorXd differences(static_cast<Eigen::Index>(points.size()));
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3d mirrored = points[k] - (2.0 * plane.Lateral(points[k]) / squared) * normal;
    differences[static_cast<Eigen::Index>(k)] =
        std::hypot(mirrored.x(), mirrored.y()) - grid.Radius(std::atan2(mirrored.y(), mirrored.x()), mirrored.z());
  }
  return differences;
}

double MedianSize(const Eigen::VectorXd& values) {
  std::vector<double> sizes(values.begin(), values.end());
  for (double& size : sizes) size = std::abs(size);
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle;
}

/// How far, as an angle seen from the axis, the plane runs beside the axis where the surface is cut at `theta`.
double BesideAxis(const SplineSurface& surface, const MidPlane& plane, double theta, double z) {
  const double side = plane.offset + plane.lean * (z - plane.z);
  return std::asin(std::clamp(side / std::max(surface.Radius(theta, z), 1.0), -0.9, 0.9));
}

}  // namespace

Eigen::Vector3d MidPlane::forward() const { return {std::cos(yaw), std::sin(yaw), 0.0}; }
Eigen::Vector3d MidPlane::right() const { return {std::sin(yaw), -std::cos(yaw), 0.0}; }
double MidPlane::Lateral(const Eigen::Vector3d& p) const { return right().dot(p) - offset - lean * (p.z() - z); }

double MidPlane::FrontTheta(const SplineSurface& surface, double height) const {
  double theta = yaw;  // the radius hardly changes from step to step
  for (int k = 0; k < kCutSteps; ++k) theta = yaw - BesideAxis(surface, *this, theta, height);
  return theta;
}

double MidPlane::BackTheta(const SplineSurface& surface, double height) const {
  double theta = yaw + kPi;
  for (int k = 0; k < kCutSteps; ++k) theta = yaw + kPi + BesideAxis(surface, *this, theta, height);
  return theta;
}

MidPlane FindMidPlane(const HeadGrid& grid, const Eigen::Vector3d& pronasale) {
  std::vector<Eigen::Vector3d> points;
  const double front = std::atan2(pronasale.y(), pronasale.x());
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (double z = pronasale.z() - kBelowTip; z <= pronasale.z() + kAboveTip; z += kRowStep) {
    for (double theta = front - kReach; theta <= front + kReach; theta += kColumnStep) {
      points.push_back(PointFromCylindrical(theta, grid.Radius(theta, z), z));
    }
    for (int degree = 0; degree < HeadGrid::kFullCircle; ++degree) sum += grid.Point(degree, grid.RowAt(z));
  }
  // The first guess: from the head's middle to the nose.
  const double rows = std::floor((kBelowTip + kAboveTip) / kRowStep) + 1.0;
  const Eigen::Vector3d centre = sum / (rows * HeadGrid::kFullCircle);
  MidPlane plane;
  plane.yaw = std::atan2(pronasale.y() - centre.y(), pronasale.x() - centre.x());
  plane.offset = plane.right().dot(pronasale);
  plane.z = pronasale.z();
  const Eigen::Vector3d steps(1e-4, 1e-2, 1e-4);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Eigen::VectorXd e = Differences(grid, plane, points);
    Eigen::MatrixXd jacobian(e.size(), 3);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = steps[k] * Eigen::Vector3d::Unit(k);
      jacobian.col(k) = (Differences(grid, Moved(plane, step), points) - e) / steps[k];
    }
    const Eigen::VectorXd weight = (1.0 + (e.array() / kCauchyScale).square()).inverse();
    const Eigen::Matrix3d normal = jacobian.transpose() * weight.asDiagonal() * jacobian;
    const Eigen::Vector3d step = -normal.ldlt().solve(jacobian.transpose() * weight.asDiagonal() * e);
    if (!step.allFinite()) break;
    const Eigen::Vector3d bound(RadiansFromDegrees(3.0), 5.0, 0.03);
    plane = Moved(plane, step.cwiseMax(-bound).cwiseMin(bound));
    if ((step.array() / bound.array()).abs().maxCoeff() < kConverged) break;
  }
  plane.spread = MedianSize(Differences(grid, plane, points));
  return plane;
}

}  // namespace annulus
