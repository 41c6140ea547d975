#pragma once

#include <Eigen/Core>

#include "render/opaque_picture.h"

namespace annulus {

/// Where a ray behind a lens ends, in the picture.
struct MarchEnd {
  enum class Kind {
    kMet,     ///< It meets what is seen at this place.
    kHidden,  ///< It ends where the eye does not see: behind something or beside the picture. This is the last place
              ///< on its way that is in sight.
    kMissed,  ///< It meets nothing; this is where its direction points.
  } kind = Kind::kMissed;
  double x = 0.0;  ///< Samples, centres at whole numbers; finite, may lie outside the picture unless kMet.
  double y = 0.0;
  float depth = kNoDepth;  ///< mm of what is met.
};

/// Follows the ray from `start` (camera frame, mm, in sight and before what is stored there) in `direction` (unit)
/// through the depths of `picture`. `farthest`: the greatest finite depth of the picture, mm.
[[nodiscard]] MarchEnd MarchRay(const OpaquePicture& picture, const Eigen::Vector3d& start,
                                const Eigen::Vector3d& direction, double farthest);

}  // namespace annulus
