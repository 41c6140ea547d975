#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "base/result.h"
#include "modeling/bezier/bezier_tube.h"
#include "modeling/glasses/frame_design.h"

namespace annulus {

/// Where a temple turns, frame frame. At rest (open) the temple's front face stands kHingeGap behind the end piece.
struct HingeAxis {
  Eigen::Vector3d point;    ///< On the axis, in the middle of the gap's height, mm.
  Eigen::Vector3d up;       ///< Unit, along the axis and the temple's section.
  Eigen::Vector3d back;     ///< Unit, the way the temple leaves.
  Eigen::Vector3d outward;  ///< Unit, away from the head: up × back (of the right temple).
  double height = 0.0;      ///< Of the three knuckles together, mm.
};

/// Between an end piece's and its open temple's faces, mm.
inline constexpr double kHingeGap = 0.15;

/// One temple (fig. 16): F leaves the rim sideways, turns and runs to the ear; R bends behind it. Chains run from the
/// tip forward: row 0 of a tube is behind its row 3.
struct FrameArm {
  std::vector<BezierTube> end_piece;  ///< From the hinge into the rim (or mount); empty without a hinge.
  /// From the tip to the hinge, without a hinge into the rim. The paper's temple is R, F.
  std::vector<BezierTube> temple;
  std::size_t ear_tube = 0;     ///< The tube of `temple` whose row 3 is at the ear (R's).
  double l6 = 0.0;              ///< mm; the length that the face decides: from row 1 of F (the hinge) to the ear.
  Eigen::Vector3d ear_point;    ///< Q30ᴬ of R: the lower seam at the joint, mm.
  double length_to_bend = 0.0;  ///< Along the centre line from the hinge (the corner without one) to the ear, mm.
  double overall_length = 0.0;  ///< From there to the tip's end, mm: the temple length that is stamped on frames.
  std::optional<HingeAxis> hinge;

  /// Row 3 of the last tube: the section inside the rim or, with a hinge, of the end piece's.
  [[nodiscard]] const BezierTube& attachment() const { return end_piece.empty() ? temple.back() : end_piece.back(); }
};

/// The corner (row 2 of F) where a right temple turns back, that begins in section `root`: l4 sideways of it; with a
/// hinge farther if that does not bring the temple past the rim.
[[nodiscard]] Eigen::Vector3d TempleCorner(const FrameDesign& design, const TubeSection& root);

/// Height of a temple's section at the ear, mm.
[[nodiscard]] double EarHeight(const FrameDesign& design);

/// The right temple from `root` (inside rim or mount) to the ear. Fails if the ear is not behind the corner by at least
/// seven arm segments or far to the side; `side_name` is for the message.
[[nodiscard]] Result<FrameArm> MakeArm(const FrameDesign& design, const TubeSection& root, const TempleShape& shape,
                                       const char* side_name);

/// The arm mirrored at x = 0. A and B change sides, the seams stay.
[[nodiscard]] FrameArm MirroredX(const FrameArm& arm);

}  // namespace annulus
