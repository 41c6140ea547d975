#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "firmware_iface/canopen.h"
#include "firmware_iface/usb_frame_codec.h"

namespace annulus {

/// One level of one board on CAN (docs/wire_protocol.md §2.4): six classic frames, each with the low bits of the
/// sequence, or one FD frame.

/// Step of a range in classic frames and in FD frames, um.
inline constexpr std::uint32_t kCanRangeStepUm = 40;
inline constexpr std::uint32_t kCanFdRangeStepUm = 20;
/// Longest range that fits, um; longer ones are sent as no return.
inline constexpr std::uint32_t kMostCanRangeUm = 0x7FFE * kCanRangeStepUm;
inline constexpr std::uint32_t kMostCanFdRangeUm = 0xFFFE * kCanFdRangeStepUm;
inline constexpr std::size_t kCanFramesPerLevel = 6;
/// Of the PDOs that carry a level.
inline constexpr std::uint16_t kCanLevelVersion = 1;

/// The level in classic frames, in the order of their identifiers. Ranges are rounded to 0.04 mm, qualities to 17 (only
/// 0 becomes 0), the time to 1 us of which the low 32 bits are sent.
[[nodiscard]] std::array<CanFrame, kCanFramesPerLevel> EncodeCanLevel(NodeId node, const LevelFrame& level);
/// The level in one FD frame. Ranges are rounded to 0.02 mm.
[[nodiscard]] CanFrame EncodeCanFdLevel(NodeId node, const LevelFrame& level);
/// Whether an identifier is one of those that carry levels, and of which node.
[[nodiscard]] std::optional<NodeId> LevelNodeOf(const CanFrame& frame);

/// A level that came whole. Its device_time holds only the 32 bits of us that the wire carries.
struct CanLevel {
  LevelFrame level;
  std::chrono::nanoseconds host_arrival{0};  ///< Of its last frame.
};

/// Puts the levels of one board together. Frames may be lost, repeated, and displaced by up to kCanReorderFrames frames
/// of the same board; a level counts whole or not at all. Levels come out with rising sequence. Holds at most 8 levels
/// under way and 128 whole ones.
class CanLevelAssembler {
 public:
  CanLevelAssembler() = default;
  /// `serial`: of the board; frames of another are not used.
  CanLevelAssembler(NodeId node, std::uint32_t serial) : node_(node), serial_(serial) {}

  /// A new run: sequence 0 is the first. Before, frames are ignored.
  void Begin(std::chrono::nanoseconds level_period);
  void End() { running_ = false; }

  /// Takes a frame for which LevelNodeOf gives this node.
  void Push(const CanFrame& frame, std::chrono::nanoseconds host_time);
  /// The next whole level.
  [[nodiscard]] bool has_level() const { return !whole_.empty(); }
  [[nodiscard]] const CanLevel& front() const { return whole_.front(); }
  void Pop() { whole_.pop_front(); }
  /// Sequence of the next level that can still become whole: all below are whole or lost for good.
  [[nodiscard]] std::uint32_t next() const { return next_; }
  /// Gives up the oldest level under way if some frame of it or of a later one has come. Says whether it did.
  bool GiveUpOldest();

  /// Frames that came twice or too late.
  [[nodiscard]] std::uint64_t duplicates() const { return duplicates_; }
  /// Frames with a shape or content that no board sends.
  [[nodiscard]] std::uint64_t rejected() const { return rejected_; }
  /// Whether another board sends under this node id.
  [[nodiscard]] bool foreign_serial() const { return foreign_serial_; }

 private:
  static constexpr std::size_t kWindow = 8;
  struct Slot {
    std::uint8_t have = 0;   ///< One bit per part of the level.
    std::size_t frames = 0;  ///< That brought them: an FD frame brings all parts.
    std::chrono::nanoseconds first{0};
    std::chrono::nanoseconds last{0};
    LevelFrame level;
  };

  void PushClassic(const CanFrame& frame, std::size_t part, std::chrono::nanoseconds host_time);
  void PushFd(const CanFrame& frame, std::chrono::nanoseconds host_time);
  /// The level's place, by the four or the sixteen low bits of its sequence; nothing if it is past.
  std::optional<std::uint32_t> SequenceOfLowBits(std::uint8_t low_bits) const;
  std::optional<std::uint32_t> SequenceOfWord(std::uint16_t word);
  Slot* SlotFor(std::uint32_t sequence, std::uint8_t part_bit, std::chrono::nanoseconds host_time);
  void Release();
  [[nodiscard]] std::size_t LaterFrames() const;
  void Advance();

  NodeId node_ = 1;
  std::uint32_t serial_ = 0;
  bool running_ = false;
  std::chrono::nanoseconds level_period_{0};
  std::uint32_t next_ = 0;
  std::array<Slot, kWindow> slots_;  ///< Sequence s stands at s mod 8; all are of [next_, next_ + 8).
  std::deque<CanLevel> whole_;
  std::uint64_t duplicates_ = 0;
  std::uint64_t rejected_ = 0;
  bool foreign_serial_ = false;
};

/// Frames of later levels that a frame may come after. With one more, its level is no longer waited for.
inline constexpr std::size_t kCanReorderFrames = 4;

/// Makes 64 bits of a counter of microseconds that wraps after 71.6 minutes, by the host's clock: the values given must
/// not be more than half an hour off from where the host's clock expects them.
class WrappedClock {
 public:
  [[nodiscard]] std::chrono::nanoseconds Unwrap(std::uint32_t device_us, std::chrono::nanoseconds host_time);

 private:
  bool known_ = false;
  std::int64_t last_us_ = 0;
  std::chrono::nanoseconds last_host_{0};
};

}  // namespace annulus
