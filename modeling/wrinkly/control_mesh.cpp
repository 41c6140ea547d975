#include "modeling/wrinkly/control_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace annulus {
namespace {

using LinkKind = ControlLink::Kind;

constexpr std::size_t kMostPoints = 10'000'000;
constexpr std::size_t kLongestLoopShown = 24;

std::uint8_t Turned(std::size_t slot, std::size_t by) { return static_cast<std::uint8_t>((slot + by) % 4); }

/// The corner between two neighbouring slots: that of the one after which the other comes counter-clockwise.
std::size_t CornerBetween(std::uint8_t a, std::uint8_t b) { return Turned(a, 1) == b ? a : b; }

}  // namespace

/// Builds a mesh step by step; each step relies on those before.
class ControlMeshMaker {
 public:
  ControlMeshMaker(ControlMeshParts parts, FamilyRule rule) : rule_(rule) { mesh_.parts_ = std::move(parts); }

  Result<ControlMesh> Make() {
    RETURN_IF_ERROR(CheckPoints());
    RETURN_IF_ERROR(CheckLinks());
    RETURN_IF_ERROR(SplitFamilies());
    TraceAxes();
    TraceCells();
    return std::move(mesh_);
  }

 private:
  /// One step of the walk round a cell: a patch and its corner there.
  struct Corner {
    PointIndex point = -1;
    std::size_t slot = 0;
  };

  std::vector<ControlPoint>& points() { return mesh_.parts_.points; }
  [[nodiscard]] const ControlLink& LinkOf(PointIndex point, std::size_t slot) const {
    return mesh_.parts_.points[ControlMesh::Index(point)].link[slot];
  }
  [[nodiscard]] tl::unexpected<Error> Refuse(std::size_t point, const std::string& seen) const {
    return Fail("read the control mesh", fmt::format("control point {} {}", point, seen), "mend the mesh");
  }

  Status CheckPoints() {
    const ControlMeshParts& parts = mesh_.parts_;
    const char* const attempt = "read the control mesh";
    if (parts.points.empty()) return Fail(attempt, "it has no control points", "give some");
    if (parts.points.size() > kMostPoints) {
      return Fail(attempt, fmt::format("it has {} control points", parts.points.size()),
                  fmt::format("use at most {}", kMostPoints));
    }
    if (parts.attributes.empty() || parts.attributes.front() != "height") {
      return Fail(attempt, "its first attribute is not the height", "begin with 'height'");
    }
    if (parts.values.rows() != static_cast<Eigen::Index>(parts.points.size()) ||
        parts.values.cols() != static_cast<Eigen::Index>(parts.attributes.size())) {
      return Fail(attempt, "its attributes are not one value per point and name", "give one value of each per point");
    }
    for (std::size_t k = 0; k < parts.points.size(); ++k) {
      if (!parts.points[k].position.allFinite() || !parts.values.row(static_cast<Eigen::Index>(k)).allFinite()) {
        return Refuse(k, "has a number that is not finite");
      }
      if (!parts.points[k].temporary) ++mesh_.patch_count_;
    }
    if (mesh_.patch_count_ == 0) return Fail(attempt, "all its control points are temporary", "give others");
    return {};
  }

  Status CheckLinks() {
    for (std::size_t k = 0; k < points().size(); ++k) {
      bool alone = true;
      for (std::size_t slot = 0; slot < 4; ++slot) {
        const ControlLink& link = points()[k].link[slot];
        if (link.kind != LinkKind::kPoint) continue;
        alone = false;
        if (link.point < 0 || ControlMesh::Index(link.point) >= points().size() || link.slot > 3) {
          return Refuse(k, fmt::format("is linked to point {}, which does not exist", link.point));
        }
        const ControlLink& back = LinkOf(link.point, link.slot);
        if (back.kind != LinkKind::kPoint || ControlMesh::Index(back.point) != k || back.slot != slot) {
          return Refuse(k, fmt::format("is linked to point {}, which is not linked back", link.point));
        }
      }
      if (alone) return Refuse(k, "is linked to no other");
    }
    return {};
  }

  /// Whether an axis could run across a link: both ends carry patches.
  [[nodiscard]] bool Carries(PointIndex point, std::size_t slot) const {
    const ControlLink& link = LinkOf(point, slot);
    return link.kind == LinkKind::kPoint && mesh_.HasPatch(point) && mesh_.HasPatch(link.point);
  }
  /// 1 if a link joins an even side of one point to an odd one of the other.
  [[nodiscard]] int Parity(PointIndex point, std::size_t slot) const {
    return static_cast<int>((slot + LinkOf(point, slot).slot) % 2);
  }
  [[nodiscard]] bool Conflicts(PointIndex point, std::size_t slot) const {
    const PointIndex other = LinkOf(point, slot).point;
    return (odd_is_u_[ControlMesh::Index(point)] ^ odd_is_u_[ControlMesh::Index(other)]) != Parity(point, slot);
  }

