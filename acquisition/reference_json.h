#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>

#include "acquisition/scan.h"

namespace annulus {

// The keys of a recording that are there only with reference sensors (docs/formats.md). As scan_json.h.

[[nodiscard]] nlohmann::ordered_json JsonFromReference(const RecordedReference& reference);
tl::expected<RecordedReference, std::string> ReferenceFromJson(const nlohmann::ordered_json& json);
/// What makes them impossible: none, more than a board has, one channel twice, a number that is not finite.
tl::expected<void, std::string> CheckReference(const RecordedReference& reference);

/// Appends what the reference sensors said to the text of a level; nothing without them.
void AppendReferenceJson(const ScanLevel& level, std::string& text);
/// Takes it from a level's object, exactly `count` readings.
tl::expected<void, std::string> TakeReferenceJson(const nlohmann::ordered_json& json, std::size_t count,
                                                  ScanLevel& level);

}  // namespace annulus
