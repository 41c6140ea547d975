#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "fitting/systematic_errors.h"

namespace annulus {

/// The values of `calibration_covariance` and `sway` of MODEL.json (docs/formats.md); null where not known.
[[nodiscard]] nlohmann::ordered_json CalibrationToJson(const std::optional<SystematicErrors>& errors);
[[nodiscard]] nlohmann::ordered_json SwayToJson(const std::optional<SystematicErrors>& errors);

/// Reads both from the model's object; nothing where both are null or absent. Throws BadModel, naming the key.
[[nodiscard]] std::optional<SystematicErrors> SystematicFromJson(const nlohmann::ordered_json& model);

}  // namespace annulus
