#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/frame_design.h"

namespace annulus {

/// A design that can be built, and what was changed to make it so.
struct AdjustedDesign {
  FrameDesign design;
  std::vector<std::string> messages;  ///< One sentence per changed field: what was given, what is used and why.
};

/// The buildable design nearest to `design`: fields are taken in the order size, height, thickness, corners (together,
/// by least squares), bridge height, forms, details, each moved as little as the ones before it allow. A valid design
/// comes back as it is, so adjusting twice changes nothing more. Fails only if a number is not finite.
[[nodiscard]] Result<AdjustedDesign> AdjustDesign(const FrameDesign& design);

}  // namespace annulus
