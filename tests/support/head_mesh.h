#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/units.h"
#include "modeling/mesh/triangle_mesh.h"
#include "sim/parametric_body.h"
#include "tests/support/radius_about_axis.h"

namespace annulus::test {

/// The skin of a subject of one tube as a closed mesh of about 2 · columns · rows triangles, straight from the
/// simulated shape: rows of even height from 1 mm below the crown to 262 mm further down. Vertices lie on the skin.
inline TriangleMesh HeadMesh(const sim::ParametricBody& head, std::uint32_t columns, std::uint32_t rows) {
  const double top = head.top_mm() - 1.0;
  const double bottom = std::max(top - 262.0, head.bottom_mm() + 2.0);
  TriangleMesh mesh;
  for (std::uint32_t row = 0; row <= rows; ++row) {
    const double z = top + (bottom - top) * row / rows;
    for (std::uint32_t column = 0; column < columns; ++column) {
      const double theta = kTwoPi * column / columns;
      const double radius = RadiusAboutAxis(head, theta, z);
      mesh.vertices.emplace_back(radius * std::cos(theta), radius * std::sin(theta), z);
    }
  }
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t a = row * columns + column;
      const std::uint32_t b = row * columns + (column + 1) % columns;
      mesh.faces.push_back({a, a + columns, b});
      mesh.faces.push_back({b, a + columns, b + columns});
    }
  }
  const auto fan = [&](std::uint32_t row, double z, bool upwards) {
    const auto centre = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.emplace_back(0.0, 0.0, z);
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t a = row * columns + column;
      const std::uint32_t b = row * columns + (column + 1) % columns;
      mesh.faces.push_back(upwards ? std::array<std::uint32_t, 3>{a, b, centre}
                                   : std::array<std::uint32_t, 3>{b, a, centre});
    }
  };
  fan(0, top, true);
  fan(rows, bottom, false);
  return mesh;
}

}  // namespace annulus::test
