#include "modeling/measure/place_check.h"

#include <cmath>

#include "base/units.h"
#include "modeling/measure/number_text.h"
#include "modeling/measure/surface_path.h"

namespace annulus {

std::string PlaceText(const SurfacePlace& place) {
  return "theta = " + NumberText(DegreesFromRadians(place.theta)) + " deg, z = " + NumberText(place.z) + " mm";
}

Status CheckPlace(const MeasuredSurface& body, const SurfacePlace& place, const std::string& attempted) {
  if (!std::isfinite(place.theta)) return Fail(attempted, "theta is not a finite number", "give it in degrees");
  RETURN_IF_ERROR(CheckInRange(body, place.z, attempted));
  if (body.KnowledgeAt(place.theta, place.z) == Knowledge::kUnknown) {
    return Fail(attempted, "the surface was not seen there", "choose a place that was scanned");
  }
  if (!(body.surface().Radius(place.theta, place.z) >= kAxisRadius)) {
    return Fail(attempted, "the surface meets the ring's axis there", "choose a place beside it");
  }
  return {};
}

}  // namespace annulus
