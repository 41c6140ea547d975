#include "modeling/clay/clay_trial.h"

#include "modeling/clay/patch_volume.h"

namespace annulus {

using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;

namespace {

ControlNet ZeroNet() {
  ControlNet net;
  for (auto& row : net) row.fill(Vector3d::Zero());
  return net;
}

const ControlNet& Nothing() {
  static const ControlNet zero = ZeroNet();
  return zero;
}

bool IsNothing(const ControlNet& net) {
  for (const auto& row : net) {
    for (const Vector3d& point : row) {
      if (!point.isZero(0.0)) return false;
    }
  }
  return true;
}

}  // namespace

ClayTrial::ClayTrial(const ClayMesh& mesh, VisitMarks& marks, const ClayDeformation& deformation)
    : mesh_(mesh), marks_(marks) {
  marks_.Begin(mesh.patches().size());
  Move(deformation);
  Slave();
  for (const ControlNet& net : along_) follows_.push_back(!IsNothing(net));
}

std::uint32_t ClayTrial::Touch(PatchIndex index) {
  if (marks_.Has(index)) return marks_.Slot(index);
  const auto slot = static_cast<std::uint32_t>(touched_.size());
  marks_.Set(index, slot);
  touched_.push_back(index);
  at_.push_back(mesh_.patch(index).net);
  along_.push_back(Nothing());
  const std::size_t rank = mesh_.patch(index).rank;
  if (by_rank_.size() <= rank) by_rank_.resize(rank + 1);
  by_rank_[rank].push_back(index);
  return slot;
}

void ClayTrial::Move(const ClayDeformation& deformation) {
  const auto move = [this](const GroupMotion& motion, std::vector<ControlNet>& nets) {
    const Vector3d centre = mesh_.Position(motion.vertex);
    for (const PatchCorner& at : mesh_.vertex(motion.vertex).corners) {
      const std::uint32_t slot = Touch(at.patch);
      const ControlNet& from = mesh_.patch(at.patch).net;
      for (std::size_t s = 0; s < 2; ++s) {
        for (std::size_t t = 0; t < 2; ++t) {
          const auto [i, j] = NetIndex(at.corner, s, t);
          nets[slot][i][j] += motion.move + motion.gradient * (from[i][j] - centre);
        }
      }
    }
  };
  for (const GroupMotion& motion : deformation.direct) move(motion, at_);
  for (const GroupMotion& motion : deformation.indirect) move(motion, along_);
}

void ClayTrial::Slave() {
  const auto at = [this](PatchIndex index) -> const ControlNet& {
    return marks_.Has(index) ? at_[marks_.Slot(index)] : mesh_.patch(index).net;
  };
  const auto along = [this](PatchIndex index) -> const ControlNet& {
    return marks_.Has(index) ? along_[marks_.Slot(index)] : Nothing();
  };
  // A finer leaf is slaved to coarser ones only: rank by rank all of them are what they will be.
  for (std::size_t rank = 0; rank < by_rank_.size(); ++rank) {
    for (std::size_t n = 0; n < by_rank_[rank].size(); ++n) {
      const PatchIndex index = by_rank_[rank][n];
      const std::uint32_t slot = marks_.Slot(index);
      mesh_.PullSlaves(index, at, at_[slot]);
      mesh_.PullSlaves(index, along, along_[slot]);
      for (const ClayJoin& join : mesh_.patch(index).join) {
        if (join.kind != ClayJoin::Kind::kFiner) continue;
        Touch(join.patch[0]);
        Touch(join.patch[1]);
      }
    }
  }
}

Cubic ClayTrial::VolumeAlong(const Vector3d& apex) const {
  Cubic sum;
  for (std::size_t n = 0; n < touched_.size(); ++n) {
    if (follows_[n]) {
      sum += ConeVolumeAlong(at_[n], along_[n], apex);
    } else {
      sum.c[0] += ConeVolume(at_[n], apex);
    }
  }
  return sum;
}

ControlNet ClayTrial::NetAt(std::size_t n, double k) const {
  ControlNet net = at_[n];
  if (!follows_[n]) return net;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) net[i][j] += k * along_[n][i][j];
  }
  return net;
}

}  // namespace annulus
