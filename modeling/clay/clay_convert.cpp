#include "modeling/clay/clay_convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "modeling/elastic/elastic_region.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;

constexpr const char* kAttempted = "make clay of a measured surface";
constexpr std::size_t kPlaces = 5;  ///< Each way, where a leaf is held against the surface.
constexpr std::uint32_t kDeepest = 8;
constexpr double kVolumeError = 1e-7;  ///< Of the volume.

/// Position, slopes by theta and z, and twist of a segment's surface.
struct SurfaceJet {
  Vector3d point, by_theta, by_z, twist;
};

SurfaceJet JetAt(const SurfaceSegment& segment, double theta, double z) {
  const RadiusJet r = segment.surface.Jet(theta, z);
  const Vector3d out(std::cos(theta), std::sin(theta), 0.0);
  const Vector3d around(-out.y(), out.x(), 0.0);
  const Eigen::Vector2d axis = segment.axis.At(z);
  const Eigen::Vector2d lean = segment.axis.slope + 2.0 * (z - segment.axis.z_middle) * segment.axis.bend;
  SurfaceJet jet;
  jet.point = Vector3d(axis.x(), axis.y(), z) + r.r * out;
  jet.by_theta = r.r_theta * out + r.r * around;
  jet.by_z = Vector3d(lean.x(), lean.y(), 1.0) + r.r_z * out;
  jet.twist = r.r_theta_z * out + r.r_z * around;
  return jet;
}

/// The grid of base patches over (theta, z).
struct Grid {
  std::vector<double> theta;  ///< columns + 1, from 0 to 2π.
  std::vector<double> z;      ///< rows + 1.
  [[nodiscard]] std::size_t columns() const { return theta.size() - 1; }
  [[nodiscard]] std::size_t rows() const { return z.size() - 1; }
};

Grid GridOf(const SurfaceSegment& segment) {
  Grid grid;
  const bool refined = segment.hierarchy != nullptr;
  const std::size_t columns =
      refined ? segment.hierarchy->levels().front().theta.count() : segment.surface.theta_basis().count();
  for (std::size_t i = 0; i <= columns; ++i) {
    grid.theta.push_back(2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(columns));
  }
  const ClampedCubicBasis& basis = refined ? segment.hierarchy->levels().front().z : segment.surface.z_basis();
  grid.z.assign(basis.breakpoints().begin(), basis.breakpoints().end());
  return grid;
}

/// Where a leaf lies over (theta, z).
struct Extent {
  double theta, z, width, height;
};

Extent ExtentOf(const Grid& grid, std::size_t base, std::uint32_t level, std::uint32_t column, std::uint32_t row) {
  const std::size_t i = base % grid.columns();
  const std::size_t j = base / grid.columns();
  const double share = 1.0 / static_cast<double>(1U << level);
  const double width = (grid.theta[i + 1] - grid.theta[i]) * share;
  const double height = (grid.z[j + 1] - grid.z[j]) * share;
  return {grid.theta[i] + column * width, grid.z[j] + row * height, width, height};
}

/// Bicubic Hermite: the surface's jets at the four corners, as control points.
ControlNet NetOver(const SurfaceSegment& segment, const Extent& extent) {
  ControlNet net;
  for (std::size_t a = 0; a < 2; ++a) {
    for (std::size_t b = 0; b < 2; ++b) {
      const SurfaceJet jet =
          JetAt(segment, extent.theta + (a == 1 ? extent.width : 0.0), extent.z + (b == 1 ? extent.height : 0.0));
      const double u = (a == 0 ? 1.0 : -1.0) * extent.width / 3.0;
      const double v = (b == 0 ? 1.0 : -1.0) * extent.height / 3.0;
      const std::size_t i = 3 * a;
      const std::size_t j = 3 * b;
      const std::size_t next_i = a == 0 ? 1 : 2;
      const std::size_t next_j = b == 0 ? 1 : 2;
      net[i][j] = jet.point;
      net[next_i][j] = jet.point + u * jet.by_theta;
      net[i][next_j] = jet.point + v * jet.by_z;
      net[next_i][next_j] = jet.point + u * jet.by_theta + v * jet.by_z + u * v * jet.twist;
    }
  }
  return net;
}

