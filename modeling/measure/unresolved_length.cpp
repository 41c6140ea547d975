#include "modeling/measure/unresolved_length.h"

#include <cmath>

#include "modeling/mesh/convex_hull_2d.h"

namespace annulus {
namespace {

double At(const RadiusRow& row, const Eigen::VectorXd& coefficients) {
  double value = 0.0;
  for (std::size_t k = 0; k < row.index.size(); ++k) {
    value += row.value[k] * coefficients[static_cast<Eigen::Index>(row.index[k])];
  }
  return value;
}

/// The coefficients of the section at z as a periodic spline over theta.
Eigen::VectorXd SectionCoefficients(const SplineSurface& surface, const CubicBasis& at_z,
                                    const Eigen::VectorXd& coefficients) {
  const auto width = static_cast<Eigen::Index>(surface.theta_basis().count());
  Eigen::VectorXd section = Eigen::VectorXd::Zero(width);
  for (std::size_t j = 0; j < 4; ++j) {
    section += at_z.value[j] * coefficients.segment(static_cast<Eigen::Index>(at_z.index[j]) * width, width);
  }
  return section;
}

/// The unit tangents of a path's edges; zero where points coincide.
std::vector<Eigen::Vector3d> Tangents(const std::vector<PathPoint>& path, std::size_t edges) {
  std::vector<Eigen::Vector3d> tangents;
  for (std::size_t k = 0; k < edges; ++k) {
    tangents.push_back((path[(k + 1) % path.size()].position - path[k].position).stableNormalized());
  }
  return tangents;
}

}  // namespace

double UnresolvedLength(const MeasuredSurface& body, const std::vector<PathPoint>& path, PathEnds ends) {
  const std::vector<Eigen::VectorXd>& deviations = body.Deviations();
  if (deviations.empty() || path.size() < 2) return 0.0;
  const std::size_t edges = ends == PathEnds::kClosed ? path.size() : path.size() - 1;
  const std::vector<Eigen::Vector3d> tangents = Tangents(path, edges);
  std::vector<RadiusRow> rows;
  for (const PathPoint& point : path) rows.push_back(body.surface().Row(point.place.theta, point.place.z));
  double sum = 0.0;
  for (const Eigen::VectorXd& deviation : deviations) {
    std::vector<Eigen::Vector3d> moved;
    for (std::size_t k = 0; k < path.size(); ++k) moved.emplace_back(At(rows[k], deviation) * path[k].by_radius);
    for (std::size_t k = 0; k < edges; ++k) {
      const std::size_t next = (k + 1) % path.size();
      const double step = (path[next].position - path[k].position).norm();
      if (step == 0.0) continue;
      const Eigen::Vector3d change = moved[next] - moved[k];
      const double along = change.dot(tangents[k]);
      sum += 0.5 * (change.squaredNorm() - along * along) / step;
    }
  }
  return sum / static_cast<double>(deviations.size());
}

double UnresolvedHullLength(const MeasuredSurface& body, const std::vector<double>& thetas, double z) {
  const std::vector<Eigen::VectorXd>& deviations = body.Deviations();
  if (deviations.empty()) return 0.0;
  const SplineSurface& surface = body.surface();
  const CubicBasis at_z = surface.z_basis().At(z);
  std::vector<CubicBasis> around;
  std::vector<Eigen::Vector2d> directions;
  for (const double theta : thetas) {
    around.push_back(surface.theta_basis().At(theta));
    directions.emplace_back(std::cos(theta), std::sin(theta));
  }
  std::vector<Eigen::Vector2d> points(thetas.size());
  const auto hull = [&](const Eigen::VectorXd& section) {
    for (std::size_t k = 0; k < thetas.size(); ++k) {
      double radius = 0.0;
      for (std::size_t i = 0; i < 4; ++i) {
        radius += around[k].value[i] * section[static_cast<Eigen::Index>(around[k].index[i])];
      }
      points[k] = radius * directions[k];
    }
    return ConvexHullPerimeter(points);
  };
  const Eigen::VectorXd fitted = SectionCoefficients(surface, at_z, surface.coefficients());
  double sum = 0.0;
  for (const Eigen::VectorXd& deviation : deviations) {
    const Eigen::VectorXd moved = SectionCoefficients(surface, at_z, deviation);
    sum += 0.5 * (hull(fitted + moved) + hull(fitted - moved));
  }
  return sum / static_cast<double>(deviations.size()) - hull(fitted);
}

Estimate WithUnresolved(const Estimate& length, double unresolved) {
  Estimate estimate = length;
  estimate.value += unresolved;
  estimate.unresolved += std::abs(unresolved);
  return estimate;
}

}  // namespace annulus
