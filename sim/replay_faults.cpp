#include "sim/replay_faults.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "sim/fault_actors.h"
#include "sim/faulty_can_bus.h"
#include "sim/faulty_usb_port.h"
#include "sim/world.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using Kind = FaultKind;

constexpr std::uint64_t kForUsb = 0x72757362;
constexpr std::uint64_t kForCan = 0x7263616e;

/// Whether it can go wrong behind a recording.
bool Touches(Kind kind) {
  switch (kind) {
    case Kind::kUsbUnplug:
    case Kind::kUsbShort:
    case Kind::kUsbZero:
    case Kind::kUsbLong:
    case Kind::kUsbDamage:
    case Kind::kUsbTimeout:
    case Kind::kUsbStall:
    case Kind::kUsbNoMemory:
    case Kind::kUsbCancelCompletes:
    case Kind::kCanLose:
    case Kind::kCanRepeat:
    case Kind::kCanDisplace:
    case Kind::kCanOverflow:
    case Kind::kCanQueueFull:
    case Kind::kCanDown:
    case Kind::kCanGone:
    case Kind::kCanBusOff:
    case Kind::kCanErrorStates:
    case Kind::kCanFlood:
      return true;
    default:
      return false;
  }
}

bool Meets(const Fault& fault, FaultArg place, std::size_t number) {
  return fault.Choice(place).value_or(number) == number;
}

/// A port whose plug can be pulled.
class PluggedPort final : public UsbPort {
 public:
  PluggedPort(UsbPort& port, Clock& clock) : port_(port), clock_(clock) {}

  void Pull() { pulled_ = true; }

  [[nodiscard]] const UsbIdentity& identity() const override { return port_.identity(); }
  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length, nanoseconds timeout) override {
    if (pulled_) return Gone();
    return port_.ControlIn(request, length, timeout);
  }
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data, nanoseconds timeout) override {
    if (pulled_) return Gone();
    return port_.ControlOut(request, data, timeout);
  }
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) override {
    if (pulled_) return Gone();
    auto token = port_.SubmitBulkIn(endpoint, length);
    if (token) pending_.push_back(*token);
    return token;
  }
  void Cancel(UsbToken token) override { port_.Cancel(token); }
  UsbResult<void> ClearHalt(std::uint8_t endpoint) override {
    if (pulled_) return Gone();
    return port_.ClearHalt(endpoint);
  }
  std::optional<UsbCompletion> WaitCompletion(nanoseconds deadline) override {
    if (!pulled_) {
      auto completion = port_.WaitCompletion(deadline);
      if (completion) std::erase(pending_, completion->token);
      return completion;
    }
    if (pending_.empty()) {
      clock_.SleepUntil(deadline);
      return std::nullopt;
    }
    UsbCompletion completion{pending_.front(), UsbStatus::kNoDevice, {}, clock_.Now()};
    pending_.erase(pending_.begin());
    return completion;
  }
  [[nodiscard]] std::size_t in_flight() const override { return pending_.size(); }

 private:
  static tl::unexpected<UsbFailure> Gone() { return tl::unexpected<UsbFailure>(UsbFailure{UsbStatus::kNoDevice, {}}); }

  UsbPort& port_;
  Clock& clock_;
  bool pulled_ = false;
  std::vector<UsbToken> pending_;
};

}  // namespace

class ReplayFaults::Port {
 public:
  Port(UsbPort& port, std::size_t number, std::uint64_t seed, Clock& clock)
      : number_(number), seed_(MixSeed(MixSeed(seed, kForUsb), number)), plugged_(port, clock), faulty_(plugged_, {}) {
    Rebuild();
    faulty_.FollowPlan(plan_);
  }

  [[nodiscard]] FaultyUsbPort& port() { return faulty_; }
  void Begin(std::size_t fault_number, const Fault& fault) {
    if (!Meets(fault, FaultArg::kBoard, number_)) return;
    if (fault.kind == Kind::kUsbUnplug) plugged_.Pull();
    if (fault.kind == Kind::kUsbNoMemory) no_memory_left_ = fault.Choice(FaultArg::kCount).value_or(1);
    holding_[fault_number] = fault;
    Rebuild();
  }
  void End(std::size_t fault_number) {
    holding_.erase(fault_number);
    Rebuild();
  }
  void TakeSubmit() {
    plan_.no_memory = no_memory_left_ > 0;
    no_memory_left_ -= no_memory_left_ > 0 ? 1 : 0;
  }

 private:
  void Rebuild() {
    plan_ = {};
    plan_.seed = seed_;
    for (const auto& [fault_number, fault] : holding_) Apply(fault);
  }
  void Apply(const Fault& fault) {
    const auto share = [&] { return fault.Value(FaultArg::kShare); };
    if (fault.kind == Kind::kUsbShort) plan_.short_share = share();
    if (fault.kind == Kind::kUsbZero) plan_.zero_share = share();
    if (fault.kind == Kind::kUsbLong) plan_.long_share = share();
    if (fault.kind == Kind::kUsbDamage) plan_.damage_share = share();
    if (fault.kind == Kind::kUsbTimeout) plan_.timeout_share = share();
    if (fault.kind == Kind::kUsbCancelCompletes) plan_.cancel_completes_share = share();
    if (fault.kind != Kind::kUsbStall) return;
    plan_.stall_share = share();
    plan_.stall_stays = fault.Whole(FaultArg::kStays) != 0;
  }

