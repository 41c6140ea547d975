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
#include "sim/ring_board_core.h"
#include "sim/world.h"

namespace annulus::sim {

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
  [[nodiscard]] std::chrono::nanoseconds DeviceTime(std::chrono::nanoseconds time) const {
    return core_.DeviceTime(time);
  }
  /// Frames lost in the board because the host did not fetch them.
  [[nodiscard]] std::uint64_t dropped_frames() const { return dropped_frames_; }
  /// What is wrong with the board.
  [[nodiscard]] BoardFaults& faults() { return core_.faults(); }
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
  [[nodiscard]] std::chrono::nanoseconds ArrivalTime(std::uint32_t sequence) const;
  /// Everything that happens in the board up to now.
  void Advance();
  /// When something happens next without the host's doing.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> NextEvent() const;
  [[nodiscard]] bool WillFire(std::uint32_t sequence) const;
  [[nodiscard]] std::chrono::nanoseconds EdgeTime(std::uint32_t sequence) const;
  void SendFrame(std::uint32_t sequence);
  void MatchTransfers();

  RingBoardOptions options_;
  RingBoardCore core_;
  SyncLine& sync_;
  Clock& clock_;
  UsbIdentity identity_;
  std::mt19937_64 control_engine_;
  std::uint32_t level_rate_mhz_ = 0;
  bool armed_ = false;
  bool drives_sync_ = false;
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
