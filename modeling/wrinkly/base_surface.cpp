#include "modeling/wrinkly/base_surface.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Of a patch's size: below it a cross product is rounding.
constexpr double kParallel = 1e-12;

Vector3d PositionOf(const ControlMesh& mesh, const PointShares& shares) {
  Vector3d position = Vector3d::Zero();
  for (const PointShare& share : shares) {
    position += share.weight * mesh.parts().points[ControlMesh::Index(share.point)].position;
  }
  return position;
}

BiquadraticNet PlacedNet(const ControlMesh& mesh, PointIndex point) {
  const PatchNet shares = NetOf(mesh, point);
  BiquadraticNet net;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) net[a][b] = PositionOf(mesh, shares[a][b]);
  }
  return net;
}

/// Twice the longest step of the net along each parameter: its derivative is a mean of these.
std::array<double, 2> SpeedBound(const BiquadraticNet& net) {
  std::array<double, 2> speed{};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 2; ++b) {
      speed[0] = std::max(speed[0], 2.0 * (net[b + 1][a] - net[b][a]).norm());
      speed[1] = std::max(speed[1], 2.0 * (net[a][b + 1] - net[a][b]).norm());
    }
  }
  return speed;
}

bool HasClosedSide(const ControlMesh& mesh, PointIndex point) {
  const auto& links = mesh.parts().points[ControlMesh::Index(point)].link;
  return std::any_of(links.begin(), links.end(),
                     [](const ControlLink& link) { return link.kind == ControlLink::Kind::kClosed; });
}

/// A place of a patch by its sides: a from the side opposite to slot +U to that slot, b the same a quarter turn further
/// counter-clockwise, seen from outside; both 0 … 1.
struct PatchPlace {
  double a = 0.0;
  double b = 0.0;

  /// The same place by the slots `quarters` (0 … 3) further counter-clockwise.
  [[nodiscard]] PatchPlace Turned(std::size_t quarters) const {
    if (quarters == 1) return {b, 1.0 - a};
    if (quarters == 2) return {1.0 - a, 1.0 - b};
    if (quarters == 3) return {1.0 - b, a};
    return *this;
  }
};

/// A cell seen from one of its control points: which corner of the cell that is, and the cell's corners' places.
struct CellView {
  std::vector<Vector3d> ring;
  std::size_t at = 0;
};

/// The quarters of a patch's rounded corners.
class CornerMaker {
 public:
  CornerMaker(const ControlMesh& mesh, PointIndex point) : mesh_(mesh), point_(point) {}

  /// The quarter of the patch at a corner after one step of subdivision, with x along its side towards the next corner
  /// counter-clockwise, seen from outside.
  [[nodiscard]] RoundedCorner Make(std::size_t slot) const {
    const std::size_t ahead = (slot + 1) % 4;
    const std::size_t behind = (slot + 3) % 4;
    const CellView here = View(slot);
    // Counter-clockwise round the cell the next control point lies across side `slot`, the one before across `ahead`.
    const CellView x = View(behind);
    const CellView y = View(ahead);
    const CellView far = View((slot + 2) % 4);
    RoundedCorner corner;
    for (std::size_t k = 0; k < here.ring.size(); ++k) {
      corner.ring.push_back(DooSabinPoint(here.ring, (here.at + k) % here.ring.size()));
    }
    corner.x0 = DooSabinPoint(x.ring, x.at);
    corner.x1 = DooSabinPoint(x.ring, (x.at + x.ring.size() - 1) % x.ring.size());
    corner.y0 = DooSabinPoint(y.ring, y.at);
    corner.y1 = DooSabinPoint(y.ring, (y.at + 1) % y.ring.size());
    corner.xy = DooSabinPoint(far.ring, far.at);
    return corner;
  }

