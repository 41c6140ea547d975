#include "sim/fault_kinds.h"

#include <algorithm>
#include <array>

#include "base/ensure.h"
#include "firmware_iface/interlock.h"

namespace annulus::sim {
namespace {

using Arg = FaultArg;
using Kind = FaultKind;
using Need = FaultArgRule::Need;
using Span = FaultSpan;
using Target = FaultTarget;
using Rules = std::vector<FaultArgRule>;

constexpr FaultArgRule Must(Arg arg, double low, double high) { return {arg, low, high, Need::kMust, std::nullopt}; }
constexpr FaultArgRule May(Arg arg, double low, double high) { return {arg, low, high, Need::kMay, std::nullopt}; }
constexpr FaultArgRule Or(Arg arg, double low, double high, double fallback) {
  return {arg, low, high, Need::kMay, fallback};
}

/// All words of an argument.
FaultArgRule Word(Arg arg) { return Must(arg, 0.0, static_cast<double>(TraitsOf(arg).words.size()) - 1.0); }
FaultArgRule WordOr(Arg arg, double fallback) {
  FaultArgRule rule = Word(arg);
  rule.need = Need::kMay;
  rule.fallback = fallback;
  return rule;
}

Rules operator+(Rules a, const Rules& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// 12 is the reference board, where there is one.
constexpr FaultArgRule kBoard = May(Arg::kBoard, 0, 12);
constexpr FaultArgRule kShare = Or(Arg::kShare, 0.0, 1.0, 1.0);
constexpr FaultArgRule kCount = May(Arg::kCount, 1, 1e9);

std::vector<FaultKindTraits> UsbKinds() {
  const Rules spoiled{kBoard, kShare};
  const Rules two{Must(Arg::kBoard, 0, 11), Must(Arg::kOther, 0, 11)};
  return {
      {Kind::kUsbUnplug,
       Target::kUsb,
       "unplug",
       Span::kAny,
       {kBoard, Or(Arg::kSpreadMs, 0, 1000, 0), Or(Arg::kNotReadyS, 0, 60, 0), WordOr(Arg::kEnding, 0)}},
      {Kind::kUsbShort, Target::kUsb, "short", Span::kAny, spoiled},
      {Kind::kUsbZero, Target::kUsb, "zero", Span::kAny, spoiled},
      {Kind::kUsbLong, Target::kUsb, "long", Span::kAny, spoiled},
      {Kind::kUsbDamage, Target::kUsb, "damage", Span::kAny, spoiled},
      {Kind::kUsbTimeout, Target::kUsb, "timeout", Span::kAny, spoiled},
      {Kind::kUsbStall, Target::kUsb, "stall", Span::kAny, spoiled + Rules{WordOr(Arg::kStays, 0)}},
      {Kind::kUsbNoMemory, Target::kUsb, "no_memory", Span::kAny, {kBoard, kCount}},
      {Kind::kUsbCancelCompletes, Target::kUsb, "cancel_completes", Span::kAny, spoiled},
      {Kind::kUsbSameSerial, Target::kUsb, "same_serial", Span::kMoment, two},
      {Kind::kUsbSwapped, Target::kUsb, "swapped", Span::kMoment, two},
  };
}

std::vector<FaultKindTraits> CanKinds() {
  const FaultArgRule bus = May(Arg::kBus, 0, 11);
  const Rules spoiled{bus, kShare};
  const Rules one_board{Must(Arg::kBoard, 0, 12)};
  return {
      {Kind::kCanLose, Target::kCan, "lose", Span::kAny, spoiled},
      {Kind::kCanRepeat, Target::kCan, "repeat", Span::kAny, spoiled},
      {Kind::kCanDisplace, Target::kCan, "displace", Span::kAny, spoiled + Rules{Or(Arg::kFrames, 1, 64, 4)}},
      {Kind::kCanOverflow, Target::kCan, "overflow", Span::kMoment, {bus, Must(Arg::kFrames, 1, 1e6)}},
      {Kind::kCanQueueFull, Target::kCan, "queue_full", Span::kAny, {bus}},
      {Kind::kCanDown, Target::kCan, "down", Span::kAny, {bus}},
      {Kind::kCanGone, Target::kCan, "gone", Span::kAny, {bus}},
      {Kind::kCanBusOff, Target::kCan, "bus_off", Span::kAny, {bus}},
      {Kind::kCanErrorStates,
       Target::kCan,
       "error_states",
       Span::kLimited,
       {bus, Word(Arg::kErrorState), Must(Arg::kRateHz, 1, 10'000)}},
      {Kind::kCanFlood,
       Target::kCan,
       "flood",
       Span::kLimited,
       {bus, Must(Arg::kRateHz, 1, 20'000), Or(Arg::kId, 1, 0x7FF, 1)}},
      {Kind::kCanBoardOff, Target::kCan, "board_off", Span::kAny, one_board},
      {Kind::kCanBoardHangs, Target::kCan, "board_hangs", Span::kMoment, one_board},
      {Kind::kCanEmergency, Target::kCan, "emergency", Span::kMoment, one_board + Rules{Must(Arg::kCode, 0, 0xFFFF)}},
      {Kind::kCanSameNode, Target::kCan, "same_node", Span::kMoment, one_board},
  };
}

std::vector<FaultKindTraits> LinkKinds() {
  const Rules some{kShare, kCount};
  const Rules delay{Must(Arg::kDelayMs, 0.001, 10'000)};
  return {
      {Kind::kLinkLoseRequest, Target::kAxisLink, "lose_request", Span::kAny, some},
      {Kind::kLinkLoseReply, Target::kAxisLink, "lose_reply", Span::kAny, some},
      {Kind::kLinkLate, Target::kAxisLink, "late", Span::kAny, some + delay},
      {Kind::kLinkRepeat, Target::kAxisLink, "repeat", Span::kAny, some + Rules{Or(Arg::kDelayMs, 0, 10'000, 1)}},
      {Kind::kLinkTruncate, Target::kAxisLink, "truncate", Span::kAny, some + Rules{Or(Arg::kRegisters, 1, 125, 1)}},
      {Kind::kLinkDamage, Target::kAxisLink, "damage", Span::kAny, some},
      {Kind::kLinkMerge, Target::kAxisLink, "merge", Span::kAny, some},
      {Kind::kLinkException, Target::kAxisLink, "exception", Span::kAny, some + Rules{Must(Arg::kCode, 1, 11)}},
      {Kind::kLinkFreeze, Target::kAxisLink, "freeze", Span::kAny, {}},
      {Kind::kLinkUnplug, Target::kAxisLink, "unplug", Span::kAny, {}},
  };
}

std::vector<FaultKindTraits> AxisKinds() {
  const FaultArgRule height = Must(Arg::kHeightMm, -500, 5000);
  return {
      {Kind::kAxisLag, Target::kAxis, "lag", Span::kAny, {Must(Arg::kTimeConstantMs, 0, 10'000)}},
      {Kind::kAxisContact, Target::kAxis, "contact", Span::kAny, {height}},
      {Kind::kAxisOverload, Target::kAxis, "overload", Span::kAny, {height, Or(Arg::kCode, 1, 0xFFFF, 0x7121)}},
      {Kind::kAxisSlip, Target::kAxis, "slip", Span::kAny, {Must(Arg::kSpeedMmS, 0.001, 1000)}},
      {Kind::kAxisEncoderJump, Target::kAxis, "encoder_jump", Span::kMoment, {Must(Arg::kJumpMm, -5000, 5000)}},
      {Kind::kAxisHomeNever, Target::kAxis, "home_never", Span::kAny, {}},
      {Kind::kAxisHomeStuck, Target::kAxis, "home_stuck", Span::kAny, {}},
      {Kind::kAxisLimit, Target::kAxis, "limit", Span::kAny, {Word(Arg::kEnd)}},
      {Kind::kAxisDriveFault, Target::kAxis, "drive_fault", Span::kMoment, {Must(Arg::kCode, 1, 0xFFFF)}},
      {Kind::kAxisUnorderedMove, Target::kAxis, "unordered_move", Span::kAny, {Must(Arg::kSpeedMmS, -1000, 1000)}},
      {Kind::kAxisScale, Target::kAxis, "scale", Span::kAny, {Must(Arg::kScale, -10, 10)}},
      {Kind::kAxisOverspeed, Target::kAxis, "overspeed", Span::kAny, {Must(Arg::kScale, 0.01, 10)}},
      {Kind::kAxisIgnoreStops, Target::kAxis, "ignore_stops", Span::kAny, {}},
      {Kind::kAxisIgnoreQuickStop, Target::kAxis, "ignore_quick_stop", Span::kAny, {}},
      {Kind::kAxisPowerOff, Target::kAxis, "power_off", Span::kAny, {}},
      {Kind::kAxisParameter,
       Target::kAxis,
       "parameter",
       Span::kMoment,
       {Word(Arg::kParameter), Must(Arg::kValue, -2e6, 2e6)}},
  };
}

std::vector<FaultKindTraits> SensorsKinds() {
  const Rules where{kBoard, May(Arg::kSensor, 0, 179), Or(Arg::kSensors, 1, 180, 1)};
  const Rules board{kBoard};
  const Rules version{Must(Arg::kVersion, 0, 255)};
  return {
      {Kind::kSensorsStuck, Target::kSensors, "stuck", Span::kAny, where},
      {Kind::kSensorsNoReturn, Target::kSensors, "no_return", Span::kAny, where + Rules{kShare}},
      {Kind::kSensorsSpikes, Target::kSensors, "spikes", Span::kAny,
       where + Rules{Must(Arg::kShare, 0, 1), Must(Arg::kSizeMm, 0, 1000)}},
      {Kind::kSensorsDrift, Target::kSensors, "drift", Span::kAny, where + Rules{Must(Arg::kSpeedMmS, -100, 100)}},
      {Kind::kSensorsDead, Target::kSensors, "dead", Span::kAny, where},
      {Kind::kSensorsSilent, Target::kSensors, "silent", Span::kAny, board},
      {Kind::kSensorsLate, Target::kSensors, "late", Span::kAny, board + Rules{Must(Arg::kLevels, 1, 16)}},
      {Kind::kSensorsClockStuck, Target::kSensors, "clock_stuck", Span::kAny, board},
      {Kind::kSensorsClockJump, Target::kSensors, "clock_jump", Span::kMoment,
       board + Rules{Must(Arg::kJumpMs, -1e6, 1e6)}},
      {Kind::kSensorsClockWrap, Target::kSensors, "clock_wrap", Span::kMoment, board + Rules{Must(Arg::kInS, 0, 4000)}},
      {Kind::kSensorsProtocol, Target::kSensors, "protocol", Span::kAny, board + version},
      {Kind::kSensorsFirmware, Target::kSensors, "firmware", Span::kAny, board + version},
      {Kind::kSensorsPlace,
       Target::kSensors,
       "place",
       Span::kAny,
       {Must(Arg::kBoard, 0, 11), Must(Arg::kSensor, 0, 65'535)}},
      {Kind::kSensorsEmitterFault, Target::kSensors, "emitter_fault", Span::kAny, board},
      {Kind::kSensorsSwapped,
       Target::kSensors,
       "swapped",
       Span::kAny,
       {Must(Arg::kSensor, 0, 179), Must(Arg::kOther, 0, 179), Or(Arg::kSensors, 1, 90, 1)}},
  };
}

std::vector<FaultKindTraits> ChainKinds() {
  return {
      {Kind::kChainEstop, Target::kChain, "estop", Span::kAny, {WordOr(Arg::kChannel, 2)}},
      {Kind::kChainOpen, Target::kChain, "open", Span::kAny, {Must(Arg::kInput, 0, 4)}},
      {Kind::kChainWireBreak, Target::kChain, "wire_break", Span::kAny, {Word(Arg::kInput)}},
      {Kind::kChainPress, Target::kChain, "press", Span::kAny, {Must(Arg::kInput, 5, 7)}},
      {Kind::kChainJamBrake, Target::kChain, "jam_brake", Span::kMoment, {}},
      {Kind::kChainWeldStoA, Target::kChain, "weld_sto_a", Span::kMoment, {}},
      {Kind::kChainWeldWatchdog, Target::kChain, "weld_watchdog", Span::kMoment, {}},
      {Kind::kChainCutWatchdog, Target::kChain, "cut_watchdog", Span::kMoment, {}},
      {Kind::kChainBurnOut, Target::kChain, "burn_out", Span::kMoment, {Word(Arg::kOutput)}},
      {Kind::kChainShort, Target::kChain, "short", Span::kAny, {Word(Arg::kOutput), Must(Arg::kLevel, 0, 1)}},
      {Kind::kChainRemoveChip, Target::kChain, "remove_chip", Span::kMoment, {}},
      {Kind::kChainOccupied, Target::kChain, "occupied", Span::kMoment, {Word(Arg::kInput)}},
      {Kind::kChainRenamed, Target::kChain, "renamed", Span::kMoment, {Word(Arg::kInput)}},
  };
}

std::vector<FaultKindTraits> GpioKinds() {
  return {
      {Kind::kGpioStuck, Target::kGpio, "stuck", Span::kAny, {Word(Arg::kInput), Must(Arg::kLevel, 0, 1)}},
      {Kind::kGpioLoseEdges, Target::kGpio, "lose_edges", Span::kAny, {kShare}},
      {Kind::kGpioChatter, Target::kGpio, "chatter", Span::kAny, {kShare, Or(Arg::kPairs, 1, 100, 10)}},
      {Kind::kGpioLateEdges, Target::kGpio, "late_edges", Span::kAny, {Must(Arg::kDelayMs, 0, 10'000)}},
      {Kind::kGpioFail, Target::kGpio, "fail", Span::kAny, {}},
      {Kind::kGpioFailWrites, Target::kGpio, "fail_writes", Span::kAny, {}},
      {Kind::kGpioGone, Target::kGpio, "gone", Span::kAny, {}},
  };
}

std::vector<FaultKindTraits> StorageKinds() {
  return {
      {Kind::kStorageNoSpace, Target::kStorage, "no_space", Span::kAny, {kCount}},
      {Kind::kStorageIoError, Target::kStorage, "io_error", Span::kAny, {kCount}},
      {Kind::kStorageShortWrite, Target::kStorage, "short_write", Span::kAny, {kCount}},
      {Kind::kStorageSyncError, Target::kStorage, "sync_error", Span::kAny, {Or(Arg::kCount, 1, 1e9, 1)}},
      {Kind::kStorageSlowSync, Target::kStorage, "slow_sync", Span::kAny, {kCount, Must(Arg::kDelayMs, 1, 60'000)}},
      {Kind::kStorageReadOnly, Target::kStorage, "read_only", Span::kAny, {}},
      {Kind::kStorageLowSpace, Target::kStorage, "low_space", Span::kAny, {Must(Arg::kBytes, 0, 1e15)}},
  };
}

std::vector<FaultKindTraits> HostKinds() {
  return {
      {Kind::kHostKill, Target::kHost, "kill", Span::kMoment, {}},
      {Kind::kHostHang, Target::kHost, "hang", Span::kLimited, {}},
      {Kind::kHostLateTicks, Target::kHost, "late_ticks", Span::kAny, {kCount, Must(Arg::kDelayMs, 1, 10'000)}},
      {Kind::kHostThreadDead, Target::kHost, "thread_dead", Span::kAny, {Word(Arg::kThread)}},
      {Kind::kHostWallJump, Target::kHost, "wall_jump", Span::kMoment, {Must(Arg::kJumpS, -1e6, 1e6)}},
      {Kind::kHostHot, Target::kHost, "hot", Span::kAny, {}},
  };
}

std::vector<FaultKindTraits> MakeKinds() {
  std::vector<FaultKindTraits> all;
  for (auto& kinds : {UsbKinds(), CanKinds(), LinkKinds(), AxisKinds(), SensorsKinds(), ChainKinds(), GpioKinds(),
                      StorageKinds(), HostKinds()}) {
    all.insert(all.end(), kinds.begin(), kinds.end());
  }
  ENSURE(all.size() == kFaultKinds, "every kind of fault is in the table");
  for (std::size_t i = 0; i < all.size(); ++i) {
    ENSURE(all[i].kind == static_cast<FaultKind>(i), "the table is in the order of the enumeration");
  }
  return all;
}

std::vector<std::string> InputWords() {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < kInterlockInputs; ++i) words.emplace_back(InterlockName(static_cast<InterlockInput>(i)));
  return words;
}

std::vector<std::string> OutputWords() {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < kInterlockOutputs; ++i) {
    words.emplace_back(InterlockName(static_cast<InterlockOutput>(i)));
  }
  return words;
}

std::vector<FaultArgTraits> MakeArgs() {
  using Type = FaultArgTraits::Type;
  return {
      {"board", Type::kWhole, {}},
      {"other", Type::kWhole, {}},
      {"bus", Type::kWhole, {}},
      {"sensor", Type::kWhole, {}},
      {"sensors", Type::kWhole, {}},
      {"share", Type::kNumber, {}},
      {"count", Type::kWhole, {}},
      {"spread_ms", Type::kNumber, {}},
      {"not_ready_s", Type::kNumber, {}},
      {"ending", Type::kWord, {"no_device", "error", "completed", "any"}},
      {"stays", Type::kWord, {"no", "yes"}},
      {"frames", Type::kWhole, {}},
      {"rate_hz", Type::kNumber, {}},
      {"id", Type::kWhole, {}},
      {"state", Type::kWord, {"warning", "passive"}},
      {"code", Type::kWhole, {}},
      {"delay_ms", Type::kNumber, {}},
      {"registers", Type::kWhole, {}},
      {"time_constant_ms", Type::kNumber, {}},
      {"height_mm", Type::kNumber, {}},
      {"speed_mm_s", Type::kNumber, {}},
      {"jump_mm", Type::kNumber, {}},
      {"end", Type::kWord, {"upper", "lower", "both"}},
      {"scale", Type::kNumber, {}},
      {"parameter",
       Type::kWord,
       {"z_min_mm", "z_max_mm", "max_speed_mm_s", "max_acceleration_mm_s2", "quick_stop_mm_s2", "following_limit_mm",
        "home_fast_mm_s", "home_slow_mm_s", "heartbeat_ms", "start_window_ms"}},
      {"value", Type::kNumber, {}},
      {"size_mm", Type::kNumber, {}},
      {"levels", Type::kWhole, {}},
      {"jump_ms", Type::kNumber, {}},
      {"in_s", Type::kNumber, {}},
      {"version", Type::kWhole, {}},
      {"channel", Type::kWord, {"a", "b", "both"}},
      {"input", Type::kWord, InputWords()},
      {"output", Type::kWord, OutputWords()},
      {"level", Type::kWhole, {}},
      {"pairs", Type::kWhole, {}},
      {"bytes", Type::kWhole, {}},
      {"thread", Type::kWord, {"control", "worker", "writer"}},
      {"jump_s", Type::kNumber, {}},
  };
}

}  // namespace

const FaultArgTraits& TraitsOf(FaultArg arg) {
  static const std::vector<FaultArgTraits> args = MakeArgs();
  static_assert(kFaultArgs == 39);
  return args.at(static_cast<std::size_t>(arg));
}

std::span<const FaultKindTraits> AllFaultKinds() {
  static const std::vector<FaultKindTraits> kinds = MakeKinds();
  return kinds;
}

const FaultKindTraits& TraitsOf(FaultKind kind) { return AllFaultKinds()[static_cast<std::size_t>(kind)]; }

const char* FaultTargetName(FaultTarget target) {
  constexpr std::array<const char*, kFaultTargets> kNames{"usb",   "can",  "axis_link", "axis", "sensors",
                                                          "chain", "gpio", "storage",   "host"};
  return kNames.at(static_cast<std::size_t>(target));
}

bool HasCalls(FaultTarget target) {
  switch (target) {
    case Target::kUsb:
    case Target::kCan:
    case Target::kAxisLink:
    case Target::kGpio:
    case Target::kStorage:
    case Target::kHost:
      return true;
    case Target::kAxis:
    case Target::kSensors:
    case Target::kChain:
      return false;
  }
  return false;
}

}  // namespace annulus::sim
