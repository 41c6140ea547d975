#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <vector>

#include "firmware_iface/can_level_codec.h"
#include "firmware_iface/canopen.h"
#include "firmware_iface/sdo.h"
#include "sim/can_wire.h"
#include "sim/ring_board_core.h"

namespace annulus::sim {

struct CanBoardOptions {
  RingBoardOptions board;  ///< What only USB has is not used.
  NodeId node = 1;
  bool fd = false;                                                          ///< Levels in FD frames.
  std::chrono::nanoseconds power_up_time = std::chrono::milliseconds(250);  ///< Longest from power-up to boot-up.
  std::chrono::nanoseconds restart_time = std::chrono::milliseconds(5);     ///< After a reset of communication.
};

/// The firmware of one concentrator board on CAN (CiA 301; docs/wire_protocol.md §2). Frames depend on seed, serial and
/// the times at which orders and SYNC come. Thread-bound. Borrows world and SYNC line.
class CanBoardModel final : public CanStation {
 public:
  /// Powered up at `power_up`.
  CanBoardModel(CanBoardOptions options, World& world, SyncLine& sync, std::chrono::nanoseconds power_up);

  void OnFrame(const CanFrame& frame, std::chrono::nanoseconds time) override;
  void OnSent(const CanFrame& frame, std::chrono::nanoseconds time) override;
  void OnState(CanState state, std::chrono::nanoseconds time) override;
  [[nodiscard]] std::optional<std::chrono::nanoseconds> NextTime() const override;
  void Act(std::chrono::nanoseconds time) override;
  std::vector<CanFrame> TakeFrames() override;

  /// The board loses its power at a time, or gets it again.
  void PowerOffAt(std::chrono::nanoseconds time);
  void PowerOnAt(std::chrono::nanoseconds time);
  /// The firmware's main loop hangs from a time on: no heartbeat, no SDO; interrupts still serve SYNC and NMT.
  void HangAt(std::chrono::nanoseconds time) { hung_from_ = time; }
  /// Sends an emergency message at a time.
  void EmergencyAt(std::chrono::nanoseconds time, std::uint16_t code);
  /// The emitters' power is outside its limits from now on: status of each level.
  void BreakEmitter() { status_ = kFrameEmitterFault; }
  /// From now on it says that it speaks this version.
  void PretendProtocol(std::uint16_t version) { protocol_version_ = version; }
  /// From now on it says that its first sensor stands here; what it measures is as before.
  void PretendFirstSensor(std::uint16_t first_sensor) { first_sensor_ = first_sensor; }
  /// Another board, of this serial number, is in its place from now on. Requires that it is without power.
  void ExchangeFor(std::uint32_t serial);

  /// What else is wrong with the board.
  [[nodiscard]] BoardFaults& faults() { return core_.faults(); }

  /// For judging: what is really so.
  [[nodiscard]] std::chrono::nanoseconds DeviceTime(std::chrono::nanoseconds time) const {
    return core_.DeviceTime(time);
  }
  [[nodiscard]] NmtState state() const { return state_; }
  [[nodiscard]] bool powered() const { return powered_; }
  /// Levels measured, and when each fired.
  [[nodiscard]] const std::map<std::uint32_t, std::chrono::nanoseconds>& fired() const { return fired_; }
  /// NMT orders heeded since power-up that started the board.
  [[nodiscard]] std::uint32_t starts() const { return starts_; }

 private:
  enum class What { kBoot, kBeat, kSend, kLevel, kOff, kOn, kEmergency };
  struct Event {
    What what = What::kBoot;
    CanFrame frame;
    std::uint32_t sequence = 0;
    std::uint32_t run = 0;
    std::chrono::nanoseconds edge{0};
    std::uint16_t code = 0;
  };

  void Do(const Event& event, std::chrono::nanoseconds time);
  void Boot(std::chrono::nanoseconds delay, std::chrono::nanoseconds time);
  void TakeOrder(NmtCommand command, std::chrono::nanoseconds time);
  void TakeSync(std::uint8_t counter, std::chrono::nanoseconds time);
  [[nodiscard]] std::optional<std::chrono::nanoseconds> NextEdge() const;
  void SetProducer(bool produces, std::chrono::nanoseconds time);
  void SendLevel(const Event& event);
  void SendEmergency(std::uint16_t code);
  tl::expected<std::vector<std::byte>, SdoAbort> ReadObject(SdoAddress address) const;
  tl::expected<void, SdoAbort> WriteObject(SdoAddress address, const std::vector<std::byte>& data);
  [[nodiscard]] std::chrono::nanoseconds ReplyDelay();
  /// What it says of itself, in place of the truth if that is wrong.
  template <class Number>
  [[nodiscard]] Number Claim(BoardFaultKind kind, Number truth) const {
    return static_cast<Number>(core_.faults().Value(kind, now_).value_or(truth));
  }

  CanBoardOptions options_;
  RingBoardCore core_;
  SyncLine& sync_;
  SdoServer server_;
  std::mt19937_64 control_engine_;
  std::multimap<std::chrono::nanoseconds, Event> events_;
  std::vector<CanFrame> outgoing_;
  std::chrono::nanoseconds now_{0};
  NmtState state_ = NmtState::kBootUp;
  bool powered_ = true;
  std::chrono::nanoseconds hung_from_ = std::chrono::nanoseconds::max();
  std::uint8_t status_ = 0;
  std::uint16_t protocol_version_ = 1;
  std::uint16_t first_sensor_ = 0;
  std::uint8_t error_register_ = 0;
  std::uint16_t heartbeat_ms_ = 0;
  std::uint32_t beat_series_ = 0;  ///< Only the newest series of beats goes on.
  std::uint32_t sync_period_us_ = 0;
  std::uint8_t counter_overflow_ = 0;
  bool drives_wire_ = false;
  bool produces_sync_ = false;
  std::uint32_t sync_run_ = 0;  ///< Run of the SYNC wire whose edges it passes on.
  std::uint64_t next_edge_ = 0;
  std::uint8_t sync_counter_ = 0;             ///< Of the SYNC sent last; 0: none.
  std::optional<std::uint8_t> last_counter_;  ///< Seen since the start.
  std::uint32_t sequence_ = 0;                ///< Of the level of last_counter_.
  std::uint32_t run_ = 0;
  std::uint32_t starts_ = 0;
  bool told_same_id_ = false;
  bool told_sync_length_ = false;
  bool was_bus_off_ = false;
  std::map<std::uint32_t, std::chrono::nanoseconds> fired_;
};

}  // namespace annulus::sim
