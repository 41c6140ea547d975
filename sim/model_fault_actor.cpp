#include <algorithm>
#include <array>
#include <utility>

#include "base/ensure.h"
#include "firmware_iface/interlock.h"
#include "sim/fault_actors.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using Kind = FaultKind;

/// The same mishap of the axis, without the times; of `limit` the one end.
AxisMishap MishapOf(const Fault& fault) {
  using P = AxisParameterRegisters;
  constexpr std::array<std::uint16_t, 10> kParameters{
      P::kZMin,           P::kZMax,     P::kMaxSpeed, P::kMaxAcceleration, P::kQuickStop,
      P::kFollowingLimit, P::kHomeFast, P::kHomeSlow, P::kHeartbeat,       P::kStartWindow};
  const auto is = [](AxisMishapKind kind, double value = 0.0, std::uint64_t code = 0) {
    AxisMishap mishap;
    mishap.kind = kind;
    mishap.value = value;
    mishap.code = static_cast<std::uint16_t>(code);
    return mishap;
  };
  using M = AxisMishapKind;
  switch (fault.kind) {
    case Kind::kAxisLag:
      return is(M::kLag, fault.Value(FaultArg::kTimeConstantMs) / 1000.0);
    case Kind::kAxisContact:
      return is(M::kContact, fault.Value(FaultArg::kHeightMm));
    case Kind::kAxisOverload:
      return is(M::kOverload, fault.Value(FaultArg::kHeightMm), fault.Whole(FaultArg::kCode));
    case Kind::kAxisSlip:
      return is(M::kSlip, fault.Value(FaultArg::kSpeedMmS));
    case Kind::kAxisEncoderJump:
      return is(M::kEncoderJump, fault.Value(FaultArg::kJumpMm));
    case Kind::kAxisHomeNever:
      return is(M::kHomeNever);
    case Kind::kAxisHomeStuck:
      return is(M::kHomeStuck);
    case Kind::kAxisLimit:
      return is(fault.Whole(FaultArg::kEnd) == 1 ? M::kLowerLimit : M::kUpperLimit);
    case Kind::kAxisUnorderedMove:
      return is(M::kUnorderedMove, fault.Value(FaultArg::kSpeedMmS));
    case Kind::kAxisScale:
      return is(M::kScale, fault.Value(FaultArg::kScale));
    case Kind::kAxisOverspeed:
      return is(M::kOverspeed, fault.Value(FaultArg::kScale));
    case Kind::kAxisIgnoreStops:
      return is(M::kIgnoreStops);
    case Kind::kAxisIgnoreQuickStop:
      return is(M::kIgnoreQuickStop);
    case Kind::kAxisPowerOff:
      return is(M::kPowerOff);
    case Kind::kAxisParameter:
      return is(M::kParameter, fault.Value(FaultArg::kValue), kParameters.at(fault.Whole(FaultArg::kParameter)));
    default:
      ENSURE(fault.kind == Kind::kAxisDriveFault, "it is a mishap of the axis");
      return is(M::kDriveFault, 0.0, fault.Whole(FaultArg::kCode));
  }
}

std::vector<AxisMishap> MishapsOf(const Fault& fault) {
  std::vector<AxisMishap> mishaps{MishapOf(fault)};
  if (fault.kind == Kind::kAxisLimit && fault.Whole(FaultArg::kEnd) == 2) {
    mishaps.push_back(mishaps.front());
    mishaps.back().kind = AxisMishapKind::kLowerLimit;
  }
  return mishaps;
}

