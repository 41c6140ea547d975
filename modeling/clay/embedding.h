#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "modeling/bezier/bezier_patch.h"
#include "modeling/clay/clay_mesh.h"
#include "modeling/clay/clay_trial.h"

namespace annulus {

/// Finds out whether a deformation would make a body's skin fold over or cross itself. A base patch lies in cells of
/// space, its quadtree is a tree of boxes: a search costs what is near and not what is far, however fine it is cut. A
/// value.
class Embedding {
 public:
  /// `cell` mm, about the size of a base patch.
  explicit Embedding(double cell = 1.0) : cell_(cell) {}

  /// A leaf of the mesh is new, or elsewhere. Those that are no more need not be told.
  void Place(const ClayMesh& mesh, PatchIndex index);
  /// All of the body is now at scale·p + shift: nothing has to be placed anew.
  void Move(double scale, const Eigen::Vector3d& shift);

  /// Why the trial at k is none, or empty: a leaf that folds over (its skin turns by more than a right angle within a
  /// quarter of it, and did not before) or two leaves that cross (as 4 × 4 cells of two triangles) and did not before.
  /// Of two with a common vertex, cells that both lie beside what they share are not held against each other, and none
  /// is where both face one way.
  [[nodiscard]] std::string Trouble(const ClayMesh& mesh, const VisitMarks& marks, const ClayTrial& trial,
                                    double k) const;
  /// Whether one of these leaves crosses another that it has no vertex with; empty: none does.
  [[nodiscard]] std::string TroubleOf(const ClayMesh& mesh, const std::vector<PatchIndex>& leaves) const;

 private:
  using Cell = std::uint64_t;
  static constexpr std::size_t kMostCells = 64;  ///< A base patch that spans more is looked at always.

  void PlaceRoot(std::uint32_t root);
  void Forget(std::uint32_t root);
  [[nodiscard]] std::vector<Cell> CellsOf(const Eigen::AlignedBox3d& box) const;
  /// Base patches whose box may meet this one, each once.
  [[nodiscard]] std::vector<std::uint32_t> RootsNear(const ClayMesh& mesh, const Eigen::AlignedBox3d& box) const;
  /// Leaves whose box meets this one, each once.
  [[nodiscard]] std::vector<PatchIndex> Near(const ClayMesh& mesh, const Eigen::AlignedBox3d& box) const;

  /// A box in the space of the cells, in which the body stays where it was when all of it moves.
  [[nodiscard]] Eigen::AlignedBox3d InCells(const Eigen::AlignedBox3d& box) const;

  double cell_;
  double scale_ = 1.0;  ///< p = scale·(p in cells) + shift.
  Eigen::Vector3d shift_ = Eigen::Vector3d::Zero();
  std::unordered_map<Cell, std::vector<std::uint32_t>> roots_;
  std::vector<std::uint32_t> large_;
  std::vector<std::vector<Cell>> cells_;  ///< Of each base patch's node; empty: it is among the large ones.
  std::vector<Eigen::AlignedBox3d> box_;  ///< Of each node of the quadtrees, in the space of the cells.
};

}  // namespace annulus
