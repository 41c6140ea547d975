#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/bus_record.h"
#include "acquisition/scan_plan.h"
#include "acquisition/scan_sink.h"
#include "base/result.h"

namespace annulus {

/// A raw record, decoded.
struct ReplayEntry {
  std::chrono::nanoseconds time{0};  ///< Host clock.
  bus_record::Any what;
};

/// What a replay follows: the raw records of one scan, and where its parts are. All numbers in it can be calculated
/// with. A value.
struct ReplayScript {
  std::vector<ReplayEntry> entries;
  std::uint64_t unknown = 0;  ///< Records of a kind that this program does not know; they are left out.
  std::size_t opening = 0;    ///< Index of RingOpening; a RingOpened follows.
  std::size_t begun = 0;      ///< Index of ScanBegun.
  std::size_t ended = 0;      ///< Index of ScanEnded, or the number of entries.
  ScanPlan plan;
  std::optional<AxisReadingLayout> layout;  ///< Nothing: no axis was tapped.

  /// How the recorded scan ended; null: the recording does not reach so far.
  [[nodiscard]] const bus_record::ScanEnded* End() const {
    return ended < entries.size() ? &std::get<bus_record::ScanEnded>(entries[ended].what) : nullptr;
  }
};

/// Decodes raw records and finds their parts. Fails if they hold no scan, are of a newer format, or hold a number that
/// cannot be.
Result<ReplayScript> ReadReplayScript(std::span<const RawRecord> raw);

}  // namespace annulus