/// The same fault of a board, without times and sensors.
BoardFault BoardFaultOf(const Fault& fault) {
  const auto is = [](BoardFaultKind kind, double value = 0.0, double size_mm = 0.0) {
    BoardFault board;
    board.kind = kind;
    board.value = value;
    board.size_mm = size_mm;
    return board;
  };
  using B = BoardFaultKind;
  switch (fault.kind) {
    case Kind::kSensorsStuck:
      return is(B::kStuck);
    case Kind::kSensorsNoReturn:
      return is(B::kNoReturn, fault.Value(FaultArg::kShare));
    case Kind::kSensorsSpikes:
      return is(B::kSpikes, fault.Value(FaultArg::kShare), fault.Value(FaultArg::kSizeMm));
    case Kind::kSensorsDrift:
      return is(B::kDrift, fault.Value(FaultArg::kSpeedMmS));
    case Kind::kSensorsDead:
      return is(B::kDead);
    case Kind::kSensorsSilent:
      return is(B::kSilent);
    case Kind::kSensorsLate:
      return is(B::kLate, fault.Value(FaultArg::kLevels));
    case Kind::kSensorsClockStuck:
      return is(B::kClockStuck);
    case Kind::kSensorsClockJump:
      return is(B::kClockJump, fault.Value(FaultArg::kJumpMs) / 1000.0);
    case Kind::kSensorsClockWrap:
      return is(B::kClockWrap, fault.Value(FaultArg::kInS));
    case Kind::kSensorsProtocol:
      return is(B::kProtocol, fault.Value(FaultArg::kVersion));
    case Kind::kSensorsFirmware:
      return is(B::kFirmware, fault.Value(FaultArg::kVersion));
    case Kind::kSensorsPlace:
      return is(B::kPlace, fault.Value(FaultArg::kSensor));
    default:
      ENSURE(fault.kind == Kind::kSensorsEmitterFault, "it is a fault of the boards");
      return is(B::kEmitterFault);
  }
}

/// The sensors of a board that a fault is about.
struct SensorSpan {
  std::size_t first = 0;
  std::size_t count = 0;
};
SensorSpan SensorsOf(const Fault& fault, std::size_t board) {
  if (fault.Choice(FaultArg::kBoard).value_or(board) != board) return {};
  const auto sensor = fault.Choice(FaultArg::kSensor);
  if (!sensor || fault.kind == Kind::kSensorsPlace) return {0, kSensorsPerBoard};
  const std::size_t begin = std::max<std::size_t>(*sensor, board * kSensorsPerBoard);
  const std::size_t end =
      std::min<std::size_t>(*sensor + fault.Whole(FaultArg::kSensors), (board + 1) * kSensorsPerBoard);
  if (begin >= end) return {};
  return {begin - board * kSensorsPerBoard, end - begin};
}

InterlockInput InputOf(const Fault& fault) { return static_cast<InterlockInput>(fault.Whole(FaultArg::kInput)); }
InterlockOutput OutputOf(const Fault& fault) { return static_cast<InterlockOutput>(fault.Whole(FaultArg::kOutput)); }

/// The contacts that a fault moves.
std::vector<InterlockInput> ContactsOf(const Fault& fault) {
  if (fault.kind != Kind::kChainEstop) return {InputOf(fault)};
  switch (fault.Whole(FaultArg::kChannel)) {
    case 0:
      return {InterlockInput::kEstopA};
    case 1:
      return {InterlockInput::kEstopB};
    default:
      return {InterlockInput::kEstopA, InterlockInput::kEstopB};
  }
}

}  // namespace

void ModelFaultActor::Begin(std::size_t number, const Fault& fault, nanoseconds from, nanoseconds to) {
  switch (TraitsOf(fault.kind).target) {
    case FaultTarget::kAxis:
      return BeginOnAxis(fault, from, to);
    case FaultTarget::kSensors:
      return BeginOnBoards(number, fault, from, to);
    default:
      return BeginOnChain(fault, from, to);
  }
}

void ModelFaultActor::End(std::size_t number, const Fault& fault, nanoseconds time) {
  switch (TraitsOf(fault.kind).target) {
    case FaultTarget::kAxis:
      // The drive was told at the beginning, if the end was known then.
      if (EndsInTime(fault)) return;
      for (const AxisMishap& mishap : MishapsOf(fault)) ground_.booth.drive().Recover(mishap, time);
      return;
    case FaultTarget::kSensors:
      for (const OnBoard& on : on_boards_[number]) on.board->End(on.number, time);
      return;
    default:
      return EndOnChain(fault, time);
  }
}

void ModelFaultActor::BeginOnAxis(const Fault& fault, nanoseconds from, nanoseconds to) {
  for (AxisMishap mishap : MishapsOf(fault)) {
    mishap.from = from;
    mishap.to = to;
    ground_.booth.drive().Suffer(mishap);
  }
}

void ModelFaultActor::Damage(std::size_t number, std::size_t board, const BoardFault& fault) {
  std::vector<BoardFaults*> models{&ground_.booth.board(board).faults()};
  if (!ground_.booth.can_buses().empty()) models.push_back(&ground_.booth.can_board(board).faults());
  for (BoardFaults* model : models) on_boards_[number].push_back({model, model->Add(fault)});
}

