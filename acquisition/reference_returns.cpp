#include "acquisition/reference_returns.h"

#include <algorithm>
#include <cmath>

namespace annulus {

std::vector<ReferenceReturn> ReferenceReturns(const Scan& scan) {
  std::vector<ReferenceReturn> returns;
  if (!scan.header.reference) return returns;
  std::vector<Ray> rays;
  for (const ReferenceSensor& sensor : scan.header.reference->sensors) rays.push_back(RayOf(sensor));
  for (const ScanLevel& level : scan.levels) {
    for (std::size_t i = 0; i < std::min(rays.size(), level.reference.size()); ++i) {
      const RangeReading& reading = level.reference[i];
      if (!std::isfinite(reading.range_mm) || reading.range_mm <= 0.0) continue;
      const Eigen::Vector3d end = rays[i].origin + reading.range_mm * rays[i].direction;
      if (end.head<2>().norm() >= scan.header.ring_radius_mm) continue;
      returns.push_back({level.reference_time, i, rays[i], reading.range_mm, reading.quality});
    }
  }
  return returns;
}

}  // namespace annulus
