#pragma once

#include <Eigen/Geometry>
#include <array>

#include "base/result.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/wearer_head.h"

namespace annulus {

/// How a temple came to lie.
struct TempleFit {
  TempleShape shape;             ///< Frame frame.
  double ear_distance = 0.0;     ///< mm, of the temple to the head about the ear point (25 mm before to 3 mm behind).
  double before_distance = 0.0;  ///< mm, least distance before that.
  double tip_distance = 0.0;     ///< mm, least distance of what lies behind the ear to the head without its ears.
};

/// Lays both temples of a front in a given pose: the lower edge on the ear point, moved outward until the temple just
/// touches the side of the head, bowed outward if it would enter before the ear, the tip turned in until it touches
/// the head behind the ear. Fails if a temple cannot reach its ear.
[[nodiscard]] Result<std::array<TempleFit, 2>> FitTemples(const WearerHead& head, const FrameDesign& design,
                                                          const Eigen::Isometry3d& station_from_frame,
                                                          const FrameAdjustment& pads,
                                                          const std::array<double, 2>& extra = {0.0, 0.0});

/// Largest bow of a temple, rad.
inline constexpr double kLargestBow = RadiansFromDegrees(12.0);

}  // namespace annulus
