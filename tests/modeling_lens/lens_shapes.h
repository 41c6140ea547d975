#pragma once

#include <cmath>
#include <cstddef>

#include "base/units.h"
#include "modeling/glasses/lens_outline.h"

namespace annulus::test {

/// An ellipse of `a` × `b` mm about `centre`, points at equal parameters: its box is exact where `count` is a multiple
/// of 4. A circle is an ellipse.
inline LensOutline Ellipse(double a, double b, std::size_t count = 360,
                           const Eigen::Vector2d& centre = Eigen::Vector2d::Zero()) {
  LensOutline outline;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = kTwoPi * static_cast<double>(i) / static_cast<double>(count);
    outline.points.emplace_back(centre.x() + a / 2.0 * std::cos(t), centre.y() + b / 2.0 * std::sin(t));
  }
  return outline;
}

/// A rectangle of `a` × `b` mm about the origin with `per_side` points a side.
inline LensOutline Rectangle(double a, double b, std::size_t per_side = 40) {
  LensOutline outline;
  const Eigen::Vector2d corners[4] = {{a / 2, -b / 2}, {a / 2, b / 2}, {-a / 2, b / 2}, {-a / 2, -b / 2}};
  for (std::size_t side = 0; side < 4; ++side) {
    for (std::size_t i = 0; i < per_side; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(per_side);
      outline.points.emplace_back((1.0 - share) * corners[side] + share * corners[(side + 1) % 4]);
    }
  }
  return outline;
}

}  // namespace annulus::test
