#include "modeling/clay/clay_hole.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "modeling/clay/clay_region.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr const char* kAttempted = "make a hole through the clay";
constexpr std::size_t kCells = 6;  ///< Of a leaf, each way, where a line is to meet it.
constexpr std::uint32_t kMostRings = 16;
constexpr int kTries = 12;

/// Where a line leaves the body.
struct FarSide {
  double distance = std::numeric_limits<double>::infinity();
  ClayAddress at;
};

/// Möller and Trumbore (1997), edges included: distance along the line, and the two coordinates in the triangle.
std::optional<Vector3d> Meets(const Vector3d& from, const Vector3d& way, const std::array<Vector3d, 3>& triangle) {
  constexpr double kSlack = 1e-9;
  const Vector3d a = triangle[1] - triangle[0];
  const Vector3d b = triangle[2] - triangle[0];
  const double determinant = a.dot(way.cross(b));
  // From within, the skin's outward normal a × b points along the way: the determinant, (b × a)·way, is negative.
  if (!(determinant < 0.0)) return std::nullopt;
  const Vector3d s = from - triangle[0];
  const double u = s.dot(way.cross(b)) / determinant;
  const double v = way.dot(s.cross(a)) / determinant;
  if (u < -kSlack || v < -kSlack || u + v > 1.0 + kSlack) return std::nullopt;
  return Vector3d(b.dot(s.cross(a)) / determinant, u, v);
}

/// The nearest way out of one leaf, if it is nearer than what is known.
void LeaveBy(const ClayPatch& leaf, const Vector3d& from, const Vector3d& way, double least, FarSide& nearest) {
  const BezierPatch patch(leaf.net);
  const auto point = [&patch](std::size_t i, std::size_t j) {
    return patch.Point(static_cast<double>(i) / kCells, static_cast<double>(j) / kCells);
  };
  const auto note = [&](std::size_t i, std::size_t j, const Vector3d& hit, double du, double dv) {
    if (hit[0] <= least || hit[0] >= nearest.distance) return;
    const double share = 1.0 / static_cast<double>(1U << leaf.level);
    const double u = (static_cast<double>(i) + std::clamp(du, 0.0, 1.0)) / kCells;
    const double v = (static_cast<double>(j) + std::clamp(dv, 0.0, 1.0)) / kCells;
    nearest = {hit[0], {leaf.base, (leaf.column + u) * share, (leaf.row + v) * share}};
  };
  for (std::size_t i = 0; i < kCells; ++i) {
    for (std::size_t j = 0; j < kCells; ++j) {
      const Vector3d first = point(i, j);
      const Vector3d across = point(i + 1, j + 1);
      if (const auto hit = Meets(from, way, {first, point(i + 1, j), across})) {
        note(i, j, *hit, (*hit)[1] + (*hit)[2], (*hit)[2]);
      }
      if (const auto hit = Meets(from, way, {first, across, point(i, j + 1)})) {
        note(i, j, *hit, (*hit)[1], (*hit)[1] + (*hit)[2]);
      }
    }
  }
}

FarSide FarSideOf(const ClayMesh& mesh, const Vector3d& from, const Vector3d& way, double least) {
  FarSide nearest;
  for (const ClayPatch& leaf : mesh.patches()) {
    if (leaf.node == kNoIndex) continue;
    Eigen::AlignedBox3d box;
    for (const auto& row : leaf.net) {
      for (const Vector3d& point : row) box.extend(point);
    }
    // The line passes the ball around the box, or does not.
    const Vector3d to = box.center() - from;
    if ((to - to.dot(way) * way).norm() > 0.5 * box.diagonal().norm()) continue;
    LeaveBy(leaf, from, way, least, nearest);
  }
  return nearest;
}

std::array<Vector3d, 4> CornersOf(const ClayPatch& leaf) {
  return {leaf.net[0][0], leaf.net[3][0], leaf.net[3][3], leaf.net[0][3]};
}

Vector3d MiddleOf(const ClayPatch& leaf) { return BezierPatch(leaf.net).Point(0.5, 0.5); }

/// The area that four corners span, seen along a direction.
double AreaAlong(const std::array<Vector3d, 4>& corner, const Vector3d& way) {
  return 0.5 * std::abs((corner[2] - corner[0]).cross(corner[3] - corner[1]).dot(way));
}

/// The turn for which the walls are shortest across the way.
std::uint32_t TurnOf(const ClayPatch& entry, const ClayPatch& exit, const Vector3d& way) {
  const std::array<Vector3d, 4> above = CornersOf(entry);
  const std::array<Vector3d, 4> below = CornersOf(exit);
  std::uint32_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t turn = 0; turn < 4; ++turn) {
    double sum = 0.0;
    for (std::size_t c = 0; c < 4; ++c) {
      const Vector3d down = below[(turn + 4 - c + 1) % 4] - above[c];
      sum += (down - down.dot(way) * way).squaredNorm();
    }
    if (sum >= least) continue;
    least = sum;
    best = turn;
  }
  return best;
}