void ModelFaultActor::SwapSensors(std::size_t number, const Fault& fault, nanoseconds from, nanoseconds to) {
  constexpr std::uint64_t kSensors = BoothDevices::kBoards * kSensorsPerBoard;
  const std::uint64_t one = fault.Whole(FaultArg::kSensor);
  const std::uint64_t other = fault.Whole(FaultArg::kOther);
  const std::uint64_t count = std::min(fault.Whole(FaultArg::kSensors), kSensors - std::max(one, other));
  for (const auto& [channels, sensors] : {std::pair{one, other}, std::pair{other, one}}) {
    for (std::uint64_t k = 0; k < count; ++k) {
      BoardFault wiring;
      wiring.kind = BoardFaultKind::kWiring;
      wiring.from = from;
      wiring.to = to;
      wiring.first_sensor = (channels + k) % kSensorsPerBoard;
      wiring.sensors = 1;
      wiring.value = static_cast<double>(sensors + k);
      Damage(number, (channels + k) / kSensorsPerBoard, wiring);
    }
  }
}

void ModelFaultActor::BeginOnBoards(std::size_t number, const Fault& fault, nanoseconds from, nanoseconds to) {
  if (fault.kind == Kind::kSensorsSwapped) return SwapSensors(number, fault, from, to);
  BoardFault on_board = BoardFaultOf(fault);
  on_board.from = from;
  on_board.to = to;
  for (std::size_t board = 0; board < ground_.booth.board_count(); ++board) {
    const SensorSpan span = SensorsOf(fault, board);
    if (span.count == 0) continue;
    on_board.first_sensor = span.first;
    on_board.sensors = span.count;
    Damage(number, board, on_board);
  }
}

void ModelFaultActor::BeginOnChain(const Fault& fault, nanoseconds from, nanoseconds to) {
  SafetyChain& chain = ground_.booth.safety();
  switch (fault.kind) {
    case Kind::kChainEstop:
    case Kind::kChainOpen:
    case Kind::kChainPress: {
      const bool closes = fault.kind == Kind::kChainPress;
      for (const InterlockInput contact : ContactsOf(fault)) {
        chain.SetAt(from, contact, closes);
        if (to != nanoseconds::max()) chain.SetAt(to, contact, !closes);
      }
      return;
    }
    default:
      return DamageChain(fault);
  }
}

void ModelFaultActor::DamageChain(const Fault& fault) {
  SafetyChain& chain = ground_.booth.safety();
  switch (fault.kind) {
    case Kind::kChainWireBreak:
      return chain.BreakWire(InputOf(fault));
    case Kind::kChainJamBrake:
      return chain.JamBrake();
    case Kind::kChainWeldStoA:
      return chain.WeldStoA();
    case Kind::kChainWeldWatchdog:
      return chain.WeldWatchdog();
    case Kind::kChainCutWatchdog:
      return chain.CutWatchdogWire();
    case Kind::kChainBurnOut:
      return chain.BurnOut(OutputOf(fault));
    case Kind::kChainShort:
      return chain.HoldOutput(OutputOf(fault), fault.Whole(FaultArg::kLevel) != 0);
    case Kind::kChainRemoveChip:
      return chain.RemoveChip();
    case Kind::kChainOccupied:
      return chain.Occupy(InterlockName(InputOf(fault)), "another program");
    case Kind::kChainRenamed:
      return chain.Rename(InterlockName(InputOf(fault)), std::string(InterlockName(InputOf(fault))) + "-2");
    default:
      return;
  }
}

void ModelFaultActor::EndOnChain(const Fault& fault, nanoseconds time) {
  SafetyChain& chain = ground_.booth.safety();
  switch (fault.kind) {
    case Kind::kChainEstop:
    case Kind::kChainOpen:
    case Kind::kChainPress:
      if (EndsInTime(fault)) return;
      for (const InterlockInput contact : ContactsOf(fault))
        chain.SetAt(time, contact, fault.kind != Kind::kChainPress);
      return;
    case Kind::kChainWireBreak:
      return chain.MendWire(InputOf(fault));
    case Kind::kChainShort:
      return chain.HoldOutput(OutputOf(fault), std::nullopt);
    default:
      return;
  }
}

}  // namespace annulus::sim
