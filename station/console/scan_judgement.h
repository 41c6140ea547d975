#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "acquisition/recording.h"
#include "base/result.h"

namespace annulus {

/// Code of the notice of a scan that was broken off, beside those of NoticeCode.
inline constexpr const char* kIncompleteNotice = "incomplete";

/// What a recording says of itself, and what it is good for.
struct ScanJudgement {
  ScanHeader header;
  std::string verdict;  ///< "good", "usable", "repeat".
  bool parked = false;  ///< The ring stood still: there is no body to fit.
  /// `summary` of docs/console_api.md §7: {levels, planned_levels, recording_bytes (opened), coverage, notices,
  /// quality, released}.
  std::string summary_json;
};

/// Judges a recording as `annulus inspect` does; a scan that was broken off is to be repeated, however good its part
/// is. `ticket`: kept in the summary, so that the same recording is not taken twice. Fails if it cannot be read.
Result<ScanJudgement> JudgeRecording(std::span<const std::byte> bytes, const std::string& name, const KeySource* keys,
                                     const std::string& ticket);

}  // namespace annulus
