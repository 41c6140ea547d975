#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>

#include "acquisition/json_text.h"
#include "base/ring_calibration.h"

namespace annulus {

/// A calibration as a JSON object (docs/formats.md), in recordings and calibration files; numbers keep every bit. What
/// an ideal ring does not have (pose, carriage, temperature, uncertainty, quadratic terms) is left out where it is not
/// there.
void PutCalibration(JsonText& json, const RingCalibration& calibration);
/// The same as a value.
[[nodiscard]] nlohmann::ordered_json JsonFromCalibration(const RingCalibration& calibration);
/// The failure says in a few words what is wrong.
tl::expected<RingCalibration, std::string> CalibrationFromJson(const nlohmann::ordered_json& json);
/// What makes a calibration impossible: no sensors, a number that is not finite or out of range …
tl::expected<void, std::string> CheckCalibration(const RingCalibration& calibration);

}  // namespace annulus
