#include "fitting/surface_model.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"

namespace annulus {

KnowledgeMap::KnowledgeMap(std::size_t columns, std::size_t rows, double z_min, double z_max)
    : columns_(columns), rows_(rows), z_min_(z_min), z_max_(z_max), cells_(columns * rows, Knowledge::kUnknown) {
  ENSURE(columns >= 1 && rows >= 1 && z_min < z_max, "a knowledge map has cells");
}

Knowledge KnowledgeMap::At(double theta, double z) const {
  if (cells_.empty() || !(z >= z_min_) || !(z <= z_max_)) return Knowledge::kUnknown;
  const double u = std::round(WrapAngle(theta) / kTwoPi * static_cast<double>(columns_));
  const double v = (z - z_min_) / (z_max_ - z_min_) * static_cast<double>(rows_);
  return Cell(static_cast<std::size_t>(u) % columns_, std::min(static_cast<std::size_t>(v), rows_ - 1));
}

Eigen::Vector3d SurfaceSegment::Point(double theta, double z) const {
  Eigen::Vector3d point = surface.Point(theta, z);
  point.head<2>() += axis.At(z);
  return point;
}

}  // namespace annulus
