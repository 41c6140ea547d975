#pragma once

#include <chrono>
#include <nlohmann/json_fwd.hpp>

#include "station/booth_messages.h"
#include "station/console/booth_link.h"
#include "station/sheet_words.h"

namespace annulus {

/// `status` and `booth` as boothd says them (docs/wire_protocol.md §5.3), without their envelope.
[[nodiscard]] nlohmann::ordered_json StatusToJson(const StatusMessage& status);
[[nodiscard]] nlohmann::ordered_json DescriptionToJson(const BoothDescription& booth);

/// The answer to GET /api/booth: {connected, why, booth, status, plain}.
[[nodiscard]] nlohmann::ordered_json BoothToJson(const BoothLink& link, SheetLanguage language);

/// The live message of a status; null: boothd is away. `plain` is in English, `plain_ja` in Japanese.
[[nodiscard]] nlohmann::ordered_json LiveStatus(const StatusMessage* status, const std::string& why, bool start_agreed);
/// The live message of a level: distances from the axis, mm, to 0.01, null where nothing came back. `wall`: now.
[[nodiscard]] nlohmann::ordered_json LiveLevel(const LevelMessage& level, double ring_radius_mm,
                                               std::chrono::nanoseconds wall);

}  // namespace annulus