 private:
  [[nodiscard]] CellView View(std::size_t slot) const {
    const MeshCell& cell = mesh_.cells()[static_cast<std::size_t>(mesh_.CellAtSlot(point_, slot))];
    CellView view;
    for (std::size_t k = 0; k < cell.corners.size(); ++k) {
      view.ring.push_back(PositionOf(mesh_, cell.corners[k]));
      if (cell.corners[k].size() == 1 && cell.corners[k].front().point == point_) view.at = k;
    }
    return view;
  }

  const ControlMesh& mesh_;
  PointIndex point_;
};

}  // namespace

Result<BaseSurface> BaseSurface::Make(const ControlMesh& mesh, CornerJoin join) {
  BaseSurface surface;
  const std::size_t count = mesh.size();
  surface.nets_.resize(count);
  surface.speed_.resize(count);
  surface.middle_normal_.assign(count, Vector3d::UnitZ());
  surface.side_.assign(count, 1);
  surface.rounded_of_.assign(count, -1);
  for (std::size_t k = 0; k < count; ++k) {
    const auto point = static_cast<PointIndex>(k);
    if (!mesh.HasPatch(point)) continue;
    surface.nets_[k] = PlacedNet(mesh, point);
    surface.speed_[k] = SpeedBound(surface.nets_[k]);
    surface.side_[k] = mesh.IsRightHanded(point) ? 1 : -1;
    const PatchPoint middle = PointOn(surface.nets_[k], 0.5, 0.5);
    const Vector3d normal = middle.du.cross(middle.dv) * surface.side_[k];
    const double size = surface.speed_[k][0] * surface.speed_[k][1];
    if (!(normal.norm() > kParallel * size)) {
      return Fail("lay the base surface over the control mesh",
                  fmt::format("the patch of control point {} has no area in its middle", k),
                  "move it or its neighbours apart");
    }
    surface.middle_normal_[k] = normal.normalized();
  }
  if (join == CornerJoin::kRounded) RETURN_IF_ERROR(surface.Round(mesh));
  return surface;
}

Status BaseSurface::Round(const ControlMesh& mesh) {
  const auto is_irregular = [](const MeshCell& cell) { return !cell.closed && cell.corners.size() != 4; };
  for (std::size_t k = 0; k < nets_.size(); ++k) {
    const auto point = static_cast<PointIndex>(k);
    if (!mesh.HasPatch(point)) continue;
    bool irregular = false;
    for (std::size_t corner = 0; corner < 4; ++corner) {
      irregular = irregular || is_irregular(mesh.cells()[static_cast<std::size_t>(mesh.CellOf(point, corner))]);
    }
    if (!irregular) continue;
    if (HasClosedSide(mesh, point)) {
      return Fail("round the corners of the base surface",
                  fmt::format("control point {} lies between an irregular cell and a closed side", k),
                  "put another ring of control points between them, or take the paper's joins");
    }
    rounded_of_[k] = static_cast<std::int32_t>(rounded_.size());
    const CornerMaker maker(mesh, point);
    rounded_.push_back({maker.Make(mesh.SlotOf(point, 0)), maker.Make((mesh.SlotOf(point, 0) + 1U) % 4),
                        maker.Make((mesh.SlotOf(point, 0) + 2U) % 4), maker.Make((mesh.SlotOf(point, 0) + 3U) % 4)});
  }
  return {};
}

PatchPoint BaseSurface::RoundedAt(PointIndex patch, double u, double v) const {
  const std::size_t k = ControlMesh::Index(patch);
  const bool right_handed = side_[k] > 0;
  const PatchPlace place{u, right_handed ? v : 1.0 - v};
  std::size_t turn = 0;
  while (turn < 3 && !(place.Turned(turn).a >= 0.5 && place.Turned(turn).b >= 0.5)) ++turn;
  const PatchPlace turned = place.Turned(turn);
  const auto& corners = rounded_[static_cast<std::size_t>(rounded_of_[k])];
  const PatchPoint at = corners[turn].At(2.0 * (1.0 - turned.b), 2.0 * (1.0 - turned.a));
  // By the chain rule through x = 2(1 − b), y = 2(1 − a) and the turns of PatchPlace.
  const Vector3d by_a = -2.0 * at.dv;
  const Vector3d by_b = -2.0 * at.du;
  PatchPoint point{at.point, by_a, by_b};
  if (turn == 1) point = {at.point, -by_b, by_a};
  if (turn == 2) point = {at.point, -by_a, -by_b};
  if (turn == 3) point = {at.point, by_b, -by_a};
  if (!right_handed) point.dv = -point.dv;
  return point;
}

