#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace annulus {

/// What stops nothing and should be known all the same. The code is what the console goes by.
enum class WarningCode : std::uint8_t {
  kOther,            ///< Of a newer program: only its text is known.
  kTicksLate,        ///< The computer is busy (H3).
  kWallClockSet,     ///< Values: by how many ms.
  kNotAcknowledged,  ///< Chain or devices say no when a fault is acknowledged.
  kDiskSlow,         ///< D4.
  kReferenceLost,    ///< The reference board gives no readings. Values: its serial number.
  kRingTemperature,  ///< Far from that of the calibration. Values: degrees C now, and then.
  kMemoryUnlocked,   ///< The program's memory may be swapped out.
  kNoPriority,       ///< The control thread may have to wait for the processor.
  kRecordingSaved,   ///< An interrupted scan was saved at the start.
  kRecordingLost,    ///< One could not be saved.
};
inline constexpr std::size_t kWarningCodes = static_cast<std::size_t>(WarningCode::kRecordingLost) + 1;
/// As on the wire: "ticks_late".
[[nodiscard]] const char* WarningName(WarningCode code);

/// One warning as it is shown.
struct ScanWarning {
  WarningCode code = WarningCode::kOther;
  std::string text;            ///< What was seen and what to do, in plain words.
  std::vector<double> values;  ///< The numbers of the text, where its code says so.

  bool operator==(const ScanWarning&) const = default;
};

}  // namespace annulus
