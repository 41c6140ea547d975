#include "sim/can_board_firmware.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/ensure.h"
#include "firmware_iface/ring_objects.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using ReadResult = tl::expected<std::vector<std::byte>, SdoAbort>;

constexpr std::size_t kTpdos = kCanFramesPerLevel;
constexpr std::array<std::uint16_t, kTpdos> kTpdoIds{0x180, 0x280, 0x380, 0x480, 0x200, 0x300};
constexpr std::uint8_t kEverySync = 1;  ///< Transmission type of a PDO.
constexpr const char* kDeviceName = "annulus ring board";

tl::unexpected<SdoAbort> Refuse(SdoAbort reason) { return tl::unexpected<SdoAbort>(reason); }

ReadResult Text(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

/// Sub-index 0 of an object with parts says how many.
ReadResult Count(std::uint8_t parts) { return ObjectBytes(parts); }

bool IsRequest(const CanFrame& frame, CobId function, NodeId node) {
  return IsCanopenFrame(frame) && frame.id == CobIdOf(function, node);
}

}  // namespace

CanBoardModel::CanBoardModel(CanBoardOptions options, World& world, SyncLine& sync, nanoseconds power_up)
    : options_(options),
      core_(options.board, world),
      sync_(sync),
      server_(options.node,
              {[this](SdoAddress address) { return ReadObject(address); },
               [this](SdoAddress address, const std::vector<std::byte>& data) { return WriteObject(address, data); }}) {
  ENSURE(options.node >= 1 && options.node <= kLastNodeId, "a node id is 1 to 127");
  first_sensor_ = options.board.first_sensor;
  control_engine_.seed(core_.BoardBits(BoardDraw::kControl));
  const double share = 0.2 + 0.8 * UnitFromBits(core_.BoardBits(BoardDraw::kBoot));
  Boot(ShareOf(options_.power_up_time, share), power_up);
}

void CanBoardModel::Boot(nanoseconds delay, nanoseconds time) {
  SetProducer(false, time);
  state_ = NmtState::kBootUp;
  heartbeat_ms_ = 0;
  ++beat_series_;
  ++run_;
  drives_wire_ = false;
  counter_overflow_ = 0;
  sync_period_us_ = 0;
  told_same_id_ = false;
  told_sync_length_ = false;
  outgoing_.clear();
  Event boot;
  boot.run = run_;
  events_.emplace(time + delay, boot);
}

void CanBoardModel::PowerOffAt(nanoseconds time) {
  Event off;
  off.what = What::kOff;
  events_.emplace(time, off);
}

void CanBoardModel::PowerOnAt(nanoseconds time) {
  Event on;
  on.what = What::kOn;
  events_.emplace(time, on);
}

void CanBoardModel::ExchangeFor(std::uint32_t serial) {
  ENSURE(!powered_, "a board is exchanged without power");
  options_.board.serial = serial;
}

void CanBoardModel::EmergencyAt(nanoseconds time, std::uint16_t code) {
  Event emergency;
  emergency.what = What::kEmergency;
  emergency.code = code;
  events_.emplace(time, emergency);
}

std::vector<CanFrame> CanBoardModel::TakeFrames() { return std::exchange(outgoing_, {}); }

std::optional<nanoseconds> CanBoardModel::NextEdge() const {
  if (!produces_sync_ || !powered_ || sync_.run != sync_run_) return std::nullopt;
  const nanoseconds edge = sync_.EdgeTime(next_edge_);
  if (edge >= sync_.stop) return std::nullopt;
  return edge;
}

std::optional<nanoseconds> CanBoardModel::NextTime() const {
  std::optional<nanoseconds> next = NextEdge();
  if (!events_.empty()) next = std::min(next.value_or(nanoseconds::max()), events_.begin()->first);
  return next;
}

void CanBoardModel::Act(nanoseconds time) {
  now_ = time;
  while (!events_.empty() && events_.begin()->first <= time) {
    const Event event = events_.begin()->second;
    events_.erase(events_.begin());
    Do(event, time);
  }
  for (auto edge = NextEdge(); edge && *edge <= time; edge = NextEdge()) {
    ++next_edge_;
    sync_counter_ = static_cast<std::uint8_t>(sync_counter_ % std::max<std::uint8_t>(counter_overflow_, 1) + 1);
    outgoing_.push_back(EncodeSync(sync_counter_));
  }
}

