#include "station/worn_glasses.h"

#include "modeling/glasses/frame.h"
#include "modeling/landmarks/face_points.h"
#include "modeling/mesh/mesh_io.h"

namespace annulus {

Result<WornFrame> FitFrame(const SplineSurface& head, const FrameDesign& design) {
  const auto face = FindFacePoints(head);
  if (!face) return Fail(face);
  auto placed = PlaceFrame(design, *face);
  if (!placed) return placed;
  return ClearHead(*placed, head);
}

Result<std::string> FrameStl(const WornFrame& worn) {
  const auto frame = BuildWornFrame(worn);
  if (!frame) return Fail(frame);
  return WriteStl(TessellateFrame(*frame, {.along = 24, .around = 16}), "annulus frame, mm");
}

}  // namespace annulus