Vector3d BaseSurface::NormalAt(PointIndex patch, const PatchPoint& at) const {
  const std::size_t k = ControlMesh::Index(patch);
  const Vector3d normal = at.du.cross(at.dv) * side_[k];
  const double length = normal.norm();
  if (length > kParallel * speed_[k][0] * speed_[k][1]) return normal / length;
  return middle_normal_[k];
}

namespace {

/// One side of a patch.
struct PatchSide {
  PointIndex point = -1;
  std::size_t slot = 0;
};

/// Point and normal of a patch on its side, `along` (0 … 1) counter-clockwise seen from outside.
std::array<Vector3d, 2> OnSide(const ControlMesh& mesh, const BaseSurface& surface, const PatchSide& side,
                               double along) {
  const std::size_t turn = (side.slot + 4 - mesh.SlotOf(side.point, 0)) % 4;
  const PatchPlace place = PatchPlace{1.0, along}.Turned((4 - turn) % 4);
  const PatchPoint at = surface.At(side.point, place.a, mesh.IsRightHanded(side.point) ? place.b : 1.0 - place.b);
  return {at.point, surface.NormalAt(side.point, at)};
}

double AngleBetween(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

BaseJoins MeasureBaseJoins(const ControlMesh& mesh, const BaseSurface& surface) {
  BaseJoins joins;
  double sum = 0.0;
  std::size_t taken = 0;
  for (std::size_t k = 0; k < mesh.size(); ++k) {
    for (std::size_t slot = 0; slot < 4; ++slot) {
      const PatchSide here{static_cast<PointIndex>(k), slot};
      const ControlLink& link = mesh.parts().points[k].link[slot];
      if (link.kind != ControlLink::Kind::kPoint || !mesh.HasPatch(here.point) || !mesh.HasPatch(link.point)) continue;
      const PatchSide there{link.point, link.slot};
      // Corner `slot` is at the end of the side, the one before at its start; both sides of an edge are visited, so
      // that looking at the ends suffices.
      const MeshCell& end = mesh.cells()[static_cast<std::size_t>(mesh.CellAtSlot(here.point, slot))];
      const MeshCell& start = mesh.cells()[static_cast<std::size_t>(mesh.CellAtSlot(here.point, (slot + 3) % 4))];
      const bool irregular = end.corners.size() != 4 || end.closed;
      const bool both_regular = !irregular && start.corners.size() == 4 && !start.closed;
      if (irregular) ++joins.irregular_edges;
      for (const double from_end : {1e-6, 1e-3, 0.03, 0.1, 0.25, 0.5}) {
        const auto a = OnSide(mesh, surface, here, 1.0 - from_end);
        const auto b = OnSide(mesh, surface, there, from_end);
        joins.largest_gap_mm = std::max(joins.largest_gap_mm, (a[0] - b[0]).norm());
        const double angle = AngleBetween(a[1], b[1]);
        if (irregular) {
          joins.irregular_largest = std::max(joins.irregular_largest, angle);
          sum += angle;
          ++taken;
        } else if (both_regular) {
          joins.regular_largest = std::max(joins.regular_largest, angle);
        }
      }
    }
  }
  if (taken > 0) joins.irregular_mean = sum / static_cast<double>(taken);
  return joins;
}

}  // namespace annulus