/// The flat piece between a base patch's lower (or upper) edge and the axis.
ShellPatch CapPiece(const ControlNet& wall, std::size_t j, const Vector3d& centre) {
  BezierCurve edge;
  BezierCurve middle;
  for (std::size_t i = 0; i < 4; ++i) {
    edge[i] = wall[i][j];
    middle[i] = centre;
  }
  const BezierPatch piece = RuledPatch(edge, middle);
  return {j == 0 ? piece : piece.Flipped(), PatchDetail::kAlong, PatchDetail::kAlong};
}

class Converter {
 public:
  Converter(const SurfaceSegment& segment, double tolerance, std::size_t most_leaves)
      : segment_(segment), grid_(GridOf(segment)), tolerance_(tolerance), most_leaves_(most_leaves) {}

  /// Cut finer until the volume agrees, too: patches lie on one side of what curves.
  Result<ClayOfSurface> Convert() {
    const double wanted = SegmentVolume(segment_);
    for (;;) {
      auto made = ConvertTo(tolerance_);
      if (!made) return made;
      made->volume_error = made->body.volume() / wanted - 1.0;
      if (std::abs(made->volume_error) <= kVolumeError) return made;
      tolerance_ *= 0.25;
    }
  }

 private:
  Result<ClayOfSurface> ConvertTo(double tolerance) {
    auto mesh = ClayMesh::Make(Shell());
    if (!mesh) return Fail(mesh);
    double error = 0.0;
    for (bool cut = true; cut;) {
      error = 0.0;
      std::vector<PatchIndex> far;
      for (PatchIndex index = 0; index < mesh->patches().size(); ++index) {
        if (!IsWall(*mesh, index)) continue;
        const double here = ErrorOf(mesh->patch(index));
        error = std::max(error, here);
        if (!(here <= tolerance) && mesh->patch(index).level < kDeepest) far.push_back(index);
      }
      cut = !far.empty();
      for (const PatchIndex index : far) {
        if (mesh->alive(index)) mesh->Split(index);
      }
      if (mesh->leaf_count() > most_leaves_) {
        return Fail(kAttempted, fmt::format("{:g} mm takes more than {} patches", tolerance, most_leaves_),
                    "allow a greater distance");
      }
      CutCaps(*mesh);
      Sample(*mesh);
      SetRims(*mesh);
    }
    auto body = ClayBody::Make(std::move(*mesh));
    if (!body) return Fail(body);
    return ClayOfSurface{std::move(*body), error, 0.0, grid_.columns(), grid_.rows()};
  }

  [[nodiscard]] bool IsWall(const ClayMesh& mesh, PatchIndex index) const {
    return mesh.alive(index) && mesh.patch(index).base < grid_.columns() * grid_.rows();
  }

  [[nodiscard]] PatchShell Shell() const {
    PatchShell shell{segment_.name, {}};
    for (std::size_t base = 0; base < grid_.columns() * grid_.rows(); ++base) {
      shell.patches.push_back(
          {BezierPatch(NetOver(segment_, ExtentOf(grid_, base, 0, 0, 0))), PatchDetail::kAlong, PatchDetail::kAlong});
    }
    const auto centre = [this](double z) {
      const Eigen::Vector2d axis = segment_.axis.At(z);
      return Vector3d(axis.x(), axis.y(), z);
    };
    const std::size_t last = grid_.columns() * (grid_.rows() - 1);
    for (std::size_t i = 0; i < grid_.columns(); ++i) {
      shell.patches.push_back(CapPiece(shell.patches[i].patch.control_net(), 0, centre(grid_.z.front())));
    }
    for (std::size_t i = 0; i < grid_.columns(); ++i) {
      shell.patches.push_back(CapPiece(shell.patches[last + i].patch.control_net(), 3, centre(grid_.z.back())));
    }
    return shell;
  }