  /// Fig. 7's walk from point to point: each gives its neighbours the family that its own sides have.
  Status SplitFamilies() {
    odd_is_u_.assign(points().size(), -1);
    std::vector<PointIndex> parent(points().size(), -1);
    for (std::size_t first = 0; first < points().size(); ++first) {
      if (odd_is_u_[first] >= 0 || points()[first].temporary) continue;
      odd_is_u_[first] = 0;
      std::vector<PointIndex> stack{static_cast<PointIndex>(first)};
      while (!stack.empty()) {
        const PointIndex point = stack.back();
        stack.pop_back();
        for (std::size_t slot = 0; slot < 4; ++slot) {
          if (!Carries(point, slot)) continue;
          const PointIndex other = LinkOf(point, slot).point;
          if (odd_is_u_[ControlMesh::Index(other)] >= 0) continue;
          odd_is_u_[ControlMesh::Index(other)] = odd_is_u_[ControlMesh::Index(point)] ^ Parity(point, slot);
          parent[ControlMesh::Index(other)] = point;
          stack.push_back(other);
        }
      }
    }
    return rule_ == FamilyRule::kCut ? CutConflicts() : RefuseConflicts(parent);
  }

  [[nodiscard]] Status RefuseConflicts(const std::vector<PointIndex>& parent) const {
    for (std::size_t k = 0; k < mesh_.size(); ++k) {
      const auto point = static_cast<PointIndex>(k);
      for (std::size_t slot = 0; slot < 4; ++slot) {
        if (!Carries(point, slot) || !Conflicts(point, slot)) continue;
        return Fail("split the axes of the control mesh in two families",
                    fmt::format("along the loop of control points {} U turns into V", Loop(parent, point, slot)),
                    "change the mesh so that every loop has as many turns as it needs, or let axes be cut");
      }
    }
    return {};
  }

  /// The loop that a link closes with the walk's tree.
  [[nodiscard]] std::string Loop(const std::vector<PointIndex>& parent, PointIndex point, std::size_t slot) const {
    const auto path = [&](PointIndex at) {
      std::vector<PointIndex> way;
      for (; at >= 0; at = parent[ControlMesh::Index(at)]) way.push_back(at);
      return way;
    };
    std::vector<PointIndex> out = path(point);
    std::vector<PointIndex> back = path(LinkOf(point, slot).point);
    PointIndex common = -1;
    while (!out.empty() && !back.empty() && out.back() == back.back()) {
      common = out.back();
      out.pop_back();
      back.pop_back();
    }
    if (common >= 0) out.push_back(common);
    out.insert(out.end(), back.rbegin(), back.rend());
    std::string text;
    for (std::size_t k = 0; k < out.size(); ++k) {
      if (k == kLongestLoopShown) return text + fmt::format(" … ({} in all)", out.size());
      text += fmt::format("{}{}", k == 0 ? "" : "-", out[k]);
    }
    return text;
  }

  /// A point turns its families round where that leaves fewer links to cut; each turn leaves fewer, so it ends.
  Status CutConflicts() {
    std::vector<PointIndex> doubtful;
    for (std::size_t k = 0; k < points().size(); ++k) doubtful.push_back(static_cast<PointIndex>(k));
    while (!doubtful.empty()) {
      const PointIndex point = doubtful.back();
      doubtful.pop_back();
      int gain = 0;
      for (std::size_t slot = 0; slot < 4; ++slot) {
        if (!Carries(point, slot) || LinkOf(point, slot).point == point) continue;
        gain += Conflicts(point, slot) ? 1 : -1;
      }
      if (gain <= 0) continue;
      odd_is_u_[ControlMesh::Index(point)] ^= 1;
      for (std::size_t slot = 0; slot < 4; ++slot) {
        if (Carries(point, slot)) doubtful.push_back(LinkOf(point, slot).point);
      }
    }
    return {};
  }

  /// Whether an axis runs on across a link.
  [[nodiscard]] bool Runs(PointIndex point, std::size_t slot) const {
    return Carries(point, slot) && !Conflicts(point, slot);
  }

  void TraceAxes() {
    mesh_.interval_.resize(points().size());
    mesh_.slot_.resize(points().size());
    mesh_.right_handed_.assign(points().size(), 1);
    for (const AxisFamily family : {AxisFamily::kU, AxisFamily::kV}) {
      for (std::size_t k = 0; k < points().size(); ++k) {
        if (points()[k].temporary || mesh_.interval_[k][static_cast<std::size_t>(family)].axis >= 0) continue;
        TraceAxis(static_cast<PointIndex>(k), family);
      }
    }
    for (std::size_t k = 0; k < points().size(); ++k) {
      if (points()[k].temporary) continue;
      mesh_.right_handed_[k] = Turned(mesh_.slot_[k][0], 1) == mesh_.slot_[k][1] ? 1 : 0;
      for (std::size_t slot = 0; slot < 4; ++slot) {
        const auto point = static_cast<PointIndex>(k);
        if (!Carries(point, slot) || !Conflicts(point, slot)) continue;
        // Seen from both of its ends.
        if (std::pair(point, slot) < std::pair(LinkOf(point, slot).point, std::size_t{LinkOf(point, slot).slot})) {
          ++mesh_.cut_count_;
        }
      }
    }
  }

