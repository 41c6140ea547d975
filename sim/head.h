#pragma once

#include "sim/parametric_body.h"

namespace annulus::sim {

/// A head at the height of a standing person of `height_mm` (a bust on a stand), for the head profile.
struct HeadOptions {
  double height_mm = 1700.0;  ///< Stature of the person it belongs to, 1400 … 2000 mm; everything scales with it.
  Placement placement{3.0, -2.0, 0.02};
};

/// The subject "head": the head of MakePerson with finer features (lips, eyelids, nostril wings, ear conchae) and a
/// neck that ends in a smooth closed bottom at 0.82 of the stature (about 1396 mm). Requires the options' ranges.
[[nodiscard]] ParametricBody MakeHead(const HeadOptions& options);

}  // namespace annulus::sim
