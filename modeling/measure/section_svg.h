#pragma once

#include <string>

#include "base/result.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// How a section is drawn.
struct SectionSvgOptions {
  std::string title{};  ///< UTF-8; "" gives "Section at z = … mm".
};

/// A picture of the section at height z, mm, as SVG 1.1 in true scale: 1 mm of the body is 1 mm on paper, seen from
/// above, the front up, the subject's left on the left. The section as cubic Bezier curves within 0.01 mm, inferred
/// arcs in another colour, gaps where it was not seen; the tape dashed; a cross through the ring's axis; a scale bar;
/// perimeter, tape and area with one sd, which need the whole section. Fails outside the scanned range, or if nothing
/// was seen.
[[nodiscard]] Result<std::string> SectionSvg(const MeasuredSurface& body, double z, const SectionSvgOptions& options);

}  // namespace annulus
