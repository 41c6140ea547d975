#include "modeling/glasses/frame_design.h"

#include <fmt/format.h>

#include <cmath>

#include "base/ensure.h"
#include "modeling/glasses/frame_limits.h"

namespace annulus {
namespace {

constexpr const char* kAttempt = "check the frame's design";

}  // namespace

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

Status Validate(const FrameDesign& design) {
  RETURN_IF_ERROR(Validate(design.parameters));
  for (const DetailRule& rule : DetailRules()) {
    const std::optional<double> value = rule.Value(design);
    if (value && !std::isfinite(*value)) {
      return Fail(kAttempt, fmt::format("{} is {}", rule.name, *value), "every size of a frame is a number");
    }
  }
  const FrameDetails& details = design.details;
  if (details.rim == RimForm::kRimless && details.bridge == BridgeForm::kKeyhole) {
    return Fail(kAttempt, "a keyhole bridge has no rims to grow from", "choose a saddle or a straight bridge");
  }
  if (details.rim == RimForm::kRimless && details.pads == PadForm::kFixed) {
    return Fail(kAttempt, "fixed pads have no rims to grow from", "choose adjustable pads or none");
  }
  for (const DetailRule& rule : DetailRules()) {
    const std::optional<double> value = rule.Value(design);
    if (!value) continue;
    const DetailLimits limits = rule.limits(design);
    if (*value >= limits.low && *value <= limits.high) continue;
    return Fail(kAttempt, fmt::format("{} is {}; {}", rule.name, rule.Text(*value), limits.why),
                limits.low <= limits.high
                    ? fmt::format("choose {} from {} to {}", rule.name, rule.Text(limits.low), rule.Text(limits.high))
                    : fmt::format("no {} fits the other sizes", rule.name));
  }
  return {};
}

}  // namespace annulus