void CanBoardModel::Do(const Event& event, nanoseconds time) {
  if (!powered_ && event.what != What::kOn) return;
  switch (event.what) {
    case What::kBoot:
      if (event.run != run_) return;
      state_ = NmtState::kPreOperational;
      outgoing_.push_back(EncodeHeartbeat({options_.node, NmtState::kBootUp}));
      return;
    case What::kBeat: {
      if (event.run != beat_series_ || heartbeat_ms_ == 0 || time >= hung_from_) return;
      outgoing_.push_back(EncodeHeartbeat({options_.node, state_}));
      events_.emplace(time + std::chrono::milliseconds(heartbeat_ms_), event);
      return;
    }
    case What::kSend:
      if (event.run == run_) outgoing_.push_back(event.frame);
      return;
    case What::kLevel:
      if (event.run == run_ && state_ == NmtState::kOperational) SendLevel(event);
      return;
    case What::kOff:
      SetProducer(false, time);
      powered_ = false;
      ++run_;
      ++beat_series_;
      outgoing_.clear();
      return;
    case What::kOn:
      powered_ = true;
      Boot(options_.power_up_time, time);
      return;
    case What::kEmergency:
      SendEmergency(event.code);
      return;
  }
}

void CanBoardModel::OnSent(const CanFrame& frame, nanoseconds time) {
  now_ = time;
  // The board that sends SYNC fires with the others: when it is over.
  if (const auto counter = DecodeSync(frame); counter && powered_) TakeSync(*counter, time);
}

void CanBoardModel::OnState(CanState state, nanoseconds time) {
  now_ = time;
  if (state == CanState::kBusOff) was_bus_off_ = true;
  if (state == CanState::kErrorActive && std::exchange(was_bus_off_, false)) SendEmergency(kEmergencyBusOffRecovered);
}

void CanBoardModel::OnFrame(const CanFrame& frame, nanoseconds time) {
  now_ = time;
  if (!powered_) return;
  if (const auto order = DecodeNmt(frame)) {
    if (order->node == 0 || order->node == options_.node) TakeOrder(order->command, time);
    return;
  }
  if (state_ == NmtState::kBootUp) return;
  if (const auto counter = DecodeSync(frame)) return TakeSync(*counter, time);
  if (IsRequest(frame, CobId::kSync, 0) && !std::exchange(told_sync_length_, true)) {
    return SendEmergency(kEmergencySyncLength);
  }
  if (const auto beat = DecodeHeartbeat(frame); beat && beat->node == options_.node) {
    if (!std::exchange(told_same_id_, true)) SendEmergency(kEmergencySameNodeId);
    return;
  }
  if (state_ == NmtState::kStopped || time >= hung_from_) return;
  if (const auto answer = server_.Answer(frame)) {
    Event reply;
    reply.what = What::kSend;
    reply.frame = *answer;
    reply.run = run_;
    events_.emplace(time + ReplyDelay(), reply);
  }
}

nanoseconds CanBoardModel::ReplyDelay() {
  const double extra = -std::log1p(-UnitFromBits(control_engine_()));
  return options_.board.control_delay + ShareOf(options_.board.control_jitter, extra);
}

void CanBoardModel::TakeOrder(NmtCommand command, nanoseconds time) {
  switch (command) {
    case NmtCommand::kStart:
      if (state_ != NmtState::kPreOperational && state_ != NmtState::kStopped) return;
      state_ = NmtState::kOperational;
      core_.StartRun();
      ++starts_;
      last_counter_.reset();
      sequence_ = 0;
      fired_.clear();
      return;
    case NmtCommand::kStop:
      if (state_ != NmtState::kBootUp) state_ = NmtState::kStopped;
      return;
    case NmtCommand::kEnterPreOperational:
      if (state_ != NmtState::kBootUp) state_ = NmtState::kPreOperational;
      return;
    case NmtCommand::kResetNode:
      return Boot(options_.power_up_time, time);
    case NmtCommand::kResetCommunication:
      if (state_ != NmtState::kBootUp) Boot(options_.restart_time, time);
      return;
  }
}

