#pragma once

#include <array>
#include <cstddef>

namespace annulus {

/// The four cubic B-splines N_{i,4} that are not zero between knots[2] and knots[3], at x, by the Cox–de Boor
/// recurrence. The other knots may repeat their neighbours (ends of an open spline); knots[2] < knots[3] is required.
/// T is double or a ceres::Jet, so that values can be differentiated with respect to knots and x.
template <class T>
std::array<T, 4> LocalCubicBasis(const std::array<T, 6>& knots, const T& x) {
  // Row of order r holds splines over knots[3 - r + k] … knots[3 + k], k = 0 … r - 1.
  std::array<T, 4> n{T(1.0), T(0.0), T(0.0), T(0.0)};
  for (std::size_t order = 2; order <= 4; ++order) {
    std::array<T, 4> next{T(0.0), T(0.0), T(0.0), T(0.0)};
    for (std::size_t k = 0; k + 1 < order; ++k) {
      const T& from = knots[4 - order + k];
      const T& to = knots[3 + k];
      const T share = n[k] / (to - from);
      next[k] += (to - x) * share;
      next[k + 1] += (x - from) * share;
    }
    n = next;
  }
  return n;
}

/// Second derivatives of the same four splines at x.
template <class T>
std::array<T, 4> LocalCubicSecond(const std::array<T, 6>& knots, const T& x) {
  // Order 2 at x, then N'' = 3·2·(differences over differences), twice the derivative formula of B-splines.
  const T width = knots[3] - knots[2];
  std::array<T, 2> linear{(knots[3] - x) / width, (x - knots[2]) / width};
  std::array<T, 3> first_of_order_3{T(0.0), T(0.0), T(0.0)};
  for (std::size_t k = 0; k < 2; ++k) {
    const T share = 2.0 * linear[k] / (knots[3 + k] - knots[1 + k]);
    first_of_order_3[k] -= share;
    first_of_order_3[k + 1] += share;
  }
  std::array<T, 4> second{T(0.0), T(0.0), T(0.0), T(0.0)};
  for (std::size_t k = 0; k < 3; ++k) {
    const T share = 3.0 * first_of_order_3[k] / (knots[3 + k] - knots[k]);
    second[k] -= share;
    second[k + 1] += share;
  }
  return second;
}

}  // namespace annulus
