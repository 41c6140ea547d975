#pragma once

#include <nlohmann/json_fwd.hpp>

#include "fitting/paper_model.h"

namespace annulus {

/// How the knots of both directions were found, as in MODEL.json and in the report of `fit` (docs/formats.md).
[[nodiscard]] nlohmann::ordered_json PaperReportToJson(const PaperFitReport& report);

/// The entry `paper` of a surface in MODEL.json: the report, and control points over (u, v).
[[nodiscard]] nlohmann::ordered_json PaperModelToJson(const PaperModel& model);
/// Reads it back to the same bits. Throws BadModel on anything that PaperModelToJson would not write.
[[nodiscard]] PaperModel PaperModelFromJson(const nlohmann::ordered_json& json);

}  // namespace annulus