  [[nodiscard]] double ErrorOf(const ClayPatch& leaf) const {
    const Extent extent = ExtentOf(grid_, leaf.base, leaf.level, leaf.column, leaf.row);
    const BezierPatch patch(leaf.net);
    double error = 0.0;
    for (std::size_t n = 0; n < kPlaces * kPlaces; ++n) {
      const double u = (0.5 + static_cast<double>(n % kPlaces)) / static_cast<double>(kPlaces);
      const double v = (0.5 + static_cast<double>(n / kPlaces)) / static_cast<double>(kPlaces);
      const Vector3d on_surface = segment_.Point(extent.theta + u * extent.width, extent.z + v * extent.height);
      error = std::max(error, (patch.Point(u, v) - on_surface).norm());
    }
    return error;
  }

  /// Every leaf of the wall anew from the surface, coarse ones first, with what is slaved to them.
  void Sample(ClayMesh& mesh) const {
    std::vector<PatchIndex> order;
    for (PatchIndex index = 0; index < mesh.patches().size(); ++index) {
      if (IsWall(mesh, index)) order.push_back(index);
    }
    std::stable_sort(order.begin(), order.end(),
                     [&mesh](PatchIndex a, PatchIndex b) { return mesh.patch(a).level < mesh.patch(b).level; });
    const auto net_of = [&mesh](PatchIndex index) -> const ControlNet& { return mesh.patch(index).net; };
    for (const PatchIndex index : order) {
      const ClayPatch& leaf = mesh.patch(index);
      ControlNet net = NetOver(segment_, ExtentOf(grid_, leaf.base, leaf.level, leaf.column, leaf.row));
      mesh.PullSlaves(index, net_of, net);
      mesh.SetNet(index, net);
    }
  }

  /// No cap is coarser than the wall that it meets.
  void CutCaps(ClayMesh& mesh) const {
    for (PatchIndex index = 0; index < mesh.patches().size(); ++index) {
      if (!mesh.alive(index) || IsWall(mesh, index)) continue;
      const bool coarser = std::any_of(
          mesh.patch(index).join.begin(), mesh.patch(index).join.end(),
          [&](const auto& join) { return join.kind == ClayJoin::Kind::kFiner && IsWall(mesh, join.patch[0]); });
      // Its quarters may be, too: they are in slots that were free or are at the end.
      if (coarser) mesh.Split(index);
      if (coarser) index = kNoIndex;  // from the beginning
    }
  }

  /// The caps' rims are the walls'. They are flat: what their inner points are does not matter.
  void SetRims(ClayMesh& mesh) const {
    const auto net_of = [&mesh](PatchIndex index) -> const ControlNet& { return mesh.patch(index).net; };
    for (PatchIndex index = 0; index < mesh.patches().size(); ++index) {
      if (!mesh.alive(index) || IsWall(mesh, index)) continue;
      ControlNet net = mesh.patch(index).net;
      for (std::size_t edge = 0; edge < 4; ++edge) {
        const ClayJoin& join = mesh.patch(index).join[edge];
        if (join.kind != ClayJoin::Kind::kEqual || !IsWall(mesh, join.patch[0])) continue;
        for (std::size_t s = 0; s < 4; ++s) {
          const auto [i, j] = NetIndex(edge, s, 0);
          const auto [k, l] = NetIndex(join.edge[0], 3 - s, 0);
          net[i][j] = mesh.patch(join.patch[0]).net[k][l];
        }
      }
      mesh.PullSlaves(index, net_of, net);
      mesh.SetNet(index, net);
    }
  }

  const SurfaceSegment& segment_;
  Grid grid_;
  double tolerance_;
  std::size_t most_leaves_;
};

}  // namespace

Result<ClayOfSurface> ClayFromSurface(const SurfaceSegment& segment, double tolerance, std::size_t most_leaves) {
  const Grid grid = GridOf(segment);
  for (const double z : grid.z) {
    for (const double theta : grid.theta) {
      const double radius = segment.surface.Radius(theta, z);
      if (radius > 0.0) continue;
      return Fail(kAttempted,
                  fmt::format("its radius is {:g} mm at theta {:.1f} deg, z {:.1f} mm", radius,
                              theta * 180.0 / std::numbers::pi, z),
                  "fit the surface anew; clay needs a body around its axis");
    }
  }
  return Converter(segment, tolerance, most_leaves).Convert();
}

}  // namespace annulus