ClayMesh::Part PartOf(const ClayPatch& leaf) { return {leaf.base, leaf.level, leaf.column, leaf.row}; }

}  // namespace

Result<ClayMesh::Hole> PlanHole(ClayBody& body, const ClayAddress& at, const Vector3d& inward, double radius) {
  const ClayMesh& mesh = body.mesh();
  if (mesh.Locate(at).patch == kNoIndex) {
    return Fail(kAttempted, "its place is in a hole already", "give a place on the skin");
  }
  // Up to twice as wide as the square that has the circle's area: to narrow a hole folds nothing.
  const double size = 2.0 * std::sqrt(std::numbers::pi) * radius;
  RETURN_IF_ERROR(RefineAround(body, at, body.Point(at), 0.0, size));
  for (int step = 0; step < kTries; ++step) {
    const PatchIndex in = mesh.Locate(at).patch;
    const Vector3d from = MiddleOf(mesh.patch(in));
    const FarSide far = FarSideOf(mesh, from, inward, 0.05 * size);
    if (!std::isfinite(far.distance)) {
      return Fail(kAttempted, "there is no far side in its direction", "hold the tool so that it points into the clay");
    }
    RETURN_IF_ERROR(RefineAround(body, far.at, from + far.distance * inward, 0.0, size));
    const PatchIndex out = mesh.Locate(far.at).patch;
    if (!mesh.alive(in) || mesh.Locate(at).patch != in || mesh.patch(in).rank < mesh.patch(out).rank) {
      const PatchIndex coarse = mesh.Locate(at).patch;
      if (mesh.patch(coarse).rank < mesh.patch(out).rank) body.Split(coarse);
      continue;
    }
    if (mesh.patch(out).rank < mesh.patch(in).rank) {
      body.Split(out);
      continue;
    }
    const ClayPatch& entry = mesh.patch(in);
    const ClayPatch& exit = mesh.patch(out);
    const double area = std::min(AreaAlong(CornersOf(entry), inward), AreaAlong(CornersOf(exit), inward));
    if (!(area > 1e-3 * radius * radius)) break;
    const double rings = std::round((MiddleOf(exit) - from).norm() / std::sqrt(area));
    return ClayMesh::Hole{PartOf(entry), PartOf(exit), TurnOf(entry, exit, inward),
                          static_cast<std::uint32_t>(std::clamp(rings, 1.0, double{kMostRings}))};
  }
  return Fail(kAttempted, "no two patches of the skin lie opposite each other along it",
              "hold the tool more upright, or in another place");
}

bool HasWholeRims(const ClayMesh& mesh, std::size_t hole) {
  const std::uint32_t wall = mesh.FirstWall(hole);
  const std::uint32_t rings = mesh.holes()[hole].segments;
  const std::uint32_t last = wall + 4 * (rings - 1);
  const auto there = [&mesh](const ClayAddress& at) { return mesh.Locate(at).patch != kNoIndex; };
  for (std::uint32_t e = 0; e < 4; ++e) {
    if (!there({wall + e, 0.0, 0.0}) || !there({last + e, 0.0, 1.0})) return false;
  }
  return there({wall, 0.5, 0.0}) && there({wall + 4 * (rings / 2), 0.5, 0.5}) && there({last, 0.5, 1.0});
}

HoleLine LineOf(const ClayBody& body, std::size_t hole) {
  const std::uint32_t wall = body.mesh().FirstWall(hole);
  const std::uint32_t rings = body.mesh().holes()[hole].segments;
  const std::uint32_t last = wall + 4 * (rings - 1);
  std::array<Vector3d, 4> above;
  std::array<Vector3d, 4> below;
  HoleLine line{Vector3d::Zero(), Vector3d::Zero(), 0.0, {wall, 0.5, 0.0}, {wall + 4 * (rings / 2), 0.5, 0.5},
                {last, 0.5, 1.0}};
  for (std::uint32_t e = 0; e < 4; ++e) {
    above[e] = body.Point({wall + e, 0.0, 0.0});
    below[e] = body.Point({last + e, 0.0, 1.0});
    line.from += 0.25 * above[e];
    line.to += 0.25 * below[e];
  }
  const Vector3d way = (line.to - line.from).normalized();
  line.radius_mm = std::sqrt(std::min(AreaAlong(above, way), AreaAlong(below, way)) / std::numbers::pi);
  return line;
}

}  // namespace annulus
