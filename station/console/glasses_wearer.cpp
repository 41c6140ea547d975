#include "station/console/glasses_wearer.h"

#include <string>
#include <utility>

#include "modeling/landmarks/face_points.h"

namespace annulus {

Result<std::shared_ptr<GlassesWearer>> GlassesWearer::Look(const MeasuredSurface& body, const Landmarks& landmarks) {
  FaceOverrides given;
  for (const NamedFacePoint& named : FacePointNames()) {
    const Landmark* const landmark = landmarks.Find(named.name);
    if (landmark == nullptr || landmark->source != LandmarkSource::kGiven) continue;
    given.points.push_back({std::string(named.name), landmark->position});
  }
  auto head = WearerHead::Look(body, given);
  if (!head) return Fail(head);
  return std::shared_ptr<GlassesWearer>(new GlassesWearer(std::move(*head)));
}

std::optional<WornFrame> GlassesWearer::last() const {
  const std::lock_guard lock(mutex_);
  return last_;
}

void GlassesWearer::Remember(const WornFrame& worn) {
  const std::lock_guard lock(mutex_);
  last_ = worn;
}

Result<std::shared_ptr<GlassesWearer>> GlassesWearerSlot::Get(const MeasuredSurface& body, const Landmarks& landmarks) {
  const std::lock_guard lock(mutex_);
  if (wearer_ == nullptr) {
    auto looked = GlassesWearer::Look(body, landmarks);
    if (!looked) return Fail(looked);
    wearer_ = std::move(*looked);
  }
  return wearer_;
}

}  // namespace annulus
