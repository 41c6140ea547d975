#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/result.h"
#include "modeling/bezier/bezier_patch.h"
#include "modeling/bezier/patch_shell.h"

namespace annulus {

using PatchIndex = std::uint32_t;
using VertexIndex = std::uint32_t;
/// No patch, no vertex.
inline constexpr std::uint32_t kNoIndex = 0xffffffffU;

/// A place on a clay body: base patch and its parameters, as the operations of paper 004 address it (§2.1).
struct ClayAddress {
  std::uint32_t patch = 0;  ///< Number of the patch in the body as it was made; subdivision does not change it.
  double u = 0.0;           ///< 0 … 1
  double v = 0.0;           ///< 0 … 1
};

/// How a patch meets what is across one of its edges. Edge e runs from corner e to corner e + 1 (mod 4), corners being
/// (u, v) = (0, 0), (1, 0), (1, 1), (0, 1): around the patch with its inside on the left, seen from outside.
struct ClayJoin {
  enum class Kind : std::uint8_t {
    kPole,     ///< The edge has no length: nothing is across.
    kEqual,    ///< One patch, whose edge is the same curve.
    kFiner,    ///< Two patches, each with half of the edge.
    kCoarser,  ///< A patch of whose edge this one is half: a T-join; this side is slaved to that.
  };
  Kind kind = Kind::kPole;
  /// C1 along the whole edge: the cross steps of both sides are opposite, with one ratio.
  bool smooth = false;
  std::uint8_t half = 0;                                ///< kCoarser: 0 or 1, counted along the other patch's edge.
  std::array<std::uint8_t, 2> edge{};                   ///< The other patch's edge, which runs the other way.
  std::array<PatchIndex, 2> patch{kNoIndex, kNoIndex};  ///< kFiner: first the one at this edge's start.
  double ratio = 1.0;                                   ///< Their cross step over this one's, at equal levels.
};

/// A leaf of the subdivision: the part of its base patch with u in [column, column + 1) / 2^level, v so with row.
struct ClayPatch {
  BezierPatch::ControlNet net;  ///< mm; S_u × S_v points out of the body.
  std::array<VertexIndex, 4> vertex{};
  std::array<ClayJoin, 4> join;
  std::uint32_t base = 0;
  std::uint32_t level = 0;
  std::uint32_t column = 0;
  std::uint32_t row = 0;
  std::uint32_t rank = 0;         ///< A leaf is slaved to leaves of a lower one only: its level, more in a hole.
  std::uint32_t node = kNoIndex;  ///< Of the tree; kNoIndex: the slot is free.
};

/// A corner of a patch: the four control points next to it belong to that corner's vertex.
struct PatchCorner {
  PatchIndex patch = kNoIndex;
  std::uint8_t corner = 0;
};

/// A place where patches meet. The control points next to it, of all patches that meet there, are the linked group of
/// paper 004 (§2.3, fig. 2): moved by one affine map they keep every join that they had.
struct ClayVertex {
  std::vector<PatchCorner> corners;
  bool hanging = false;  ///< In the middle of a coarser patch's edge.
  bool rim = false;      ///< Of a hole, or of one that was: never in the middle of an edge.
};

/// Leaves that are no more, and leaves that are new or have new control points; a slot may be in both.
struct LeafChange {
  std::vector<PatchIndex> gone;
  std::vector<PatchIndex> made;
};

/// A corner's quarter of a control net, (i, j) of point (along, inward): `along` edge `corner`, 0 or 1 … 3.
[[nodiscard]] std::array<std::size_t, 2> NetIndex(std::size_t edge, std::size_t along, std::size_t inward);

/// The skin of a body of clay: bicubic patches that close it, each the root of a quadtree whose leaves are what the
/// body consists of (paper 004, §2.1: recursive subdivision and merging). Across an edge leaves differ by one level at
/// most; a finer leaf's points next to the middle of a coarser edge are slaved to the coarser patch, its edge row
/// always, and where the join is smooth its second row too, so that no gap opens and no kink appears. A value.
class ClayMesh {
 public:
  /// Edges that agree within 1e-6 mm are joined and made equal to the bit. Fails if an edge has no partner or more than
  /// one, or a number is not finite.
  static Result<ClayMesh> Make(const PatchShell& shell);

  /// How a base patch meets the others: joins are kEqual or kPole.
  struct Base {
    std::array<VertexIndex, 4> vertex{};
    std::array<ClayJoin, 4> join;
  };
  /// A part of a base patch.
  struct Part {
    std::uint32_t base = 0;
    std::uint32_t level = 0;
    std::uint32_t column = 0;
    std::uint32_t row = 0;
  };
  /// A mesh without places yet: all control points are 0. Fails if a join does not go both ways, or joins corners that
  /// are not the same.
  static Result<ClayMesh> Joined(const std::vector<Base>& bases);
  /// Those that the body was made of, without the holes' walls.
  [[nodiscard]] std::vector<Base> Bases() const { return roots_; }

