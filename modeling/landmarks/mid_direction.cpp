#include "modeling/landmarks/mid_direction.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "modeling/measure/section_sampler.h"

namespace annulus {

double MidDirection(const MeasuredSurface& body, double toward, double z) {
  const std::vector<Eigen::Vector2d> points = SectionSampler(body.surface(), EvenDirections(180)).Points(z);
  const Eigen::Vector2d sideways(-std::sin(toward), std::cos(toward));
  const double aside = Centroid(points).dot(sideways);
  double theta = toward;
  // r(theta) sin(theta - toward) = aside: a few steps, since the centroid is near the axis.
  for (int k = 0; k < 10; ++k) {
    const double radius = body.surface().Radius(theta, z);
    theta = toward + std::asin(std::clamp(aside / std::max(radius, 1.0), -0.9, 0.9));
  }
  return theta;
}

}  // namespace annulus
