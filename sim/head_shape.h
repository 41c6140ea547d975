#pragma once

#include <functional>
#include <vector>

#include "sim/parametric_body.h"
#include "sim/star_tube.h"

namespace annulus::sim {

/// The parametric head that MakePerson and MakeHead share, for a stature of `scale` · 1700 mm. All mm, body
/// coordinates.

/// Sections from the middle of the neck (1440 mm at scale 1) to the crown, upwards.
[[nodiscard]] std::vector<TubeRow> HeadRows(double scale);
/// Nose, brow, eye sockets, cheeks, lips, chin, ears.
[[nodiscard]] std::vector<TubeBump> FaceBumps(double scale);
/// What only the 1 mm head profile resolves: lids, nostril wings, parted lips, philtrum, ear conchae.
[[nodiscard]] std::vector<TubeBump> FineFaceBumps(double scale);
/// Where the crown begins to close, and the vertex.
[[nodiscard]] double CrownStart(double scale);
[[nodiscard]] double CrownTip(double scale);
/// Landmarks found on the finished shape.
[[nodiscard]] FaceTruth FindFace(const StarTube& tube, double scale);
/// "head" (largest tape above the brow) and "neck" (smallest tape below the chin).
[[nodiscard]] std::vector<NamedLevel> HeadLevels(const StarTube& tube, double scale);

/// Where a function with one maximum in [low, high] has it, to 1e-6 of the interval (golden section; Kiefer 1953).
[[nodiscard]] double FindMaximum(const std::function<double(double)>& value, double low, double high);

}  // namespace annulus::sim