  /// A hole from one leaf to another, which are no more: its wall is of new base patches, `segments` rings of four one
  /// after the other, the first with the edges of `entry`: patch first_wall + 4·ring + edge, u along the edge and v
  /// inwards. Edge e of `entry` lies over edge turn − e (mod 4) of `exit`.
  struct Hole {
    Part entry;
    Part exit;
    std::uint32_t turn = 0;
    std::uint32_t segments = 1;
    bool filled = false;  ///< Both leaves are back, the wall is no more.
  };
  /// Makes a hole with straight walls; coarser leaves around its ends are cut first. Fails, with the mesh as it was, if
  /// an end is not a leaf, or they are not of one rank, touch each other or have a pole.
  Result<LeafChange> OpenHole(const Hole& hole);
  /// Fills a hole: leaves that its rims' edges bound, no longer C1 with their neighbours. Fails, with the mesh as it
  /// was, if a part of its wall is not a leaf of level 0, or it is filled.
  Result<LeafChange> FillHole(std::size_t hole);
  /// In the order in which they were made.
  [[nodiscard]] const std::vector<Hole>& holes() const { return holes_; }
  /// The number of the hole that has taken out an address; holes().size() if none has.
  [[nodiscard]] std::size_t HoleAt(const ClayAddress& address) const;
  /// Number of the first base patch of a hole's wall.
  [[nodiscard]] std::uint32_t FirstWall(std::size_t hole) const;

  /// Leaves by base patch, and in it by quarters in the order of its corners.
  [[nodiscard]] std::vector<PatchIndex> LeavesInOrder() const;
  /// The leaf that is just this part; kNoIndex: there is none.
  [[nodiscard]] PatchIndex LeafOf(const Part& part) const;
  /// The largest distance between points that leaves should have in common, on their edges or slaved, mm; NaN if one
  /// is.
  [[nodiscard]] double LargestGap() const;
  /// Splits until the part is a leaf or lies in leaves.
  void SplitTo(const Part& part);

  [[nodiscard]] std::size_t base_count() const { return roots_.size() + wall_nodes_.size(); }
  /// Leaves there are.
  [[nodiscard]] std::size_t leaf_count() const { return leaves_; }
  /// Slots of leaves: some may be free (ClayPatch::node == kNoIndex).
  [[nodiscard]] const std::vector<ClayPatch>& patches() const { return patches_; }
  [[nodiscard]] const ClayPatch& patch(PatchIndex index) const { return patches_[index]; }
  [[nodiscard]] bool alive(PatchIndex index) const { return patches_[index].node != kNoIndex; }
  [[nodiscard]] const ClayVertex& vertex(VertexIndex index) const { return vertices_[index]; }
  [[nodiscard]] std::size_t vertex_slots() const { return vertices_.size(); }
  /// Where a vertex stands, mm.
  [[nodiscard]] const Eigen::Vector3d& Position(VertexIndex index) const;

  /// Of the quadtrees.
  struct Node {
    std::uint32_t parent = kNoIndex;
    std::array<std::uint32_t, 4> child{kNoIndex, kNoIndex, kNoIndex, kNoIndex};
    PatchIndex patch = kNoIndex;  ///< A leaf's; kNoIndex: it has children.
  };
  /// Some may be free; one without parent is a base patch's; one without leaf and children was taken out by a hole.
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

  /// The leaf that holds an address, and the address's parameters in it; kNoIndex if a hole has taken it out. Requires
  /// a number below base_count().
  struct Leaf {
    PatchIndex patch = kNoIndex;
    double u = 0.0;
    double v = 0.0;
  };
  [[nodiscard]] Leaf Locate(const ClayAddress& address) const;

  /// Cuts a leaf into four, and first whatever coarser leaves are across its edges. The surface stays what it is.
  LeafChange Split(PatchIndex index);
  /// The patch of which the leaf is a quarter is a leaf again, if its four quarters are leaves, none has a finer leaf
  /// across an outer edge, and the patch made of their outer corners has all their control points within `tolerance`
  /// mm. Else nothing changes.
  LeafChange Merge(PatchIndex index, double tolerance);
  /// Whether Merge would.
  [[nodiscard]] bool Merges(PatchIndex index, double tolerance) const {
    return WholeWith(index, tolerance).has_value();
  }

  /// The leaf and the three others that are the quarters of one whole, by corner; all kNoIndex if there is no whole, or
  /// not all of them are leaves.
  [[nodiscard]] std::array<PatchIndex, 4> QuartersWith(PatchIndex index) const;
  [[nodiscard]] PatchIndex FirstQuarter(PatchIndex index) const { return QuartersWith(index)[0]; }

  /// Control points of one leaf; what is slaved to them follows only with PullSlaves.
  void SetNet(PatchIndex index, const BezierPatch::ControlNet& net) { patches_[index].net = net; }
  /// What the net of a leaf must be where it is slaved to coarser leaves, given those leaves' nets by `net_of(index)`.
  template <class NetOf>
  void PullSlaves(PatchIndex index, const NetOf& net_of, BezierPatch::ControlNet& net) const;

