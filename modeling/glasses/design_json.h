#pragma once

#include <optional>

#include "modeling/glasses/frame_design.h"
#include "modeling/glasses/frame_material.h"
#include "modeling/glasses/json_reader.h"

namespace annulus {

/// The parts that FRAME.json, WORN.json and a library of styles have in common: `style` (left out if empty), `material`
/// (left out if absent), `parameters` (all nine) and `details` (only those that are not the paper's).

/// Adds the design's keys to `object`.
void PutDesign(nlohmann::ordered_json& object, const FrameDesign& design, std::optional<DesignMaterial> material);
/// Reads `parameters` and `details` (may be absent) of `object`; not `style`. Fails unless the design is valid.
[[nodiscard]] Result<FrameDesign> ReadDesign(const JsonReader& reader, const nlohmann::ordered_json& object);
/// Reads `material`; absent is fine.
[[nodiscard]] Result<std::optional<DesignMaterial>> ReadMaterial(const JsonReader& reader,
                                                                 const nlohmann::ordered_json& object);

/// Temples and pads of one wearer.
[[nodiscard]] nlohmann::ordered_json AdjustmentToJson(const FrameAdjustment& adjustment);
[[nodiscard]] Result<FrameAdjustment> ReadAdjustment(const JsonReader& reader, const nlohmann::ordered_json& parent);

}  // namespace annulus