void CanBoardModel::TakeSync(std::uint8_t counter, nanoseconds time) {
  if (state_ != NmtState::kOperational || counter_overflow_ == 0) return;
  // The counter tells SYNCs that this board has missed; before the first one stands 0.
  const std::uint32_t before = last_counter_.value_or(0);
  const std::uint32_t step = (counter + std::uint32_t{counter_overflow_} - before) % counter_overflow_;
  if (last_counter_ && step == 0) return;
  sequence_ = last_counter_ ? sequence_ + step : counter - 1U;
  last_counter_ = counter;
  const nanoseconds fire = core_.FireTime(sequence_, time);
  fired_[sequence_] = fire;
  Event level;
  level.what = What::kLevel;
  level.sequence = sequence_;
  level.edge = time;
  level.run = run_;
  events_.emplace(core_.ReadyTime(sequence_, fire, sync_.period_ns), level);
}

void CanBoardModel::SendLevel(const Event& event) {
  const nanoseconds fire = core_.FireTime(event.sequence, event.edge);
  if (core_.faults().Value(BoardFaultKind::kSilent, fire)) return;
  LevelFrame level = core_.Measure(event.sequence, fire);
  level.status |= status_;
  if (options_.fd) {
    outgoing_.push_back(EncodeCanFdLevel(options_.node, level));
    return;
  }
  for (const CanFrame& frame : EncodeCanLevel(options_.node, level)) outgoing_.push_back(frame);
}

void CanBoardModel::SendEmergency(std::uint16_t code) {
  error_register_ = code == kEmergencyNone ? 0 : 1;
  outgoing_.push_back(EncodeEmergency({options_.node, code, error_register_, options_.board.serial, 0}));
}

void CanBoardModel::SetProducer(bool produces, nanoseconds time) {
  if (produces == produces_sync_) return;
  produces_sync_ = produces;
  if (!produces) {
    if (drives_wire_ && sync_.run == sync_run_) sync_.stop = std::min(sync_.stop, time);
    return;
  }
  sync_counter_ = 0;
  next_edge_ = 0;
  if (!drives_wire_) {
    // Waits for the wire to start, or joins at its next edge.
    sync_run_ = time >= sync_.stop ? sync_.run + 1 : sync_.run;
    if (time < sync_.stop) next_edge_ = sync_.EdgeFrom(time);
    return;
  }
  // The period is counted on this board's own crystal; the first edge comes one period after the order.
  sync_.period_ns = core_.CrystalNs(1000.0 * sync_period_us_);
  sync_.start = time + nanoseconds(std::llround(sync_.period_ns));
  sync_.stop = nanoseconds::max();
  sync_run_ = ++sync_.run;
}

ReadResult CanBoardModel::ReadObject(SdoAddress address) const {
  const auto heard = [&](SdoAddress known) { return address == known; };
  if (heard(kObjectDeviceType)) return ObjectBytes(std::uint32_t{0});
  if (heard(kObjectErrorRegister)) return ObjectBytes(error_register_);
  if (heard(kObjectSyncId)) {
    return ObjectBytes(static_cast<std::uint32_t>(CobId::kSync) | (produces_sync_ ? kSyncProducerBit : 0U));
  }
  if (heard(kObjectSyncPeriod)) return ObjectBytes(sync_period_us_);
  if (heard(kObjectDeviceName)) return Text(kDeviceName);
  if (heard(kObjectFirmwareVersion)) {
    const auto& version = kBoardFirmwareVersion;
    return Text(std::to_string(Claim(BoardFaultKind::kFirmware, version[0])) + "." + std::to_string(version[1]) + "." +
                std::to_string(version[2]));
  }
  if (heard(kObjectEmergencyId)) return ObjectBytes(CobIdOf(CobId::kEmergency, options_.node));
  if (heard(kObjectHeartbeat)) return ObjectBytes(heartbeat_ms_);
  if (heard(kObjectSyncCounterOverflow)) return ObjectBytes(counter_overflow_);
  if (address.index == kObjectSerial.index) {
    const std::array<std::uint32_t, 4> identity{kRingVendor, kRingProduct, 0x00010002, options_.board.serial};
    if (address.sub_index == 0) return Count(4);
    if (address.sub_index > 4) return Refuse(SdoAbort::kNoSubIndex);
    return ObjectBytes(identity[address.sub_index - 1U]);
  }
  if (address.index >= 0x1800 && address.index < 0x1800 + kTpdos) {
    if (address.sub_index == 0) return Count(2);
    if (address.sub_index == 1) return ObjectBytes(kTpdoIds[address.index - 0x1800U] + std::uint32_t{options_.node});
    if (address.sub_index == 2) return ObjectBytes(kEverySync);
    return Refuse(SdoAbort::kNoSubIndex);
  }
  if (heard(kObjectProtocolVersion)) return ObjectBytes(Claim(BoardFaultKind::kProtocol, protocol_version_));
  if (heard(kObjectFirstSensor)) return ObjectBytes(Claim(BoardFaultKind::kPlace, first_sensor_));
  if (heard(kObjectSensorCount)) return ObjectBytes(static_cast<std::uint8_t>(kSensorsPerBoard));
  if (address.index == kObjectMinLevelRate.index && address.sub_index == 0) return Count(2);
  if (heard(kObjectMinLevelRate)) return ObjectBytes(kBoardMinLevelRateMhz);
  if (heard(kObjectMaxLevelRate)) return ObjectBytes(kBoardMaxLevelRateMhz);
  if (address.index == kClockIndex) {
    if (address.sub_index == 0) return Count(kClockSubIndices);
    if (address.sub_index > kClockSubIndices) return Refuse(SdoAbort::kNoSubIndex);
    return ObjectBytes(static_cast<std::uint32_t>(DeviceTime(now_) / std::chrono::microseconds(1)));
  }
  if (heard(kObjectNmtState)) return ObjectBytes(static_cast<std::uint8_t>(state_));
  if (heard(kObjectDrivesSyncWire)) return ObjectBytes(static_cast<std::uint8_t>(drives_wire_ ? 1 : 0));
  if (heard(kObjectFdLevels)) return ObjectBytes(static_cast<std::uint8_t>(options_.fd ? 1 : 0));
  return Refuse(SdoAbort::kNoObject);
}

