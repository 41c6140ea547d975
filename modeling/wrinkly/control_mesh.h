#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/wrinkly/shuffle.h"

namespace annulus {

/// Number of a control point; of the patch that it carries too.
using PointIndex = std::int32_t;

/// What lies beyond one of a control point's four sides.
struct ControlLink {
  enum class Kind : std::uint8_t {
    kBoundary,  ///< Nothing: the mesh ends here.
    kClosed,    ///< Nothing, and the side has no length: the patch is three- or two-sided (paper 003, figs. 10, 11 b).
    kPoint,     ///< Another control point.
  };
  Kind kind = Kind::kBoundary;
  std::uint8_t slot = 0;  ///< kPoint: by which of its sides that point links back.
  PointIndex point = -1;  ///< kPoint.
};

/// A control point as it is given: its place and its neighbours. Slots 0 … 3 are its sides +u, +v, −u, −v, in this
/// order counter-clockwise seen from outside; which of them is which the mesh decides (paper 003, fig. 7).
struct ControlPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< mm
  std::array<ControlLink, 4> link{};
  bool temporary = false;  ///< Only there for the patches beside it (fig. 11 a): it carries none itself.
};

/// What a control mesh is made of. A plain value; ControlMesh::Make checks it.
struct ControlMeshParts {
  std::vector<ControlPoint> points;
  /// Names of what points carry beside their place; the first is "height" (mm). "red", "green", "blue" (linear, 0 … 1)
  /// and "opacity" (0 … 1) are drawn.
  std::vector<std::string> attributes{"height"};
  /// Point by point, `attributes.size()` values each.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values;
};

/// The two families of global axes (U, V 系統; paper 003, §3.1).
enum class AxisFamily : std::uint8_t { kU, kV };

/// A global axis: the patches that it passes, one base interval each (paper 003, §3.2.2, fig. 6).
struct GlobalAxis {
  AxisFamily family = AxisFamily::kU;
  AxisKind kind = AxisKind::kOpen;
  std::vector<PointIndex> points;
};

/// A patch's interval of an axis.
struct AxisInterval {
  std::int32_t axis = -1;   ///< Of ControlMesh::axes().
  std::int32_t index = -1;  ///< 0 … count − 1.
};

/// A share of a control point in something that is linear in all of them.
struct PointShare {
  PointIndex point = 0;
  double weight = 0.0;
};
using PointShares = std::vector<PointShare>;

/// A cell of the mesh (格子領域): the polygon of control points around a corner of their patches.
struct MeshCell {
  /// Its corners counter-clockwise; beyond a boundary without temporary points mirrored ones, 2·p − q.
  std::vector<PointShares> corners;
  bool open = false;    ///< A boundary runs through its middle.
  bool closed = false;  ///< A closed side lies in it.
};

/// What to do about a mesh whose axes are one family (paper 003, §3.1 and its open points).
enum class FamilyRule {
  kRefuse,  ///< Name a loop of control points along which U turns into V.
  kCut,     ///< Let axes end at some links, as few as a local search finds; the surface stays whole.
};

/// A control mesh of wrinkly surfaces (paper 003, §3): every control point carries a four-sided patch, cells are
/// polygons of any number of corners, and the axes through the patches form two families. A value.
class ControlMesh {
 public:
  /// Time and memory linear in the number of points. Fails, naming the point, if a number is not finite, a link is not
  /// returned, a point has no neighbour, `values` do not fit, or (kRefuse) the axes are one family.
  static Result<ControlMesh> Make(ControlMeshParts parts, FamilyRule rule = FamilyRule::kRefuse);

  [[nodiscard]] const ControlMeshParts& parts() const { return parts_; }
  [[nodiscard]] std::size_t size() const { return parts_.points.size(); }
  [[nodiscard]] bool HasPatch(PointIndex point) const { return !parts_.points[Index(point)].temporary; }
  [[nodiscard]] std::size_t patch_count() const { return patch_count_; }

  [[nodiscard]] const std::vector<GlobalAxis>& axes() const { return axes_; }
  /// Where an axis of the family passes a patch.
  [[nodiscard]] const AxisInterval& IntervalOf(PointIndex point, AxisFamily family) const {
    return interval_[Index(point)][static_cast<std::size_t>(family)];
  }
  /// The side of a patch in a direction of its axes: 0 … 3 are +U, +V, −U, −V.
  [[nodiscard]] std::uint8_t SlotOf(PointIndex point, std::size_t direction) const {
    return slot_[Index(point)][direction];
  }
  /// Whether +V is counter-clockwise of +U in this patch, seen from outside. Where two patches of an axis differ in
  /// this, the other parameter runs the opposite way.
  [[nodiscard]] bool IsRightHanded(PointIndex point) const { return right_handed_[Index(point)] != 0; }
  /// Links at which axes were made to end by FamilyRule::kCut.
  [[nodiscard]] std::size_t cut_count() const { return cut_count_; }

  [[nodiscard]] const std::vector<MeshCell>& cells() const { return cells_; }
  /// The cell at a patch's corner: 0 … 3 are (+U, +V), (−U, +V), (−U, −V), (+U, −V).
  [[nodiscard]] std::int32_t CellOf(PointIndex point, std::size_t corner) const;
  /// The cell between a patch's sides `slot` and `slot` + 1, counter-clockwise seen from outside.
  [[nodiscard]] std::int32_t CellAtSlot(PointIndex point, std::size_t slot) const { return cell_[Index(point)][slot]; }
  /// Where the neighbour beyond a side without one would stand: 2·p − q, or p itself.
  [[nodiscard]] PointShares Mirrored(PointIndex point, std::size_t slot) const;

  static std::size_t Index(PointIndex point) { return static_cast<std::size_t>(point); }

 private:
  friend class ControlMeshMaker;
  ControlMesh() = default;

  ControlMeshParts parts_;
  std::size_t patch_count_ = 0;
  std::size_t cut_count_ = 0;
  std::vector<GlobalAxis> axes_;
  std::vector<std::array<AxisInterval, 2>> interval_;
  std::vector<std::array<std::uint8_t, 4>> slot_;
  std::vector<std::uint8_t> right_handed_;
  std::vector<MeshCell> cells_;
  std::vector<std::array<std::int32_t, 4>> cell_;  ///< By slot: between that one and the next.
};

}  // namespace annulus
