#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "modeling/landmarks/landmark_edit.h"

namespace annulus {

/// LANDMARKS.json (docs/formats.md): the landmarks set by hand, which a reader applies, and the detected ones, which
/// are for people and are found again on the model. The same landmarks give the same bytes. sd are those of `body`.
[[nodiscard]] std::string LandmarksToJson(const MeasuredSurface& body, const Landmarks& landmarks);

/// The landmarks of the file that were set by hand. `name` of the file is for messages. Whether their ids and places
/// are good is for SetByHand to say; here numbers must be finite, and no id may come twice.
[[nodiscard]] Result<std::vector<GivenLandmark>> GivenLandmarksFromJson(std::string_view json, std::string_view name);

/// Sets every landmark of the file by hand. Fails with the first that cannot be set.
[[nodiscard]] Result<Landmarks> ApplyLandmarksFile(const MeasuredSurface& body, const Landmarks& landmarks,
                                                   std::string_view json, std::string_view name);

}  // namespace annulus
