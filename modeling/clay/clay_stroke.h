#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "modeling/clay/clay_body.h"
#include "modeling/clay/clay_field.h"
#include "modeling/clay/clay_operation.h"
#include "modeling/clay/clay_region.h"

namespace annulus {

/// Where a stroke acts: the skin around an address that hangs together with it, cut to leaves no larger than `leaf_mm`;
/// if that is more than the radius, it stays cut as it is.
struct StrokePlace {
  ClayAddress at;
  Eigen::Vector3d centre;
  double radius_mm = 0.0;
  double leaf_mm = 0.0;
};

/// One step of an operation: fields for the direct and the indirect region (paper 004, §2.5).
struct ClayStroke {
  std::vector<StrokePlace> places;  ///< Empty: the whole body, cut as it is.
  ClayField direct;                 ///< Empty: none.
  ClayField indirect;               ///< Empty: the whole body is scaled.
  VolumeRule rule = VolumeRule::kKept;
};

/// Where masks hold still: 0, fading to 1 elsewhere; with the gradient in `move`'s place of a PointMotion's row.
class MaskWeight {
 public:
  MaskWeight(const ClayBody& body, const std::vector<ClayMask>& masks);
  [[nodiscard]] bool empty() const { return spots_.empty(); }
  /// The motion times the weight, its gradient by the product rule.
  [[nodiscard]] PointMotion Weigh(const Eigen::Vector3d& place, const PointMotion& motion) const;

 private:
  struct Spot {
    Eigen::Vector3d centre;
    double radius = 0.0;
  };
  std::vector<Spot> spots_;
};

/// Motions of the vertices of a region by a field, weighed; those that do not move are left out.
[[nodiscard]] std::vector<GroupMotion> MotionsOf(const ClayMesh& mesh, const std::vector<VertexIndex>& vertices,
                                                 const ClayField& field, const MaskWeight& mask);

/// Merges what an earlier operation left finer around a place than this one needs it, where that loses next to nothing
/// (5e-3 of the size that it needs). The volume that this changes is part of this operation's eq. 8. Returns what
/// ClayBody::Restore takes.
std::vector<ClayBody::FormerLeaf> CoarsenAround(ClayBody& body, const StrokePlace& place);

/// Refines, deforms, and scales where the stroke says so. The surface is the same as before, if perhaps cut finer, when
/// it fails.
Result<ClayChange> Carry(ClayBody& body, const ClayStroke& stroke, const MaskWeight& mask);

}  // namespace annulus
