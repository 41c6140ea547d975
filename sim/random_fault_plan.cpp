#include <cmath>
#include <utility>

#include "sim/fault_plan.h"
#include "sim/world.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using Arg = FaultArg;
using Kind = FaultKind;

/// Numbers of a seed, one after the other.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t number) : seed_(MixSeed(seed, number)) {}

  [[nodiscard]] double Unit() { return UnitFromBits(MixSeed(seed_, ++drawn_)); }
  [[nodiscard]] double Between(double low, double high) { return low + (high - low) * Unit(); }
  [[nodiscard]] std::uint64_t Below(std::uint64_t end) {
    return static_cast<std::uint64_t>(Unit() * static_cast<double>(end));
  }
  [[nodiscard]] double Whole(std::uint64_t low, std::uint64_t high) {
    return static_cast<double>(low + Below(high - low + 1));
  }
  [[nodiscard]] Kind OneOf(std::span<const Kind> kinds) { return kinds[Below(kinds.size())]; }

 private:
  std::uint64_t seed_;
  std::uint64_t drawn_ = 0;
};

constexpr std::array kOfStorage{Kind::kStorageNoSpace,   Kind::kStorageIoError,  Kind::kStorageShortWrite,
                                Kind::kStorageSyncError, Kind::kStorageSlowSync, Kind::kStorageReadOnly};
constexpr std::array kOfAxis{Kind::kAxisLag,           Kind::kAxisContact,   Kind::kAxisEncoderJump,
                             Kind::kAxisDriveFault,    Kind::kAxisOverspeed, Kind::kAxisIgnoreStops,
                             Kind::kAxisUnorderedMove, Kind::kAxisPowerOff,  Kind::kAxisParameter,
                             Kind::kLinkLoseReply,     Kind::kLinkLate,      Kind::kLinkFreeze,
                             Kind::kLinkUnplug,        Kind::kLinkDamage};
constexpr std::array kOfRing{Kind::kUsbUnplug,     Kind::kUsbShort,     Kind::kUsbDamage,       Kind::kUsbStall,
                             Kind::kUsbTimeout,    Kind::kSensorsDead,  Kind::kSensorsSilent,   Kind::kSensorsLate,
                             Kind::kSensorsSpikes, Kind::kSensorsStuck, Kind::kSensorsClockJump};
constexpr std::array kOfChain{Kind::kChainEstop, Kind::kChainOpen, Kind::kChainWireBreak, Kind::kGpioChatter,
                              Kind::kGpioFail};
constexpr std::array kOfHost{Kind::kHostKill, Kind::kHostHang, Kind::kHostLateTicks};

FaultTrigger Moment(Dice& dice) {
  FaultTrigger at;
  const double place = dice.Unit();
  if (place < 0.3) {
    at.kind = FaultTrigger::Kind::kLevel;
    at.number = dice.Below(40);
    return at;
  }
  at.kind = FaultTrigger::Kind::kState;
  at.state = place < 0.4 ? "HOMING" : place < 0.5 ? "ARMED" : place < 0.95 ? "SCANNING" : "STOPPING";
  at.delay = nanoseconds(std::chrono::milliseconds(dice.Below(1500)));
  return at;
}

nanoseconds ShortTime(Dice& dice) { return nanoseconds(std::chrono::milliseconds(20 + dice.Below(2000))); }

void SetAxisArgs(Fault& fault, Dice& dice) {
  switch (fault.kind) {
    case Kind::kAxisLag:
      return fault.args.Set(Arg::kTimeConstantMs, dice.Whole(40, 300));
    case Kind::kAxisContact:
      return fault.args.Set(Arg::kHeightMm, dice.Whole(300, 2000));
    case Kind::kAxisEncoderJump:
      return fault.args.Set(Arg::kJumpMm, dice.Unit() < 0.5 ? 50.0 : -50.0);
    case Kind::kAxisDriveFault:
      return fault.args.Set(Arg::kCode, dice.Unit() < 0.5 ? 0x3210 : 0x2310);
    case Kind::kAxisOverspeed:
      return fault.args.Set(Arg::kScale, 1.2);
    case Kind::kAxisUnorderedMove:
      return fault.args.Set(Arg::kSpeedMmS, dice.Unit() < 0.5 ? -20.0 : 20.0);
    case Kind::kAxisParameter:
      fault.args.Set(Arg::kParameter, 8.0);  // heartbeat_ms
      return fault.args.Set(Arg::kValue, dice.Unit() < 0.5 ? 0.0 : 5000.0);
    case Kind::kLinkLate:
      fault.args.Set(Arg::kCount, dice.Whole(1, 5));
      return fault.args.Set(Arg::kDelayMs, dice.Whole(30, 150));
    case Kind::kLinkLoseReply:
    case Kind::kLinkDamage:
      return fault.args.Set(Arg::kCount, dice.Whole(1, 5));
    default:
      return;
  }
}

