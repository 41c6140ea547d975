#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "acquisition/scan.h"
#include "base/result.h"
#include "firmware_iface/interlock.h"

namespace annulus {

/// The seams whose traffic is recorded as it was, and the calls by which the ring's driver was used.
enum class RawChannel : std::uint8_t {
  kUsb,     ///< Transfers and control requests of the ring's boards.
  kCan,     ///< Frames and reports of the ring's buses.
  kModbus,  ///< Register transactions with the axis drive.
  kCall,    ///< Start, NextLevel, ReadClock, Stop of the ring, Position of the axis: what was asked of the drivers, and
            ///< when.
};
inline constexpr std::size_t kRawChannels = 4;

/// One thing that passed a bus seam, in the encoding of acquisition/bus_record.h.
struct RawRecord {
  RawChannel channel = RawChannel::kUsb;
  std::chrono::nanoseconds time{0};  ///< Host clock when it was seen.
  std::vector<std::byte> bytes;
};

/// The lines of the safety chain at one time, kept when any of them changed.
struct SafetyLines {
  std::chrono::nanoseconds time{0};            ///< Host clock.
  std::array<bool, kInterlockInputs> input{};  ///< As InterlockInput.
  std::array<bool, kInterlockOutputs>
      output{};  ///< As InterlockOutput, as ordered; the watchdog's pulses are left out.

  bool operator==(const SafetyLines&) const = default;
};

/// Whose time stamps.
enum class StampSource { kBoard, kDrive };

/// Where a running scan puts what it takes. A failure stops the scan. Thread-bound.
class ScanSink {
 public:
  virtual ~ScanSink() = default;
  /// Levels in the order they were taken; called once per level.
  virtual Status AppendLevel(const ScanLevel& level) = 0;
  /// The carriage's track, in time order: host clock, and height in mm.
  virtual Status AppendAxis(std::chrono::nanoseconds time, double z_mm) = 0;
  /// What happened, in plain words, on the host's clock.
  virtual Status AppendEvent(std::chrono::nanoseconds time, const std::string& text) = 0;
  /// What passed a bus; in the order in which it passed. Sinks that keep no raw bytes drop it.
  virtual Status AppendRaw(RawRecord record) {  // NOLINT(performance-unnecessary-value-param): sinks keep it
    static_cast<void>(record);
    return {};
  }
  /// The safety chain's lines; sinks that do not keep them drop them.
  virtual Status AppendSafety(const SafetyLines& lines) {
    static_cast<void>(lines);
    return {};
  }
  /// A clock of the machine says what cannot be; the scan ends with this error.
  virtual void OnBadStamps(StampSource source, const Error& error) {
    static_cast<void>(source);
    static_cast<void>(error);
  }
  /// Nothing more comes of the plan: brings all of it to the disk. False: not there yet, call again. Never waits.
  /// Raw bytes and positions that come between the calls do not count.
  virtual Result<bool> Settle() { return true; }
};

}  // namespace annulus
