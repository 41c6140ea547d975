#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "modeling/mesh/triangle_mesh.h"

namespace annulus::bench {

/// A sphere of 2·columns·rows triangles about the origin, radius 100 mm.
inline TriangleMesh Sphere(std::uint32_t columns, std::uint32_t rows) {
  TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= rows; ++j) {
    const double polar = std::numbers::pi * j / rows;
    for (std::uint32_t i = 0; i < columns; ++i) {
      const double theta = 2.0 * std::numbers::pi * i / columns;
      mesh.vertices.emplace_back(100.0 * std::sin(polar) * std::cos(theta), 100.0 * std::sin(polar) * std::sin(theta),
                                 100.0 * std::cos(polar));
    }
  }
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t a = j * columns + i;
      const std::uint32_t b = j * columns + (i + 1) % columns;
      mesh.faces.push_back({a, a + columns, b});
      mesh.faces.push_back({b, a + columns, b + columns});
    }
  }
  return mesh;
}

}  // namespace annulus::bench
