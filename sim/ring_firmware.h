#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/usb_frame_codec.h"
#include "firmware_iface/usb_port.h"
#include "sim/world.h"

namespace annulus::sim {

/// The wire that makes all boards fire together. One board drives it. SYNC edge k is at start + k · period.
struct SyncLine {
  std::uint32_t run = 0;  ///< Times started; edge 0 is that of the present run.
  std::chrono::nanoseconds start{0};
  std::chrono::nanoseconds stop{0};  ///< No edge from here on; start >= stop: the line is quiet.
  double period_ns = 0.0;
};

struct RingBoardOptions {
  std::uint32_t serial = 1;
  std::uint16_t first_sensor = 0;
  std::uint64_t seed = 1;
  double clock_drift_ppm = 20.0;  ///< Largest; each board draws its own, either sign.
  std::chrono::nanoseconds fire_delay = std::chrono::microseconds(300);     ///< Largest constant SYNC-to-fire delay.
  std::chrono::nanoseconds fire_jitter = std::chrono::microseconds(20);     ///< Largest, per level, on top.
  std::chrono::nanoseconds frame_delay = std::chrono::microseconds(900);    ///< From firing to the frame's arrival.
  std::chrono::nanoseconds frame_jitter = std::chrono::microseconds(300);   ///< Largest, on top.
  std::chrono::nanoseconds control_delay = std::chrono::microseconds(60);   ///< One way, at least.
  std::chrono::nanoseconds control_jitter = std::chrono::microseconds(40);  ///< Mean of what comes on top, one way.
  double split_share = 0.2;                                                 ///< Frames that arrive in two transfers.
  std::uint32_t max_level_rate_mhz = 100'000;  ///< Highest level rate that the board takes, mHz.
  std::size_t fifo_frames = 64;                ///< Frames kept while nobody asks; then the newest is lost.
};

/// The firmware of one concentrator board with its 15 sensors, behind the USB seam. Frames depend on seed, serial, run
/// and SYNC only, not on when or in which order boards are asked. Thread-bound. Borrows world, SYNC line and clock.
class RingBoardModel final : public UsbPort {
 public:
  RingBoardModel(RingBoardOptions options, World& world, SyncLine& sync, Clock& clock);

  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }
  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length,
                                              std::chrono::nanoseconds timeout) override;
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data,
                             std::chrono::nanoseconds timeout) override;
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) override;
  void Cancel(UsbToken token) override;
  UsbResult<void> ClearHalt(std::uint8_t endpoint) override;
  std::optional<UsbCompletion> WaitCompletion(std::chrono::nanoseconds deadline) override;
  [[nodiscard]] std::size_t in_flight() const override { return pending_.size() + completed_.size(); }

  /// When the sensors really fire for a SYNC edge of the present run.
  [[nodiscard]] std::chrono::nanoseconds FireTime(std::uint32_t sequence) const;
  /// The board's clock at a time.
  [[nodiscard]] std::chrono::nanoseconds DeviceTime(std::chrono::nanoseconds time) const;
  /// Frames lost in the board because the host did not fetch them.
  [[nodiscard]] std::uint64_t dropped_frames() const { return dropped_frames_; }
  /// Pulls the plug at a time: transfers in flight end with kNoDevice, and nothing answers after.
  void UnplugAt(std::chrono::nanoseconds time);
  /// Plugs it in again, as a board that has just started. What was in flight must have been collected.
  void PlugIn();

 private:
  struct Transfer {
    UsbToken token;
    std::size_t length = 0;
    std::chrono::nanoseconds submitted{0};
  };
  /// Bytes of one USB packet and when they are there.
  struct Packet {
    std::chrono::nanoseconds time{0};
    std::vector<std::byte> bytes;
  };

  [[nodiscard]] bool Unplugged() const { return unplug_time_ && clock_.Now() >= *unplug_time_; }
  /// Lets a control request pass: its time on the wire, and when it took effect.
  UsbResult<std::chrono::nanoseconds> Exchange(std::chrono::nanoseconds timeout);
  [[nodiscard]] std::chrono::nanoseconds ControlTime();
  [[nodiscard]] std::uint64_t FrameBits(std::uint32_t sequence, std::uint64_t purpose) const;
  [[nodiscard]] std::chrono::nanoseconds ArrivalTime(std::uint32_t sequence) const;
  /// Everything that happens in the board up to now.
  void Advance();
  /// When something happens next without the host's doing.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> NextEvent() const;
  [[nodiscard]] bool WillFire(std::uint32_t sequence) const;
  [[nodiscard]] std::chrono::nanoseconds EdgeTime(std::uint32_t sequence) const;
  void SendFrame(std::uint32_t sequence);
  [[nodiscard]] LevelFrame MeasureLevel(std::uint32_t sequence) const;
  void MatchTransfers();

  RingBoardOptions options_;
  World& world_;
  SyncLine& sync_;
  Clock& clock_;
  UsbIdentity identity_;
  std::mt19937_64 control_engine_;
  std::chrono::nanoseconds clock_offset_{0};
  double clock_drift_ = 0.0;
  std::chrono::nanoseconds fire_delay_{0};
  std::uint32_t level_rate_mhz_ = 0;
  bool armed_ = false;
  bool drives_sync_ = false;
  std::uint32_t runs_ = 0;        ///< Times armed; each run has its own noise.
  std::uint32_t sync_run_ = 0;    ///< Run of the SYNC line that the board was armed for.
  std::uint64_t first_edge_ = 0;  ///< SYNC edge of sequence 0.
  std::uint32_t next_sequence_ = 0;
  std::optional<std::chrono::nanoseconds> unplug_time_;
  std::uint64_t next_token_ = 1;
  std::uint64_t dropped_frames_ = 0;
  std::deque<Transfer> pending_;
  std::deque<Packet> fifo_;
  std::deque<UsbCompletion> completed_;
};

}  // namespace annulus::sim