tl::expected<void, SdoAbort> CanBoardModel::WriteObject(SdoAddress address, const std::vector<std::byte>& data) {
  const auto number = [&](std::size_t size) -> tl::expected<std::uint32_t, SdoAbort> {
    if (data.size() != size) return Refuse(SdoAbort::kLength);
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value |= std::to_integer<std::uint32_t>(data[i]) << (8 * i);
    return value;
  };
  if (address == kObjectSyncId) {
    const auto value = number(4);
    if (!value) return Refuse(value.error());
    if ((*value & ~kSyncProducerBit) != static_cast<std::uint32_t>(CobId::kSync)) return Refuse(SdoAbort::kValueRange);
    const bool produces = (*value & kSyncProducerBit) != 0;
    if (produces && (sync_period_us_ == 0 || counter_overflow_ == 0)) return Refuse(SdoAbort::kDeviceState);
    SetProducer(produces, now_);
    return {};
  }
  if (address == kObjectSyncPeriod) {
    const auto value = number(4);
    if (!value) return Refuse(value.error());
    const std::uint64_t rate_mhz = *value == 0 ? 0 : 1'000'000'000ULL / *value;
    if (*value != 0 && (rate_mhz < kBoardMinLevelRateMhz - 1 || rate_mhz > kBoardMaxLevelRateMhz)) {
      return Refuse(SdoAbort::kValueRange);
    }
    if (produces_sync_) return Refuse(SdoAbort::kDeviceState);
    sync_period_us_ = *value;
    return {};
  }
  if (address == kObjectHeartbeat) {
    const auto value = number(2);
    if (!value) return Refuse(value.error());
    heartbeat_ms_ = static_cast<std::uint16_t>(*value);
    Event beat;
    beat.what = What::kBeat;
    beat.run = ++beat_series_;
    if (heartbeat_ms_ > 0) events_.emplace(now_ + std::chrono::milliseconds(heartbeat_ms_), beat);
    return {};
  }
  if (address == kObjectSyncCounterOverflow) {
    const auto value = number(1);
    if (!value) return Refuse(value.error());
    if (produces_sync_) return Refuse(SdoAbort::kDeviceState);
    // CiA 301: 0, or 2 … 240.
    if (*value == 1 || *value > kSyncCounterOverflow) return Refuse(SdoAbort::kValueRange);
    counter_overflow_ = static_cast<std::uint8_t>(*value);
    return {};
  }
  if (address == kObjectDrivesSyncWire) {
    const auto value = number(1);
    if (!value) return Refuse(value.error());
    if (*value > 1) return Refuse(SdoAbort::kValueRange);
    if (produces_sync_) return Refuse(SdoAbort::kDeviceState);
    drives_wire_ = *value == 1;
    return {};
  }
  const auto known = ReadObject(address);
  return known ? Refuse(SdoAbort::kReadOnly) : Refuse(known.error());
}

}  // namespace annulus::sim