void SetRingArgs(Fault& fault, Dice& dice) {
  fault.args.Set(Arg::kBoard, dice.Whole(0, 11));
  switch (fault.kind) {
    case Kind::kUsbUnplug:
      return fault.args.Set(Arg::kNotReadyS, 0.1);
    case Kind::kUsbShort:
    case Kind::kUsbDamage:
    case Kind::kUsbStall:
    case Kind::kUsbTimeout:
      return fault.args.Set(Arg::kShare, dice.Between(0.05, 1.0));
    case Kind::kSensorsSpikes:
      fault.args.Set(Arg::kShare, 0.01);
      return fault.args.Set(Arg::kSizeMm, 100.0);
    case Kind::kSensorsLate:
      return fault.args.Set(Arg::kLevels, dice.Whole(1, 3));
    case Kind::kSensorsClockJump:
      return fault.args.Set(Arg::kJumpMs, dice.Whole(1, 1000));
    default:
      return;
  }
}

void SetOtherArgs(Fault& fault, Dice& dice) {
  switch (fault.kind) {
    case Kind::kStorageSlowSync:
      return fault.args.Set(Arg::kDelayMs, dice.Whole(100, 2000));
    case Kind::kChainEstop:
      return fault.args.Set(Arg::kChannel, dice.Whole(0, 2));
    case Kind::kChainOpen:
    case Kind::kChainWireBreak:
      return fault.args.Set(Arg::kInput, dice.Whole(2, 4));  // door, limits
    case Kind::kHostLateTicks:
      fault.args.Set(Arg::kCount, dice.Whole(1, 4));
      return fault.args.Set(Arg::kDelayMs, dice.Whole(5, 500));
    default:
      return;
  }
}

Fault Draw(std::span<const Kind> kinds, Dice& dice) {
  Fault fault;
  fault.kind = dice.OneOf(kinds);
  fault.at = Moment(dice);
  switch (TraitsOf(fault.kind).target) {
    case FaultTarget::kAxis:
    case FaultTarget::kAxisLink:
      SetAxisArgs(fault, dice);
      break;
    case FaultTarget::kUsb:
    case FaultTarget::kSensors:
      SetRingArgs(fault, dice);
      break;
    default:
      SetOtherArgs(fault, dice);
      break;
  }
  // All end, so that the booth can be used again afterwards.
  if (TraitsOf(fault.kind).span != FaultSpan::kMoment) fault.lasting = ShortTime(dice);
  return fault;
}

}  // namespace

FaultPlan RandomFaultPlan(std::uint64_t seed, std::uint64_t number) {
  Dice dice(seed, number);
  FaultPlan plan;
  plan.seed = MixSeed(seed, number);
  using Kinds = std::span<const Kind>;
  const std::array<Kinds, 5> all{kOfStorage, kOfAxis, kOfRing, kOfChain, kOfHost};
  const std::array<std::pair<Kinds, Kinds>, 3> pairs{
      {{kOfStorage, kOfAxis}, {kOfRing, kOfChain}, {kOfHost, all[dice.Below(all.size() - 1)]}}};
  const auto& [first, second] = pairs[dice.Below(pairs.size())];
  const std::uint64_t count = 1 + dice.Below(4);
  for (std::uint64_t i = 0; i < count; ++i) plan.faults.push_back(Draw(i % 2 == 0 ? first : second, dice));
  return plan;
}

}  // namespace annulus::sim
