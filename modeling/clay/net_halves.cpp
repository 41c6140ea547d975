#include "modeling/clay/net_halves.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "modeling/clay/clay_mesh.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;
using Halves = std::array<Vector3d, 7>;

/// The control points of both halves of a curve; the middle one is theirs in common. Every sum is one of two numbers,
/// so that the curve run the other way gives the same bits.
Halves HalvesOf(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d ab = 0.5 * (a + b);
  const Vector3d bc = 0.5 * (b + c);
  const Vector3d cd = 0.5 * (c + d);
  const Vector3d abc = 0.5 * (ab + bc);
  const Vector3d bcd = 0.5 * (bc + cd);
  return {a, ab, abc, 0.5 * (abc + bcd), bcd, cd, d};
}

}  // namespace

std::array<ControlNet, 4> QuarterNets(const ControlNet& net) {
  std::array<Halves, 4> rows;
  for (std::size_t i = 0; i < 4; ++i) rows[i] = HalvesOf(net[i][0], net[i][1], net[i][2], net[i][3]);
  std::array<std::array<Vector3d, 7>, 7> grid;
  for (std::size_t j = 0; j < 7; ++j) {
    const Halves column = HalvesOf(rows[0][j], rows[1][j], rows[2][j], rows[3][j]);
    for (std::size_t i = 0; i < 7; ++i) grid[i][j] = column[i];
  }
  std::array<ControlNet, 4> quarters;
  for (std::size_t c = 0; c < 4; ++c) {
    const std::size_t i0 = c == 1 || c == 2 ? 3 : 0;
    const std::size_t j0 = c >= 2 ? 3 : 0;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) quarters[c][i][j] = grid[i0 + i][j0 + j];
    }
  }
  return quarters;
}

ControlNet WholeNet(const std::array<ControlNet, 4>& quarters) {
  ControlNet whole;
  for (std::size_t c = 0; c < 4; ++c) {
    const auto at = [&](std::size_t along, std::size_t inward) {
      const auto [i, j] = NetIndex(c, along, inward);
      return quarters[c][i][j];
    };
    const Vector3d corner = at(0, 0);
    const Vector3d along = at(1, 0) - corner;
    const Vector3d inward = at(0, 1) - corner;
    const Vector3d twist = at(1, 1) - corner - along - inward;
    const auto set = [&](std::size_t s, std::size_t t, const Vector3d& point) {
      const auto [i, j] = NetIndex(c, s, t);
      whole[i][j] = point;
    };
    set(0, 0, corner);
    set(1, 0, corner + 2.0 * along);
    set(0, 1, corner + 2.0 * inward);
    set(1, 1, corner + 2.0 * (along + inward) + 4.0 * twist);
  }
  return whole;
}

double LargestDistance(const std::array<ControlNet, 4>& a, const std::array<ControlNet, 4>& b) {
  double largest = 0.0;
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) largest = std::max(largest, (a[c][i][j] - b[c][i][j]).squaredNorm());
    }
  }
  return std::sqrt(largest);
}

}  // namespace annulus
