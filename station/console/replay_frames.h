#pragma once

#include <chrono>
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>

#include "acquisition/scan_sink.h"

namespace annulus {

/// What passed the buses from `from` on and before `to` (host clock), in words: [{time_ns, bus, direction: "in"|"out"|
/// "call", bytes_hex, meaning}]. A level frame is told with its board, SYNC count, clock and readings; frames that are
/// cut by a transfer's end are put together with what came before. At most 2,000; a record that cannot be read says so.
[[nodiscard]] nlohmann::ordered_json FramesJson(std::span<const RawRecord> raw, std::chrono::nanoseconds from,
                                                std::chrono::nanoseconds to);

}  // namespace annulus