  std::size_t number_;
  std::uint64_t seed_;
  std::map<std::size_t, Fault> holding_;
  std::uint64_t no_memory_left_ = 0;
  UsbFaultPlan plan_;
  PluggedPort plugged_;
  FaultyUsbPort faulty_;
};

class ReplayFaults::Bus {
 public:
  Bus(CanBus& bus, std::size_t number, std::uint64_t seed, Clock& clock)
      : number_(number), seed_(MixSeed(MixSeed(seed, kForCan), number)), faulty_(bus, clock) {}

  [[nodiscard]] FaultyCanBus& bus() { return faulty_; }
  void Begin(std::size_t fault_number, const Fault& fault, nanoseconds from, nanoseconds to) {
    if (!Meets(fault, FaultArg::kBus, number_)) return;
    if (BeginOnInterface(faulty_, fault, from, to)) return;
    CanReport report;
    CanFrame frame;
    switch (fault.kind) {
      case Kind::kCanBusOff:
        report.state = CanState::kBusOff;
        return faulty_.ReportAt(from, report);
      case Kind::kCanFlood:
        frame.id = static_cast<std::uint32_t>(fault.Whole(FaultArg::kId));
        frame.size = 8;
        return faulty_.FloodBetween(from, to, fault.Period(), frame);
      default:
        holding_[fault_number] = fault;
        return Rebuild();
    }
  }
  void End(std::size_t fault_number, nanoseconds time) {
    if (holding_.erase(fault_number) > 0) return Rebuild();
    faulty_.EndBy(time);
  }

 private:
  void Rebuild() {
    CanFrameFaults faults;
    faults.seed = MixSeed(seed_, ++changes_);
    for (const auto& [fault_number, fault] : holding_) {
      const double share = fault.Value(FaultArg::kShare);
      if (fault.kind == Kind::kCanLose) faults.lose = share;
      if (fault.kind == Kind::kCanRepeat) faults.repeat = share;
      if (fault.kind != Kind::kCanDisplace) continue;
      faults.displace = share;
      faults.displace_by = fault.Whole(FaultArg::kFrames);
    }
    faulty_.SetFrameFaults(faults);
  }

  std::size_t number_;
  std::uint64_t seed_;
  std::uint64_t changes_ = 0;
  std::map<std::size_t, Fault> holding_;
  FaultyCanBus faulty_;
};

ReplayFaults::ReplayFaults(FaultPlan plan) : plan_(std::move(plan)) {}
ReplayFaults::~ReplayFaults() = default;

void ReplayFaults::Begin(Clock& clock) {
  clock_ = &clock;
  levels_ = 0;
  ports_.clear();
  buses_.clear();
  schedule_ = std::make_unique<FaultSchedule>(plan_, clock.Now());
}

std::vector<UsbPort*> ReplayFaults::WrapUsb(const std::vector<UsbPort*>& ports, Clock& clock) {
  Begin(clock);
  std::vector<UsbPort*> wrapped;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    ports_.push_back(std::make_unique<Port>(*ports[i], i, plan_.seed, clock));
    Port& port = *ports_.back();
    port.port().OnCall([this, &port, i](FaultyUsbPort::Call call) {
      const bool submits = call == FaultyUsbPort::Call::kSubmit;
      NoteCall({FaultTarget::kUsb, i, submits});
      if (submits) port.TakeSubmit();
    });
    wrapped.push_back(&port.port());
  }
  Poll();
  return wrapped;
}

std::vector<CanBus*> ReplayFaults::WrapCan(const std::vector<CanBus*>& buses, Clock& clock) {
  Begin(clock);
  std::vector<CanBus*> wrapped;
  for (std::size_t i = 0; i < buses.size(); ++i) {
    buses_.push_back(std::make_unique<Bus>(*buses[i], i, plan_.seed, clock));
    buses_.back()->bus().OnCall([this, i] { NoteCall({FaultTarget::kCan, i, false}); });
    wrapped.push_back(&buses_.back()->bus());
  }
  Poll();
  return wrapped;
}

void ReplayFaults::NoteScan() {
  if (!schedule_) return;
  schedule_->NoteState("SCANNING", clock_->Now());
  Poll();
}

void ReplayFaults::NoteLevel() {
  if (!schedule_) return;
  schedule_->NoteLevel(levels_++, clock_->Now());
  Poll();
}

void ReplayFaults::NoteCall(const FaultCall& call) {
  schedule_->NoteCall(call, clock_->Now());
  Poll();
}

void ReplayFaults::Poll() {
  // What is done may take its time, in which others ask.
  if (std::exchange(polling_, true)) return;
  for (const FaultSchedule::Step& step : schedule_->Take(clock_->Now())) {
    const Fault& fault = plan_.faults.at(step.fault);
    if (!Touches(fault.kind)) continue;
    const bool usb = TraitsOf(fault.kind).target == FaultTarget::kUsb;
    for (const auto& port : ports_) {
      if (!usb) break;
      step.begins ? port->Begin(step.fault, fault) : port->End(step.fault);
    }
    for (const auto& bus : buses_) {
      if (usb) break;
      step.begins ? bus->Begin(step.fault, fault, step.time, step.to) : bus->End(step.fault, step.time);
    }
  }
  polling_ = false;
}

std::vector<std::string> ReplayFaults::Untouched() const {
  std::vector<std::string> texts;
  for (const Fault& fault : plan_.faults) {
    if (!Touches(fault.kind)) texts.push_back(FaultText(fault));
  }
  return texts;
}

std::vector<FaultEvent> ReplayFaults::log() const { return schedule_ ? schedule_->log() : std::vector<FaultEvent>(); }

}  // namespace annulus::sim
