#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "base/result.h"
#include "modeling/clay/clay_mesh.h"
#include "modeling/clay/clay_trial.h"
#include "modeling/clay/embedding.h"
#include "modeling/clay/pairwise_sum.h"

namespace annulus {

/// What becomes of a body's volume.
enum class VolumeRule {
  kKept,   ///< The indirect region takes up what the direct one displaces.
  kFreed,  ///< Only the direct region moves; the volume that it then has is kept from now on.
  kOwed,   ///< Only the direct region moves; kept_volume() stays, for ScaleToKept or the next kKept one to restore.
};

/// What a deformation did, mm³.
struct ClayChange {
  double volume_before_mm3 = 0.0;
  double volume_after_mm3 = 0.0;
  double k = 0.0;  ///< Of eq. 8; 0 for kFreed.
  std::size_t patches_touched = 0;
};

/// A body of virtual clay (paper 004): keeps its form while nothing acts on it, is deformed by its linked groups, and
/// keeps its volume exactly. The volume is that of the leaves' cones (eqs. 1–7), of which only those are computed anew
/// that a deformation touches; it is signed: what overlaps counts twice. A value.
class ClayBody {
 public:
  /// As ClayMesh::Make; fails also if the volume is not positive.
  static Result<ClayBody> Make(const PatchShell& shell);
  static Result<ClayBody> Make(ClayMesh mesh);

  [[nodiscard]] const ClayMesh& mesh() const { return mesh_; }
  /// mm³, of the surface as it is.
  [[nodiscard]] double volume() const { return cones_.total(); }
  /// mm³, what kKept deformations come back to: the volume at first, and after the last kFreed one.
  [[nodiscard]] double kept_volume() const { return kept_; }
  /// From now on `volume` mm³ (> 0) is what the body comes to: clay is added or taken away.
  void Keep(double volume);
  /// mm²
  [[nodiscard]] double Area() const;
  /// Where the cones have their common apex: near the middle of the body as it was made, mm.
  [[nodiscard]] const Eigen::Vector3d& apex() const { return apex_; }

  /// Point and outward unit normal at an address. Requires a patch below mesh().base_count().
  [[nodiscard]] Eigen::Vector3d Point(const ClayAddress& address) const;
  [[nodiscard]] Eigen::Vector3d Normal(const ClayAddress& address) const;

  /// Deforms (paper 004, §2.5). kKept: k is the real root nearest 0 of V(P_A + M_A, P_B + k·M_B) = kept_volume() for
  /// which no leaf folds over and no two leaves newly cross. Fails, and leaves the body as it was, if there is none, or
  /// if a number is not finite.
  Result<ClayChange> Deform(const ClayDeformation& deformation, VolumeRule rule);
  /// Grows or shrinks the body about `centre` so that its volume is kept_volume(), as k = (V0/V1)^(1/3) − 1 of eq. 8;
  /// nothing is computed anew. Requires a positive volume. Returns k.
  double ScaleToKept(const Eigen::Vector3d& centre);

  /// Cuts a leaf into four, and coarser ones across its edges first; the surface stays what it is. Returns the leaves
  /// that were made; some may be no more.
  std::vector<PatchIndex> Split(PatchIndex index);
  /// Merges what was cut in vain since the last time, or moved since: quarters of which all control points are within
  /// `tolerance` mm of the whole's. Returns how many leaves there are less.
  std::size_t MergeTouched(double tolerance);

  /// ClayMesh::OpenHole; kept_volume() stays, for ScaleToKept or the next kKept deformation to restore. Fails also if
  /// the hole's wall would cross the skin or itself; the body is then to be thrown away.
  Status OpenHole(const ClayMesh::Hole& hole);

  /// ClayMesh::FillHole, after merging what cuts the hole's wall, whatever that changes; kept_volume() stays. Fails
  /// also if what fills it would cross the skin; the body is then to be thrown away.
  Status FillHole(std::size_t hole);

  /// A leaf as it was.
  struct FormerLeaf {
    ClayMesh::Part part;
    BezierPatch::ControlNet net;
  };
  /// Merges quarters among these leaves where the whole is no larger than `size` mm (the longest side of its box) and
  /// within `tolerance` mm of them. That changes the volume a little: kept_volume() stays, for the next kKept
  /// deformation to restore. Returns what Restore takes to undo it.
  std::vector<FormerLeaf> Coarsen(const std::vector<PatchIndex>& leaves, double size, double tolerance);
  /// Undoes a Coarsen. Requires that nothing was done to the body since.
  void Restore(const std::vector<FormerLeaf>& former);

  /// How often leaves were made, moved or taken away; LeavesSince(then) are those after that count, each perhaps
  /// several times, some of them no more. Empty optional: all of them, since the whole body was moved.
  [[nodiscard]] std::size_t change_count() const { return first_change_ + log_.size(); }
  [[nodiscard]] std::optional<std::vector<PatchIndex>> LeavesSince(std::size_t count) const;

 private:
  ClayBody() = default;
  void Commit(const ClayTrial& trial, double k);
  void Renew(PatchIndex index);
  void Note(PatchIndex index);
  void Forget();
  void MergeAroundHole(std::size_t hole);
  void Follow(const LeafChange& change);
  /// Of every whole of which four leaves with one of these are the quarters: the first of them.
  [[nodiscard]] std::vector<PatchIndex> FirstQuartersOf(const std::vector<PatchIndex>& leaves) const;
  /// The k of eq. 8, and how fast the volume changes with it.
  struct Solution {
    double k = 0.0;
    double slope = 0.0;
  };
  /// Of the whole body, mm³, as a polynomial of the trial's k.
  [[nodiscard]] Cubic VolumeWith(const ClayTrial& trial) const;
  Result<Solution> Solve(const ClayTrial& trial);

  ClayMesh mesh_;
  PairwiseSum cones_;
  Embedding embedding_;
  VisitMarks marks_;
  Eigen::Vector3d apex_ = Eigen::Vector3d::Zero();
  double kept_ = 0.0;
  std::vector<PatchIndex> changed_;  ///< Since the last MergeTouched; some may be no more.
  std::vector<PatchIndex> log_;      ///< Of changes, from number first_change_ on.
  std::size_t first_change_ = 0;
};

}  // namespace annulus
