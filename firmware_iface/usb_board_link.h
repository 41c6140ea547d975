#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/ring_rules.h"
#include "firmware_iface/usb_frame_codec.h"
#include "firmware_iface/usb_port.h"

namespace annulus {

/// A whole frame, and when the transfer that completed it ended.
struct ArrivedFrame {
  LevelFrame frame;
  std::chrono::nanoseconds host_arrival{0};
};

/// Bytes asked for by one transfer: several frames that piled up in a board, and a multiple of the 512-byte packets of
/// high speed.
inline constexpr std::size_t kTransferBytes = 2048;

/// One board's stream of level frames: keeps transfers in flight, puts frames together, and judges what the board's
/// transfers and frames say about its health. The port is borrowed or owned. Thread-bound.
class UsbBoardLink {
 public:
  UsbBoardLink(const RingBoard& board, UsbPort& port);
  UsbBoardLink(const RingBoard& board, std::unique_ptr<UsbPort> port);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const UsbIdentity& identity() const { return identity_; }
  /// Null while the board is lost.
  [[nodiscard]] UsbPort* port() const { return port_; }
  /// Puts the board on another port, or (null) on none; it counts as healthy again. Nothing may be in flight.
  void Attach(const RingBoard& board, std::unique_ptr<UsbPort> port);

  /// Its last transfers say that the board is unplugged.
  [[nodiscard]] bool gone() const { return gone_; }
  /// It failed in a way that only opening it again may cure.
  [[nodiscard]] bool broken() const { return broken_; }

  /// Of the last call that failed while the board was not gone.
  [[nodiscard]] RingTrouble trouble() const { return trouble_; }

  /// A request without an answer; `what` is the start of the message.
  Status Order(BoardRequest request, std::span<const std::byte> data, std::chrono::nanoseconds timeout,
               const char* what);
  /// Forgets the last run.
  void Reset();
  /// Frames stamped earlier on the board's clock belong to an earlier run, and are dropped as repeated.
  void IgnoreBefore(std::chrono::nanoseconds device_time) { run_begin_ = device_time; }
  /// Puts one more transfer in flight.
  Status Submit();
  /// Collects until a frame is there, or the deadline is over.
  Status Await(std::chrono::nanoseconds deadline);
  /// Collects what has ended, without waiting.
  Status Collect();
  [[nodiscard]] bool has_frame() const { return !frames_.empty(); }
  /// The frame of this level; nothing if it is lost: a later one is there. Requires has_frame().
  std::optional<ArrivedFrame> TakeFrame(std::uint32_t sequence);
  /// More frames were lost lately than a healthy board loses.
  [[nodiscard]] bool loses_frames() const;
  /// Looks, without waiting, whether transfers have ended as those of an unplugged board do. Data are dropped.
  void LookWhetherGone();
  void CancelAll();
  /// Collects every transfer's end.
  Status EndTransfers(std::chrono::nanoseconds deadline);

  [[nodiscard]] std::uint64_t duplicate_frames() const { return duplicate_frames_; }
  [[nodiscard]] std::uint64_t rejected_frames() const { return assembler_.rejected_frames(); }
  [[nodiscard]] std::uint64_t rejected_bytes() const { return assembler_.rejected_bytes(); }

 private:
  Status Take(const UsbCompletion& completion);
  /// What the end of a transfer says, beside its data.
  Status Judge(UsbStatus status);
  Status Recover();
  Status Sort(const LevelFrame& frame, std::chrono::nanoseconds host_arrival);
  tl::unexpected<Error> Broken(const UsbFailure& failure);

  std::uint32_t serial_ = 0;
  std::string name_;
  std::unique_ptr<UsbPort> owned_;
  UsbPort* port_ = nullptr;
  UsbIdentity identity_;
  bool gone_ = false;
  bool broken_ = false;
  RingTrouble trouble_ = RingTrouble::kBus;

  UsbFrameAssembler assembler_;
  std::deque<ArrivedFrame> frames_;        ///< Whole, not yet given out, sequence strictly rising.
  std::vector<UsbToken> tokens_;           ///< In flight.
  std::uint32_t earliest_ = 0;             ///< Frames before are repeated or too late.
  std::chrono::nanoseconds run_begin_{0};  ///< On the board's clock.
  LossBucket losses_;
  int bad_transfers_ = 0;           ///< In a row.
  std::size_t excused_stalls_ = 0;  ///< Transfers that were in flight when the endpoint halted.
  int good_since_stall_ = 0;
  std::uint64_t duplicate_frames_ = 0;
};

}  // namespace annulus
