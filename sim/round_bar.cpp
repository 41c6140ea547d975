#include "sim/round_bar.h"

#include <Eigen/Geometry>
#include <cmath>

namespace annulus::sim {
namespace {

// Nearest entry of the ray into the ball, if the origin is outside.
std::optional<SubjectHit> CastBall(const Ray& ray, const Eigen::Vector3d& centre, double radius) {
  const Eigen::Vector3d to_centre = centre - ray.origin;
  const double along = to_centre.dot(ray.direction);
  const double discriminant = radius * radius - (to_centre - along * ray.direction).squaredNorm();
  if (discriminant < 0.0) return std::nullopt;
  const double distance = along - std::sqrt(discriminant);
  if (distance < 0.0) return std::nullopt;
  return SubjectHit{distance, (ray.origin + distance * ray.direction - centre) / radius, 1.0};
}

// Nearest entry into the mantle of a cylinder between its two end planes.
std::optional<SubjectHit> CastMantle(const Ray& ray, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                     double radius) {
  const Eigen::Vector3d axis = (to - from).normalized();
  const Eigen::Vector3d d = ray.direction - axis * ray.direction.dot(axis);
  const Eigen::Vector3d o = (ray.origin - from) - axis * (ray.origin - from).dot(axis);
  const double a = d.squaredNorm();
  if (a < 1e-18) return std::nullopt;  // along the axis: the end balls are met instead
  const double half_b = d.dot(o);
  const double discriminant = half_b * half_b - a * (o.squaredNorm() - radius * radius);
  if (discriminant < 0.0) return std::nullopt;
  const double distance = (-half_b - std::sqrt(discriminant)) / a;
  const Eigen::Vector3d p = ray.origin + distance * ray.direction;
  const double height = (p - from).dot(axis);
  if (distance < 0.0 || height < 0.0 || height > (to - from).norm()) return std::nullopt;
  return SubjectHit{distance, (p - from - axis * height) / radius, 1.0};
}

}  // namespace

std::optional<SubjectHit> Nearer(const std::optional<SubjectHit>& a, const std::optional<SubjectHit>& b) {
  if (!a) return b;
  if (!b) return a;
  return a->distance_mm <= b->distance_mm ? a : b;
}

std::optional<SubjectHit> CastRoundBar(const Ray& ray, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                       double radius_mm) {
  return Nearer(CastMantle(ray, from, to, radius_mm),
                Nearer(CastBall(ray, from, radius_mm), CastBall(ray, to, radius_mm)));
}

}  // namespace annulus::sim
