#pragma once

#include <cstdint>
#include <string>

#include "subject.h"

namespace annulus::test {

/// What a property found over many states.
struct Tally {
  std::uint64_t states = 0;
  std::uint64_t levels = 0;         ///< Returned.
  std::uint64_t false_levels = 0;   ///< Returned, but not as written, or out of order.
  std::uint64_t false_records = 0;  ///< The same of axis points and events.
  std::uint64_t false_headers = 0;
  std::uint64_t durable_lost = 0;       ///< Promised levels that are not there.
  std::uint64_t most_durable_lost = 0;  ///< In one state.
  std::uint64_t unreadable = 0;    ///< States whose recording is missing or cannot be read although it was durable.
  std::uint64_t miscounted = 0;    ///< Reports that call damage whole, or count other losses than there are.
  std::uint64_t over_bound = 0;    ///< States with more levels at risk than promised.
  std::uint64_t most_at_risk = 0;  ///< Levels given, less durable ones.
  std::uint64_t most_lost = 0;     ///< Levels given, less returned ones.
  std::string first;               ///< The first violation in words.

  [[nodiscard]] bool ok() const { return first.empty() && states > 0; }
  void Violate(std::uint64_t& counter, const std::string& what);
  /// One line for people.
  [[nodiscard]] std::string Line(const std::string& property) const;
};

/// Whether every value of a recording is one that was written, in order; `place` goes into the tally's words.
void CheckNothingFalse(const Recording& read, const Trace& trace, const std::string& place, Tally& tally);

/// Whether the report of damage agrees with the levels returned. `all`: levels that the file had when it was whole.
void CheckReport(const Recording& read, const Trace& trace, const std::string& place, Tally& tally);

/// Levels that a power cut may cost at this rate (RELIABILITY P2: 100 ms, one write, one sync in progress).
[[nodiscard]] std::uint64_t LevelsAtRisk(std::uint32_t levels_per_s);

/// Draws a cut of the trace's journal from a seed.
[[nodiscard]] PowerCut DrawCut(const Trace& trace, std::uint64_t seed);

/// One state: what P2 and P3 promise of the files that are left.
void CheckPowerCut(const Trace& trace, const PowerCut& cut, const Reader& reader, Tally& tally);

/// `states` cuts of the traces in turn, seeds from `first_seed`.
Tally CutPower(const std::vector<Trace>& traces, const Reader& reader, std::uint64_t first_seed, std::uint64_t states);

/// Recordings of the subject at 24 and 50 levels per second.
[[nodiscard]] std::vector<Trace> RecordAtBothRates(const Subject& subject);

}  // namespace annulus::test
