#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/frame_library.h"

namespace annulus {

/// A frame in the boxing system: what is engraved on it. Both lenses are alike.
struct FrameBoxing {
  double a = 0.0;              ///< Lens width, mm.
  double b = 0.0;              ///< Lens height, mm.
  double ed = 0.0;             ///< Effective diameter: twice the longest radius from the box centre, mm.
  double circumference = 0.0;  ///< Of a lens, mm.
  double dbl = 0.0;            ///< Distance between lenses: the smallest horizontal distance of the two outlines, mm.
  double box_distance = 0.0;   ///< Distance of the box centres: a + dbl, mm.
  double box_height = 0.0;     ///< Height of the box centres over the rim centres O0, O0', mm.
};

/// DBL: the smallest horizontal distance of the right lens' outline and its mirror image, in the front's plane, mm.
[[nodiscard]] double DistanceBetweenLenses(const Rim& rim);

/// The boxing of a frame that was built, from LensOutlineOf.
[[nodiscard]] FrameBoxing BoxingOf(const Frame& frame);
/// The boxing of a design. Fails if it cannot be built.
[[nodiscard]] Result<FrameBoxing> BoxingOf(const FrameDesign& design);

/// "52□18-140": A, DBL and temple length rounded to whole mm, as frames are marked; "52□18" without a temple length.
[[nodiscard]] std::string SizeText(const FrameBoxing& boxing, std::optional<double> temple);
/// Reads "52□18-140", "52-18-140" or "52x18-140", mm, decimals allowed. Fails on anything else.
[[nodiscard]] Result<SoldSize> ParseSize(std::string_view text);

/// A wanted box, mm. An absent value is left as the design has it: b as its proportion to a, dbl as its bridge gap.
struct WantedBox {
  double a = 50.0;
  std::optional<double> b;
  std::optional<double> dbl;
};

/// The design with l1, l2 and l0 solved so that BoxingOf gives `wanted` to 1e-6 mm: corners and the heights of bridge
/// and temples keep their shares of the shape, sections keep their size. Fails if no valid design has this box; the
/// error says which value cannot be had.
[[nodiscard]] Result<FrameDesign> DesignForBox(const FrameDesign& design, const WantedBox& wanted);
/// DesignForBox for the lens width alone.
[[nodiscard]] Result<FrameDesign> ScaledToBox(const FrameDesign& design, double a);

/// StandardAdjustment with the ears moved so that both temples are `length` mm long (FrameArm::overall_length). Fails
/// if no ear point gives that length.
[[nodiscard]] Result<FrameAdjustment> AdjustmentForTemple(const FrameDesign& design, double length);

}  // namespace annulus