 private:
  [[nodiscard]] std::uint32_t RootOf(std::uint32_t base) const {
    return base < roots_.size() ? base : wall_nodes_[base - roots_.size()];
  }
  [[nodiscard]] bool HasChildren(const Node& node) const { return node.child[0] != kNoIndex; }
  /// The node of the part, or that of the leaf or of the hole that it lies in.
  [[nodiscard]] std::uint32_t NodeToward(const Part& part) const;
  [[nodiscard]] PatchIndex NewPatch();
  [[nodiscard]] VertexIndex NewVertex();
  [[nodiscard]] std::uint32_t NewNode();
  void FreePatch(PatchIndex index);
  void FreeVertex(VertexIndex index);
  void ReplaceCorner(VertexIndex vertex, PatchCorner old_corner, PatchCorner new_corner);
  [[nodiscard]] VertexIndex MiddleOf(const ClayPatch& parent, std::size_t edge);
  void JoinChildren(const ClayPatch& parent, const std::array<PatchIndex, 4>& child);
  void JoinParent(PatchIndex parent, const std::array<PatchIndex, 4>& child);
  [[nodiscard]] std::array<PatchIndex, 4> MakeChildren(PatchIndex index, const ClayPatch& parent);
  [[nodiscard]] std::optional<BezierPatch::ControlNet> WholeWith(PatchIndex index, double tolerance) const;
  PatchIndex MakeParent(const std::array<ClayPatch, 4>& part, const BezierPatch::ControlNet& whole, std::uint32_t node);
  void PullNow(PatchIndex index);
  void SplitCoarserAround(PatchIndex index, LeafChange& change);
  std::vector<PatchIndex> MakeWall(const Hole& hole, const ClayPatch& entry, const ClayPatch& exit);
  void JoinWall(const Hole& hole, const std::vector<PatchIndex>& wall, const ClayPatch& entry, const ClayPatch& exit);
  void TakeOver(const ClayJoin& join, PatchIndex wall, std::uint8_t edge);
  void TakeOut(PatchIndex index);
  PatchIndex PutBack(const Part& part, std::uint32_t rank);

  std::vector<Base> roots_;  ///< As they were joined.
  std::size_t leaves_ = 0;
  std::vector<ClayPatch> patches_;
  std::vector<ClayVertex> vertices_;
  std::vector<Node> nodes_;                ///< The first are those of the patches of which the body was made.
  std::vector<std::uint32_t> wall_nodes_;  ///< Of the holes' walls.
  std::vector<Hole> holes_;
  std::vector<PatchIndex> free_patches_;
  std::vector<VertexIndex> free_vertices_;
  std::vector<std::uint32_t> free_nodes_;
  friend class ClayMeshBuilder;
};

/// The half of a coarser patch's row of four points that a finer patch is slaved to, from the coarse edge's middle to
/// its end: points 0 and 1 of it.
struct SlavedPair {
  Eigen::Vector3d middle;
  Eigen::Vector3d next;
};
[[nodiscard]] SlavedPair HalfRow(const std::array<Eigen::Vector3d, 4>& row, std::size_t half);

template <class NetOf>
void ClayMesh::PullSlaves(PatchIndex index, const NetOf& net_of, BezierPatch::ControlNet& net) const {
  const ClayPatch& own = patches_[index];
  for (std::size_t edge = 0; edge < 4; ++edge) {
    const ClayJoin& join = own.join[edge];
    if (join.kind != ClayJoin::Kind::kCoarser) continue;
    const BezierPatch::ControlNet& coarse = net_of(join.patch[0]);
    std::array<Eigen::Vector3d, 4> rim;
    std::array<Eigen::Vector3d, 4> inner;
    for (std::size_t s = 0; s < 4; ++s) {
      const auto [i, j] = NetIndex(join.edge[0], s, 0);
      const auto [k, l] = NetIndex(join.edge[0], s, 1);
      rim[s] = coarse[i][j];
      inner[s] = coarse[k][l];
    }
    const SlavedPair on_edge = HalfRow(rim, join.half);
    const SlavedPair inside = HalfRow(inner, join.half);
    // Edges run in opposite directions: the coarse edge's first half ends where this one starts.
    const std::size_t at_middle = join.half == 0 ? 0 : 3;
    const std::size_t at_next = join.half == 0 ? 1 : 2;
    const double step = 0.5 / join.ratio;
    const auto set = [&](std::size_t along, const Eigen::Vector3d& rim_point, const Eigen::Vector3d& inner_point) {
      const auto [i, j] = NetIndex(edge, along, 0);
      net[i][j] = rim_point;
      if (!join.smooth) return;
      const auto [k, l] = NetIndex(edge, along, 1);
      net[k][l] = rim_point - step * (inner_point - rim_point);
    };
    set(at_middle, on_edge.middle, inside.middle);
    set(at_next, on_edge.next, inside.next);
  }
}

}  // namespace annulus
