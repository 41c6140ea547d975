#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/scan.h"
#include "base/result.h"

namespace annulus {

/// One sensor in a reference check.
struct CheckedSensor {
  /// Mean of what it read longer than the target's surface is away, mm; what all have in common is not in it. NaN: it
  /// did not see the target.
  double offset_mm = std::numeric_limits<double>::quiet_NaN();
  double sigma_mm = std::numeric_limits<double>::quiet_NaN();  ///< sd of it: noise only.
};

/// What a scan of a known cylinder said of the ring: what arming a scan asks for (ScanGate).
struct ReferenceRecord {
  std::string scan_hash;
  std::string ring_serial;
  std::string calibration;         ///< Certificate in force; "" for an ideal ring.
  std::int64_t wall_start_ns = 0;  ///< When the scan was taken, ns since 1970; 0 where unknown.
  bool passed = false;
  std::string target_serial;       ///< "" where it has none.
  std::string certificate_number;  ///< "" where it has none.
  double target_radius_mm = 0.0;   ///< At the check's temperature.
  double target_u_mm = 0.0;        ///< Expanded uncertainty of it (k = 2).
  double x_mm = 0.0;               ///< Where its axis stood in the middle of what was seen, station frame.
  double y_mm = 0.0;
  double tilt_deg = 0.0;
  double common_mm = 0.0;        ///< By how much all sensors together read too long.
  double common_sigma_mm = 0.0;  ///< sd of it: noise only.
  double moved_mm = 0.0;         ///< By how much the target's place changed during the scan.
  std::vector<CheckedSensor> sensors;
  std::vector<std::string> findings;  ///< What is wrong, one sentence each; empty if it passed.
  std::vector<std::string> advice;    ///< What to do, in order.
};

/// The record as JSON (docs/formats.md, "Reference check").
[[nodiscard]] nlohmann::ordered_json JsonFromCheck(const ReferenceRecord& record);
/// Nothing in `json` is trusted: refuses what is missing, of another type or out of range.
Result<ReferenceRecord> CheckFromJson(const nlohmann::ordered_json& json);
/// The same from a file's text; `name` stands in the message.
Result<ReferenceRecord> ParseReference(std::string_view text, const std::string& name);

/// Whether scans may be taken on the strength of a check: of this ring and calibration, passed, and not older than
/// `max_age` at `now_ns` (ns since 1970). Else what is missing and what to do.
[[nodiscard]] Status JudgeReference(const ReferenceRecord& record, const ScanHeader& header, std::int64_t now_ns,
                                    std::chrono::hours max_age);

}  // namespace annulus
