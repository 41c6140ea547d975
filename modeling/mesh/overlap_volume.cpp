#include "modeling/mesh/overlap_volume.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>

#include "base/ensure.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Where a line enters (+1) or leaves (-1) a mesh.
struct Crossing {
  std::int64_t column;
  double y;
  int turn;

  [[nodiscard]] bool operator<(const Crossing& other) const {
    return std::tie(column, y, turn) < std::tie(other.column, other.y, other.turn);
  }
};

/// Twice the signed area of a, b and the line at (x, z), in the x–z plane. The same bits for b, a, but for the sign, so
/// that a line through an edge meets one of its two triangles.
double Side(const Vector3d& a, const Vector3d& b, double x, double z) {
  if (std::pair(b.x(), b.z()) < std::pair(a.x(), a.z())) return -Side(b, a, x, z);
  return (b.x() - a.x()) * (z - a.z()) - (b.z() - a.z()) * (x - a.x());
}

/// Lines of a grid through (x0, z0).
struct LineGrid {
  double x0;
  double z0;
  double pitch;
  std::int64_t rows;

  [[nodiscard]] std::int64_t FirstAt(double value, double origin) const {
    return static_cast<std::int64_t>(std::ceil((value - origin) / pitch));
  }
  [[nodiscard]] std::int64_t LastAt(double value, double origin) const {
    return static_cast<std::int64_t>(std::floor((value - origin) / pitch));
  }

  void Cross(const Vector3d& a, const Vector3d& b, const Vector3d& c, std::vector<Crossing>& crossings) const {
    const auto [x_low, x_high] = std::minmax({a.x(), b.x(), c.x()});
    const auto [z_low, z_high] = std::minmax({a.z(), b.z(), c.z()});
    for (std::int64_t i = FirstAt(x_low, x0); i <= LastAt(x_high, x0); ++i) {
      for (std::int64_t k = FirstAt(z_low, z0); k <= LastAt(z_high, z0); ++k) {
        const double x = x0 + static_cast<double>(i) * pitch;
        const double z = z0 + static_cast<double>(k) * pitch;
        const double wa = Side(b, c, x, z);
        const double wb = Side(c, a, x, z);
        const double wc = Side(a, b, x, z);
        const bool front = wa >= 0.0 && wb >= 0.0 && wc >= 0.0;
        const bool back = wa < 0.0 && wb < 0.0 && wc < 0.0;
        const double sum = wa + wb + wc;
        if ((!front && !back) || sum == 0.0) continue;
        // Counter-clockwise in (x, z) is a normal towards -y: the line goes in there.
        crossings.push_back({i * rows + k, (wa * a.y() + wb * b.y() + wc * c.y()) / sum, front ? 1 : -1});
      }
    }
  }
};

}  // namespace

double OverlapVolume(const std::vector<TriangleMesh>& meshes, double pitch) {
  ENSURE(pitch > 0.0, "a grid has a pitch");
  Vector3d low = Vector3d::Constant(1e300);
  Vector3d high = -low;
  for (const TriangleMesh& mesh : meshes) {
    for (const Vector3d& p : mesh.vertices) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  // Off the corner by no round share, so that lines rarely meet what the designer placed on round numbers.
  const LineGrid grid{low.x() - 0.381966 * pitch, low.z() - 0.618034 * pitch, pitch,
                      static_cast<std::int64_t>(std::max(0.0, high.z() - low.z()) / pitch) + 4};
  std::vector<Crossing> crossings;
  for (const TriangleMesh& mesh : meshes) {
    for (const auto& face : mesh.faces) {
      grid.Cross(mesh.vertices[face[0]], mesh.vertices[face[1]], mesh.vertices[face[2]], crossings);
    }
  }
  std::sort(crossings.begin(), crossings.end());
  double length = 0.0;
  int depth = 0;
  for (std::size_t k = 0; k < crossings.size(); ++k) {
    if (k == 0 || crossings[k].column != crossings[k - 1].column) {
      depth = 0;
    } else if (depth > 1) {
      length += (depth - 1) * (crossings[k].y - crossings[k - 1].y);
    }
    depth += crossings[k].turn;
  }
  return length * pitch * pitch;
}

}  // namespace annulus
