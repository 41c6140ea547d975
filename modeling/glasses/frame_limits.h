#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "modeling/glasses/frame_design.h"

namespace annulus {

/// What a detail may be, given the fields before it in DetailRules(), in the field's inner unit.
struct DetailLimits {
  double low = 0.0;
  double high = 0.0;
  std::string_view why;  ///< Why not beyond, for messages.
};

enum class DetailUnit { kMillimetres, kDegrees, kDioptres };

/// A numeric detail of a frame and its limits. Exactly one of the two members is set.
struct DetailRule {
  std::string_view name;  ///< As users know it: "bridge-gap".
  DetailUnit unit;        ///< In which users see it.
  double FrameDetails::*member;
  std::optional<double> FrameDetails::*optional_member;
  DetailLimits (*limits)(const FrameDesign&);

  /// The value that is checked; nothing for an absent detail that has no limits.
  [[nodiscard]] std::optional<double> Value(const FrameDesign& design) const;
  /// `value` as users see it: "12.5 mm".
  [[nodiscard]] std::string Text(double value) const;
};

/// Depth of the deepest groove that the rim's walls allow with the design's groove width, mm.
[[nodiscard]] double DeepestGroove(const FrameDesign& design);

/// All of them; limits depend on the parameters, the forms and earlier fields only.
[[nodiscard]] std::span<const DetailRule> DetailRules();

}  // namespace annulus
