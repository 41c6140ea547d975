#include "sim/space_noise.h"

#include <cstdint>

namespace annulus::sim {
namespace {

// [0, 1) from a cell of space; the finaliser of splitmix64 (Steele, Lea and Flood, 2014).
double HashCell(std::int64_t x, std::int64_t y, std::int64_t z) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL +
                    static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FULL +
                    static_cast<std::uint64_t>(z) * 0x165667B19E3779F9ULL;
  h = (h ^ (h >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  h = (h ^ (h >> 27U)) * 0x94D049BB133111EBULL;
  return static_cast<double>((h ^ (h >> 31U)) >> 11U) * 0x1p-53;
}

}  // namespace

double SpaceNoise(const Eigen::Vector3d& place) {
  const Eigen::Vector3d cell = place.array().floor();
  const Eigen::Vector3d share = place - cell;
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i step(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1);
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) weight *= step[axis] == 1 ? share[axis] : 1.0 - share[axis];
    sum += weight * HashCell(static_cast<std::int64_t>(cell.x()) + step.x(),
                             static_cast<std::int64_t>(cell.y()) + step.y(),
                             static_cast<std::int64_t>(cell.z()) + step.z());
  }
  return sum;
}

}  // namespace annulus::sim
