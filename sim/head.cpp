#include "sim/head.h"

#include "base/ensure.h"
#include "sim/head_shape.h"

namespace annulus::sim {

ParametricBody MakeHead(const HeadOptions& options) {
  ENSURE(options.height_mm >= 1400.0 && options.height_mm <= 2000.0, "stature out of range");
  const double scale = options.height_mm / 1700.0;
  std::vector<TubeRow> rows{{1396 * scale, 70 * scale, 52 * scale, -82 * scale, 0, 0, 0},
                            {1420 * scale, 62 * scale, 46 * scale, -74 * scale, 0, 0, 0}};
  for (const TubeRow& row : HeadRows(scale)) rows.push_back(row);
  std::vector<TubeBump> bumps = FaceBumps(scale);
  for (const TubeBump& bump : FineFaceBumps(scale)) bumps.push_back(bump);
  const StarTube tube(rows, bumps, {1394 * scale, 1424 * scale, CrownStart(scale), CrownTip(scale)});
  ParametricBody::Description description;
  description.name = "head";
  description.parts.push_back({BodyPart::kTorso, tube});
  description.levels = HeadLevels(tube, scale);
  description.heights.crown_mm = CrownTip(scale);
  description.face = FindFace(tube, scale);
  description.placement = options.placement;
  return ParametricBody(description);
}

}  // namespace annulus::sim
