#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "modeling/glasses/design_request.h"
#include "render/look.h"
#include "station/console/route.h"

namespace annulus {

// The parts that the designer's requests have in common (docs/console_api.md §9). Each fails with 400, naming the key
// with its place ("design.fields.height").

/// `design`: {style, size?, fields: {option: number or text}}. Numbers are in the field's unit and within the range
/// that the catalogue gives; texts are as on the command line ("16%", "slightly-round", "saddle").
[[nodiscard]] tl::expected<DesignRequest, ApiError> DesignIn(const nlohmann::json& body);
/// The same as JSON.
[[nodiscard]] nlohmann::ordered_json DesignJson(const DesignRequest& request);
/// The design composed from the built-in library. 400 if the style or size is not known, or cannot be.
[[nodiscard]] tl::expected<ComposedDesign, ApiError> ComposedIn(const nlohmann::json& body);

/// `look`: LOOK.json, whose format and version may be left out; the usual look without one.
[[nodiscard]] tl::expected<Look, ApiError> LookIn(const nlohmann::json& body);

/// `prescription`: RX.json as its text, checked; empty without one.
[[nodiscard]] tl::expected<std::optional<std::string>, ApiError> PrescriptionIn(const nlohmann::json& body);

}  // namespace annulus