  /// The axis of a family through a point, whose side of the family with the lower number is taken for its + side.
  void TraceAxis(PointIndex point, AxisFamily family) {
    const bool odd = (odd_is_u_[ControlMesh::Index(point)] != 0) == (family == AxisFamily::kU);
    const Corner start{point, odd ? std::size_t{1} : std::size_t{0}};
    GlobalAxis axis{family, AxisKind::kOpen, {}};
    Corner first = start;
    while (Runs(first.point, Turned(first.slot, 2))) {
      const ControlLink& link = LinkOf(first.point, Turned(first.slot, 2));
      first = {link.point, link.slot};
      if (first.point != start.point) continue;
      axis.kind = AxisKind::kCyclic;
      first = start;
      break;
    }
    for (Corner at = first;;) {
      const std::size_t index = ControlMesh::Index(at.point);
      mesh_.interval_[index][static_cast<std::size_t>(family)] = {static_cast<std::int32_t>(mesh_.axes_.size()),
                                                                  static_cast<std::int32_t>(axis.points.size())};
      const std::size_t direction = family == AxisFamily::kU ? 0 : 1;
      mesh_.slot_[index][direction] = static_cast<std::uint8_t>(at.slot);
      mesh_.slot_[index][direction + 2] = Turned(at.slot, 2);
      axis.points.push_back(at.point);
      if (!Runs(at.point, at.slot)) break;
      const ControlLink& link = LinkOf(at.point, at.slot);
      at = {link.point, Turned(link.slot, 2)};
      if (at.point == first.point) break;
    }
    mesh_.axes_.push_back(std::move(axis));
  }

  void TraceCells() {
    mesh_.cell_.assign(points().size(), {-1, -1, -1, -1});
    for (std::size_t k = 0; k < points().size(); ++k) {
      for (std::size_t slot = 0; slot < 4; ++slot) {
        if (!points()[k].temporary && mesh_.cell_[k][slot] < 0) TraceCell({static_cast<PointIndex>(k), slot});
      }
    }
  }

  /// Walks clockwise to an open end if there is one, then counter-clockwise round the cell.
  void TraceCell(Corner start) {
    Corner first = start;
    MeshCell cell;
    for (;;) {
      const std::uint8_t across = Turned(first.slot, 1);
      const ControlLink& link = LinkOf(first.point, across);
      if (link.kind == LinkKind::kBoundary) {
        cell.open = true;
        break;
      }
      first = link.kind == LinkKind::kClosed ? Corner{first.point, across} : Corner{link.point, link.slot};
      if (first.point == start.point && first.slot == start.slot) break;
    }
    const auto number = static_cast<std::int32_t>(mesh_.cells_.size());
    Corner last = first;
    for (Corner at = first;;) {
      mesh_.cell_[ControlMesh::Index(at.point)][at.slot] = number;
      last = at;
      const ControlLink& link = LinkOf(at.point, at.slot);
      if (link.kind == LinkKind::kClosed) {
        cell.closed = true;
        at.slot = Turned(at.slot, 3);
      } else {
        cell.corners.push_back({{at.point, 1.0}});
        if (link.kind == LinkKind::kBoundary) break;
        at = {link.point, Turned(link.slot, 3)};
      }
      if (at.point == first.point && at.slot == first.slot) break;
    }
    if (cell.open) Complete(cell, first, last);
    mesh_.cells_.push_back(std::move(cell));
  }

  /// Adds what lies beyond the boundary that runs through a cell.
  void Complete(MeshCell& cell, Corner first, Corner last) const {
    // Temporary points are the end of what there is: they are the cell's outer corners themselves.
    const PointShares after = mesh_.Mirrored(last.point, last.slot);
    const PointShares before = mesh_.Mirrored(first.point, Turned(first.slot, 1));
    if (mesh_.HasPatch(last.point)) cell.corners.push_back(after);
    if (first.point == last.point && mesh_.HasPatch(first.point)) {
      PointShares far = after;
      far.insert(far.end(), before.begin(), before.end());
      far.push_back({first.point, -1.0});
      cell.corners.push_back(std::move(far));
    }
    if (mesh_.HasPatch(first.point)) cell.corners.push_back(before);
  }

  ControlMesh mesh_;
  FamilyRule rule_;
  std::vector<int> odd_is_u_;  ///< Which of its sides are of family U: the even ones (0) or the odd ones (1).
};

Result<ControlMesh> ControlMesh::Make(ControlMeshParts parts, FamilyRule rule) {
  return ControlMeshMaker(std::move(parts), rule).Make();
}

std::int32_t ControlMesh::CellOf(PointIndex point, std::size_t corner) const {
  const auto& slots = slot_[Index(point)];
  return cell_[Index(point)][CornerBetween(slots[corner], slots[(corner + 1) % 4])];
}

PointShares ControlMesh::Mirrored(PointIndex point, std::size_t slot) const {
  const ControlLink& opposite = parts_.points[Index(point)].link[(slot + 2) % 4];
  if (opposite.kind != LinkKind::kPoint) return {{point, 1.0}};
  return {{point, 2.0}, {opposite.point, -1.0}};
}

}  // namespace annulus
