#include "modeling/measure/section_sampler.h"

#include <cmath>
#include <utility>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus {
namespace {

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

SectionSampler::SectionSampler(const SplineSurface& surface, std::vector<double> directions)
    : surface_(&surface), directions_(std::move(directions)) {
  ENSURE(directions_.size() >= 3, "a section has at least three directions");
  for (const double theta : directions_) {
    basis_.push_back(surface.theta_basis().At(theta));
    outward_.emplace_back(std::cos(theta), std::sin(theta));
  }
}

std::vector<Eigen::Vector2d> SectionSampler::Points(double z) const {
  const CubicBasis at_z = surface_->z_basis().At(z);
  return PointsOf(SectionCoefficients(*surface_, at_z, at_z.value, surface_->coefficients()));
}

std::vector<Eigen::Vector2d> SectionSampler::PointsOf(const Eigen::VectorXd& section) const {
  std::vector<Eigen::Vector2d> points;
  points.reserve(directions_.size());
  for (std::size_t k = 0; k < directions_.size(); ++k) {
    double radius = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      radius += basis_[k].value[i] * section[static_cast<Eigen::Index>(basis_[k].index[i])];
    }
    points.emplace_back(radius * outward_[k]);
  }
  return points;
}

Eigen::VectorXd SectionCoefficients(const SplineSurface& surface, const CubicBasis& at_z,
                                    const std::array<double, 4>& weights, const Eigen::VectorXd& coefficients) {
  const auto width = static_cast<Eigen::Index>(surface.theta_basis().count());
  Eigen::VectorXd section = Eigen::VectorXd::Zero(width);
  for (std::size_t j = 0; j < 4; ++j) {
    section += weights[j] * coefficients.segment(static_cast<Eigen::Index>(at_z.index[j]) * width, width);
  }
  return section;
}

std::vector<double> EvenDirections(std::size_t count) {
  std::vector<double> directions;
  for (std::size_t k = 0; k < count; ++k) {
    directions.push_back(kTwoPi * static_cast<double>(k) / static_cast<double>(count));
  }
  return directions;
}

std::vector<std::size_t> HullOfSection(const std::vector<Eigen::Vector2d>& points) {
  // Graham's scan: the points are sorted about the axis, and the rightmost one is a corner.
  const std::size_t count = points.size();
  std::size_t first = 0;
  for (std::size_t k = 1; k < count; ++k) {
    if (points[k].x() > points[first].x()) first = k;
  }
  std::vector<std::size_t> hull;
  for (std::size_t step = 0; step <= count; ++step) {
    const std::size_t next = (first + step) % count;
    while (hull.size() >= 2) {
      const Eigen::Vector2d& last = points[hull.back()];
      if (Cross(last - points[hull[hull.size() - 2]], points[next] - last) > 0.0) break;
      hull.pop_back();
    }
    if (step < count) hull.push_back(next);
  }
  return hull;
}

double TapeLength(const std::vector<Eigen::Vector2d>& points) {
  const std::vector<std::size_t> hull = HullOfSection(points);
  double length = 0.0;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    length += (points[hull[(k + 1) % hull.size()]] - points[hull[k]]).norm();
  }
  return length;
}

Eigen::Vector2d Centroid(const std::vector<Eigen::Vector2d>& points) {
  double area = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector2d& a = points[k];
    const Eigen::Vector2d& b = points[(k + 1) % points.size()];
    const double twice = Cross(a, b);
    area += twice;
    sum += twice * (a + b) / 3.0;
  }
  return area > 0.0 ? Eigen::Vector2d(sum / area) : Eigen::Vector2d::Zero();
}

}  // namespace annulus
