#include "modeling/wrinkly/surface_nets.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "modeling/wrinkly/control_nets.h"
#include "modeling/wrinkly/quad_mesh.h"
#include "modeling/wrinkly/wrinkly_fit.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Corners nearer than this are one, mm; as PatchShell joins its edges.
constexpr double kWeld = 1e-6;
constexpr int kMostPerPatch = 64;

/// Gives points that are nearly the same one number.
class Welder {
 public:
  explicit Welder(std::vector<Vector3d>& points) : points_(points) {}

  std::uint32_t Number(const Vector3d& point) {
    const std::array<std::int64_t, 3> cell = CellOf(point);
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        for (std::int64_t dz = -1; dz <= 1; ++dz) {
          const auto found = cells_.find({cell[0] + dx, cell[1] + dy, cell[2] + dz});
          if (found != cells_.end() && (points_[found->second] - point).norm() <= kWeld) return found->second;
        }
      }
    }
    points_.push_back(point);
    return cells_[cell] = static_cast<std::uint32_t>(points_.size() - 1);
  }

 private:
  static std::array<std::int64_t, 3> CellOf(const Vector3d& point) {
    std::array<std::int64_t, 3> cell{};
    for (std::size_t k = 0; k < 3; ++k) {
      cell[k] = static_cast<std::int64_t>(std::floor(point[static_cast<Eigen::Index>(k)] / kWeld));
    }
    return cell;
  }

  std::vector<Vector3d>& points_;
  std::map<std::array<std::int64_t, 3>, std::uint32_t> cells_;
};

}  // namespace

Result<ControlMeshParts> NetOfSurface(const SplineSurface& surface, const SurfaceNet& net) {
  const bool in_range = net.z_min < net.z_max && net.z_min >= surface.z_min() && net.z_max <= surface.z_max() &&
                        net.theta_over > 0.0 && std::isfinite(net.theta_from);
  if (net.columns < 3 || net.rows < 3 || !in_range) {
    return Fail("lay a control mesh over the surface",
                fmt::format("it is to have {} columns and {} rows from z = {} to {} mm", net.columns, net.rows,
                            net.z_min, net.z_max),
                fmt::format("use 3 or more of both, within {} to {} mm", surface.z_min(), surface.z_max()));
  }
  const bool around = net.theta_over >= 2.0 * std::numbers::pi - 1e-3;
  auto parts = MakeNet(RegularNet{net.columns, net.rows, around ? AxisKind::kCyclic : AxisKind::kOpen});
  if (!parts) return Fail(parts);
  std::vector<Vector3d> middles;
  for (int row = 0; row < net.rows; ++row) {
    for (int column = 0; column < net.columns; ++column) {
      const double theta =
          net.theta_from + (around ? 2.0 * std::numbers::pi : net.theta_over) * (column + 0.5) / net.columns;
      const double z = net.z_min + (net.z_max - net.z_min) * (row + 0.5) / net.rows;
      middles.push_back(surface.Point(theta, z));
      ControlPoint& point = parts->points[middles.size() - 1];
      point.position = middles.back();
      if (net.top == SurfaceNet::Top::kClosed && row + 1 == net.rows) {
        point.link[1].kind = ControlLink::Kind::kClosed;
      }
    }
  }
  return ThroughMiddles(std::move(*parts), middles);
}

Result<ControlMeshParts> NetOfShell(const PatchShell& shell, int per_patch) {
  if (per_patch < 1 || per_patch > kMostPerPatch) {
    return Fail("lay a control mesh over " + shell.name, fmt::format("{} points per patch are asked for", per_patch),
                fmt::format("use 1 to {}", kMostPerPatch));
  }
  QuadMesh quads;
  Welder welder(quads.vertices);
  std::vector<Vector3d> middles;
  for (const ShellPatch& patch : shell.patches) {
    const auto corner = [&](int i, int j) {
      return welder.Number(patch.patch.Point(static_cast<double>(i) / per_patch, static_cast<double>(j) / per_patch));
    };
    for (int i = 0; i < per_patch; ++i) {
      for (int j = 0; j < per_patch; ++j) {
        quads.quads.push_back({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)});
        middles.push_back(patch.patch.Point((i + 0.5) / per_patch, (j + 0.5) / per_patch));
      }
    }
  }
  auto parts = ControlMeshOfQuads(quads);
  if (!parts) return Fail(parts);
  return ThroughMiddles(std::move(*parts), middles);
}

}  // namespace annulus
