#include "modeling/measure/unresolved_length.h"

#include <cmath>

namespace annulus {
namespace {

double At(const RadiusRow& row, const Eigen::VectorXd& coefficients) {
  double value = 0.0;
  for (std::size_t k = 0; k < row.index.size(); ++k) {
    value += row.value[k] * coefficients[static_cast<Eigen::Index>(row.index[k])];
  }
  return value;
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
      const double level = tangents[k].head<2>().squaredNorm();
      sum += 0.5 * level * (change.squaredNorm() - along * along) / step;
    }
  }
  return sum / static_cast<double>(deviations.size());
}

double UnresolvedHullLength(const MeasuredSurface& body, const SectionSampler& sampler, double z) {
  const std::vector<Eigen::VectorXd>& deviations = body.Deviations();
  if (deviations.empty()) return 0.0;
  const SplineSurface& surface = body.surface();
  const CubicBasis at_z = surface.z_basis().At(z);
  const auto section = [&](const Eigen::VectorXd& coefficients) {
    return SectionCoefficients(surface, at_z, at_z.value, coefficients);
  };
  const auto hull = [&](const Eigen::VectorXd& of) { return TapeLength(sampler.PointsOf(of)); };
  const Eigen::VectorXd fitted = section(surface.coefficients());
  double sum = 0.0;
  for (const Eigen::VectorXd& deviation : deviations) {
    const Eigen::VectorXd moved = section(deviation);
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
