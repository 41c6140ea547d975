#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "modeling/clay/clay_mesh.h"
#include "modeling/clay/cubic.h"

namespace annulus {

/// How a vertex's linked group moves: a point p of it by move + gradient·(p − c), c being where the vertex stands. One
/// affine map per group keeps what lies in a plane or on a line there, and its ratios: smooth joins stay smooth.
struct GroupMotion {
  VertexIndex vertex = kNoIndex;
  Eigen::Vector3d move = Eigen::Vector3d::Zero();      ///< mm
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();  ///< mm/mm
};

/// What is to become of a body (paper 004, §2.5): the groups P_A of the direct region move by M_A; those of the
/// indirect region, P_B, by k·M_B, where k is what keeps the volume. A group may be in both: both are taken from where
/// it stands.
struct ClayDeformation {
  std::vector<GroupMotion> direct;
  std::vector<GroupMotion> indirect;
};

/// Which of many things were visited, with no cost for those that were not. Kept between uses.
class VisitMarks {
 public:
  void Begin(std::size_t count) {
    if (mark_.size() < count) mark_.resize(count, 0);
    if (slot_.size() < count) slot_.resize(count, 0);
    ++now_;
  }
  [[nodiscard]] bool Has(std::size_t index) const { return mark_[index] == now_; }
  [[nodiscard]] std::uint32_t Slot(std::size_t index) const { return slot_[index]; }
  void Set(std::size_t index, std::uint32_t slot) {
    mark_[index] = now_;
    slot_[index] = slot;
  }

 private:
  std::uint64_t now_ = 0;
  std::vector<std::uint64_t> mark_;
  std::vector<std::uint32_t> slot_;
};

/// A deformation that is tried: the nets of the leaves it touches, A + k·D, slaved points included. Borrows mesh and
/// marks for its life.
class ClayTrial {
 public:
  ClayTrial(const ClayMesh& mesh, VisitMarks& marks, const ClayDeformation& deformation);

  [[nodiscard]] const std::vector<PatchIndex>& touched() const { return touched_; }
  /// Σ of the cones of the touched leaves, mm³, as a polynomial of k.
  [[nodiscard]] Cubic VolumeAlong(const Eigen::Vector3d& apex) const;
  /// Whether k moves the n-th touched leaf.
  [[nodiscard]] bool Follows(std::size_t n) const { return follows_[n]; }
  /// Net of the n-th touched leaf.
  [[nodiscard]] BezierPatch::ControlNet NetAt(std::size_t n, double k) const;

 private:
  std::uint32_t Touch(PatchIndex index);
  void Move(const ClayDeformation& deformation);
  void Slave();

  const ClayMesh& mesh_;
  VisitMarks& marks_;
  std::vector<PatchIndex> touched_;
  std::vector<std::vector<PatchIndex>> by_rank_;
  std::vector<BezierPatch::ControlNet> at_;
  std::vector<BezierPatch::ControlNet> along_;
  std::vector<bool> follows_;
};

}  // namespace annulus
