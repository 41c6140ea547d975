#include "modeling/landmarks/landmark.h"

namespace annulus {

std::string_view LandmarkSourceName(LandmarkSource source) {
  switch (source) {
    case LandmarkSource::kDetected:
      return "detected";
    case LandmarkSource::kProportion:
      return "proportion";
    case LandmarkSource::kGiven:
      return "given";
  }
  return "given";
}

const Landmark* Landmarks::Find(std::string_view id) const {
  for (const Landmark& landmark : found) {
    if (landmark.id == id) return &landmark;
  }
  return nullptr;
}

}  // namespace annulus
