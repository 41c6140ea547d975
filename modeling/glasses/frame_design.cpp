#include "modeling/glasses/frame_design.h"

#include "base/ensure.h"

namespace annulus {

FrameDesign ScaledToWidth(const FrameDesign& design, double width) {
  FrameDesign scaled = design;
  scaled.parameters = ScaledToWidth(design.parameters, width);
  if (scaled.details.arm_height) *scaled.details.arm_height *= width / design.parameters.width;
  return scaled;
}

FrameDesign ScaledToSpacing(const FrameDesign& design, double spacing) {
  if (!design.details.bridge_gap) return ScaledToWidth(design, spacing / kRimSpacingShare);
  ENSURE(spacing > design.bridge_gap(), "rims do not overlap");
  return ScaledToWidth(design, spacing - design.bridge_gap());
}

Status Validate(const FrameDesign& design) { return Validate(design.parameters); }

}  // namespace annulus
