#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "station/body_maps.h"

namespace annulus {

/// The numbers of a CSV table `theta_deg,z_mm,value`: on a full grid bilinear between its places (nan where one of the
/// four is nan or the place lies above or below the grid), else those of the nearest place within three times their
/// spacing. Main segment only; borrows `model`. `name` of the file is for messages and the title.
[[nodiscard]] Result<BodyField> ValuesField(const SurfaceModel& model, std::string_view csv, const std::string& name);

}  // namespace annulus
