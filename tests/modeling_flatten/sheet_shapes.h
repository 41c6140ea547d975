#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "modeling/mesh/triangle_mesh.h"

namespace annulus::test {

/// A cap of a sphere about +z: `rings` rings of triangles out to the angle `reach` (rad) from the pole, six more points
/// on each ring than on the one within.
inline TriangleMesh Cap(double radius, double reach, std::uint32_t rings) {
  TriangleMesh mesh;
  const auto first_of = [](std::uint32_t ring) { return ring == 0 ? 0U : 1U + 3U * ring * (ring - 1U); };
  for (std::uint32_t ring = 0; ring <= rings; ++ring) {
    const std::uint32_t count = ring == 0 ? 1U : 6U * ring;
    const double polar = reach * ring / rings;
    for (std::uint32_t k = 0; k < count; ++k) {
      const double turn = 2.0 * std::numbers::pi * k / count;
      mesh.vertices.emplace_back(radius * Eigen::Vector3d(std::sin(polar) * std::cos(turn),
                                                          std::sin(polar) * std::sin(turn), std::cos(polar)));
    }
  }
  for (std::uint32_t ring = 1; ring <= rings; ++ring) {
    const auto outer = [&](std::uint32_t k) { return first_of(ring) + k % (6U * ring); };
    const auto inner = [&](std::uint32_t k) { return ring == 1 ? 0U : first_of(ring - 1) + k % (6U * (ring - 1)); };
    for (std::uint32_t sector = 0; sector < 6; ++sector) {
      for (std::uint32_t k = 0; k < ring; ++k) {
        const std::uint32_t out = sector * ring + k;
        const std::uint32_t in = sector * (ring - 1) + k;
        mesh.faces.push_back({outer(out), outer(out + 1), inner(in)});
        if (k + 1 < ring) mesh.faces.push_back({inner(in), outer(out + 1), inner(in + 1)});
      }
    }
  }
  return mesh;
}

/// The length of a rim that lies flat over its length on the body, less 1.
template <class Points, class Places>
double RimStrain(const std::vector<std::uint32_t>& rim, const Points& flat, const Places& places) {
  double drawn = 0.0;
  double own = 0.0;
  for (std::size_t k = 0; k < rim.size(); ++k) {
    const std::size_t next = (k + 1) % rim.size();
    drawn += (flat[rim[next]] - flat[rim[k]]).norm();
    own += (places[rim[next]] - places[rim[k]]).norm();
  }
  return drawn / own - 1.0;
}

}  // namespace annulus::test
