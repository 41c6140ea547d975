#include "modeling/glasses/rimless_mount.h"

#include <algorithm>
#include <utility>

#include "modeling/bezier/shell_solids.h"
#include "modeling/glasses/hidden_end.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

// mm.
constexpr double kInset = 3.0;
constexpr double kDiscThickness = 1.2;
constexpr double kNutRadius = 1.6;
constexpr double kNutThickness = 1.0;
/// The screw leaves 0.05 mm around it.
constexpr double kScrewRadius = 0.5 * kLensHoleDiameter - 0.05;

}  // namespace

RimlessMount MakeRimlessMount(std::string name, const FrameDesign& design, const Rim& rim, RimSide side, double z,
                              double width) {
  const Vector3d edge = CentreLineAt(rim, side, z);
  const Eigen::Matrix3d& turn = rim.frame_from_rim.linear();
  const Vector3d inward = (side == RimSide::kNose ? 1.0 : -1.0) * turn.col(0);
  const double inset = std::min(kInset, 0.2 * design.parameters.width);
  RimlessMount mount;
  mount.frame_from_mount.setIdentity();
  mount.frame_from_mount.linear().col(0) = turn.col(2);
  mount.frame_from_mount.linear().col(1) = turn.col(0);
  mount.frame_from_mount.linear().col(2) = turn.col(1);
  mount.frame_from_mount.translation() = edge + inset * inward;
  const double half = 0.5 * design.details.lens_edge;
  mount.end = {mount.frame_from_mount * Vector3d(0.0, 0.0, half + 0.5 * kDiscThickness),
               std::min(0.5 * width, 0.75 * kMountRadius) * turn.col(2), 0.5 * kDiscThickness * turn.col(1)};
  mount.shell = TurnedShell(std::move(name), mount.frame_from_mount,
                            {{kMountRadius, half + kDiscThickness},
                             {kMountRadius, half},
                             {kScrewRadius, half},
                             {kScrewRadius, -half},
                             {kNutRadius, -half},
                             {kNutRadius, -half - kNutThickness}},
                            ProfileEnds::kDiscs);
  return mount;
}

}  // namespace annulus
