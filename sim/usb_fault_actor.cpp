#include <algorithm>

#include "sim/fault_actors.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using Kind = FaultKind;

constexpr std::uint64_t kForUsb = 0x75736200;

nanoseconds Milliseconds(double ms) { return nanoseconds(static_cast<std::int64_t>(ms * 1e6)); }

void Apply(const Fault& fault, UsbFaultPlan& plan) {
  switch (fault.kind) {
    case Kind::kUsbShort:
      plan.short_share = fault.Value(FaultArg::kShare);
      return;
    case Kind::kUsbZero:
      plan.zero_share = fault.Value(FaultArg::kShare);
      return;
    case Kind::kUsbLong:
      plan.long_share = fault.Value(FaultArg::kShare);
      return;
    case Kind::kUsbDamage:
      plan.damage_share = fault.Value(FaultArg::kShare);
      return;
    case Kind::kUsbTimeout:
      plan.timeout_share = fault.Value(FaultArg::kShare);
      return;
    case Kind::kUsbStall:
      plan.stall_share = fault.Value(FaultArg::kShare);
      plan.stall_stays = fault.Whole(FaultArg::kStays) != 0;
      return;
    case Kind::kUsbCancelCompletes:
      plan.cancel_completes_share = fault.Value(FaultArg::kShare);
      return;
    case Kind::kUsbUnplug:
      plan.unplug_ending = static_cast<UsbFaultPlan::UnplugEnding>(fault.Whole(FaultArg::kEnding));
      return;
    default:
      return;
  }
}

bool Meets(const Fault& fault, std::size_t board) { return fault.Choice(FaultArg::kBoard).value_or(board) == board; }

}  // namespace

bool EndsInTime(const Fault& fault) {
  return fault.lasting || (fault.until && fault.until->kind == FaultTrigger::Kind::kTime);
}

void HoldingFaults::Add(std::size_t number, const Fault& fault, nanoseconds from, nanoseconds to) {
  // By number, so that the order does not depend on how they were told.
  const auto after = std::upper_bound(all_.begin(), all_.end(), number,
                                      [](std::size_t n, const Holding& other) { return n < other.number; });
  std::uint64_t left = std::numeric_limits<std::uint64_t>::max();
  for (const FaultArgRule& rule : TraitsOf(fault.kind).args) {
    if (rule.arg != FaultArg::kCount) continue;
    if (const auto given = fault.Choice(FaultArg::kCount))
      left = *given;
    else if (rule.fallback)
      left = static_cast<std::uint64_t>(*rule.fallback);
  }
  all_.insert(after, {number, fault, from, to, left});
}

void HoldingFaults::Remove(std::size_t number) {
  std::erase_if(all_, [&](const Holding& holding) { return holding.number == number; });
}

UsbFaultActor::UsbFaultActor(FaultGround ground) : ground_(std::move(ground)) {
  const std::vector<UsbPort*> models = ground_.booth.usb_ports();
  for (std::size_t board = 0; board < boards(); ++board) identity_[board] = models.at(board)->identity();
  Rebuild();
}

UsbHostModel& UsbFaultActor::host() {
  if (host_) return *host_;
  host_ = std::make_unique<UsbHostModel>(ground_.clock);
  for (std::size_t board = 0; board < boards(); ++board) {
    host_->Add(ground_.booth.board(board));
    host_->SetIdentity(board, identity_[board].serial, identity_[board].port_path);
  }
  host_->wrap = [this](std::unique_ptr<UsbPort> port) -> std::unique_ptr<UsbPort> {
    const std::size_t board = BoardOf(port->identity());
    auto faulty = std::make_unique<FaultyUsbPort>(std::move(port), plan_.at(board), log_.at(board));
    faulty->FollowPlan(plan_.at(board));
    faulty->OnCall([this, board](FaultyUsbPort::Call call) { TakeCall(board, call); });
    return faulty;
  };
  PullWaitingPlugs();
  return *host_;
}

std::vector<UsbPort*> UsbFaultActor::ports() {
  const std::vector<UsbPort*> models = ground_.booth.usb_ports();
  for (std::size_t board = ports_.size(); board < boards(); ++board) {
    ports_.push_back(std::make_unique<FaultyUsbPort>(*models.at(board), plan_.at(board), log_.at(board)));
    ports_.back()->FollowPlan(plan_.at(board));
    ports_.back()->OnCall([this, board](FaultyUsbPort::Call call) { TakeCall(board, call); });
  }
  PullWaitingPlugs();
  std::vector<UsbPort*> ports;
  for (const auto& port : ports_) ports.push_back(port.get());
  return ports;
}

std::size_t UsbFaultActor::BoardOf(const UsbIdentity& identity) const {
  for (std::size_t board = 0; board < boards(); ++board) {
    const bool same = identity_[board].serial == identity.serial && identity_[board].port_path == identity.port_path;
    if (same) return board;
  }
  return 0;
}

void UsbFaultActor::TakeCall(std::size_t board, FaultyUsbPort::Call call) {
  const bool submits = call == FaultyUsbPort::Call::kSubmit;
  ground_.on_call({FaultTarget::kUsb, board, submits});
  if (!submits) return;
  plan_[board].no_memory = false;
  for (HoldingFaults::Holding& holding : holding_.all()) {
    if (holding.fault.kind != Kind::kUsbNoMemory || !Meets(holding.fault, board) || holding.left == 0) continue;
    --holding.left;
    plan_[board].no_memory = true;
  }
}

void UsbFaultActor::Begin(std::size_t number, const Fault& fault, nanoseconds from, nanoseconds to) {
  if (fault.kind == Kind::kUsbSameSerial || fault.kind == Kind::kUsbSwapped) return Confuse(fault);
  holding_.Add(number, fault, from, to);
  Rebuild();
  if (fault.kind == Kind::kUsbUnplug) Unplug(fault, from, to);
}

void UsbFaultActor::End(std::size_t number, const Fault& fault, nanoseconds time) {
  const auto& all = holding_.all();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const auto& holding) { return holding.number == number; });
  const bool planned = found != all.end() && found->to != nanoseconds::max();
  holding_.Remove(number);
  Rebuild();
  // The bus was told at the beginning, or will be, if the end was known then.
  if (fault.kind == Kind::kUsbUnplug && !(planned && host_)) Plug(fault, time);
}

void UsbFaultActor::Unplug(const Fault& fault, nanoseconds from, nanoseconds to) {
  const nanoseconds spread = Milliseconds(fault.Value(FaultArg::kSpreadMs)) / static_cast<std::int64_t>(boards());
  const nanoseconds not_ready = Milliseconds(1000.0 * fault.Value(FaultArg::kNotReadyS));
  for (std::size_t board = 0; board < boards(); ++board) {
    if (!Meets(fault, board)) continue;
    const nanoseconds time = from + spread * static_cast<std::int64_t>(board);
    waiting_.push_back({board, time, to, not_ready});
  }
  if (host_ || !ports_.empty()) PullWaitingPlugs();
}

void UsbFaultActor::PullWaitingPlugs() {
  for (const WaitingPlug& plug : std::exchange(waiting_, {})) {
    const nanoseconds time = std::max(ground_.clock.Now(), plug.unplug);
    if (!host_) {
      ground_.booth.board(plug.board).UnplugAt(time);
      continue;
    }
    host_->UnplugAt(plug.board, time);
    if (plug.plug != nanoseconds::max()) {
      host_->PlugAt(plug.board, std::max(plug.plug, time + nanoseconds(1)), plug.not_ready);
    }
  }
}

void UsbFaultActor::Plug(const Fault& fault, nanoseconds time) {
  const nanoseconds not_ready = Milliseconds(1000.0 * fault.Value(FaultArg::kNotReadyS));
  for (std::size_t board = 0; board < boards(); ++board) {
    if (!Meets(fault, board)) continue;
    if (host_) {
      host_->PlugAt(board, time, not_ready);
    } else {
      to_plug_[board] = true;
    }
  }
}

void UsbFaultActor::Follow() {
  if (host_) host_->Advance();
  for (std::size_t board = 0; board < boards(); ++board) {
    // A board without a bus can be plugged in only when what was in flight has been collected.
    if (!to_plug_[board] || ground_.booth.board(board).in_flight() > 0) continue;
    ground_.booth.board(board).PlugIn();
    to_plug_[board] = false;
  }
}

void UsbFaultActor::Confuse(const Fault& fault) {
  const std::size_t board = fault.Whole(FaultArg::kBoard);
  const std::size_t other = fault.Whole(FaultArg::kOther);
  const auto lie = [this](std::size_t who, BoardFaultKind kind, double value) {
    BoardFault claim;
    claim.kind = kind;
    claim.from = ground_.clock.Now();
    claim.value = value;
    ground_.booth.board(who).faults().Add(claim);
  };
  const auto number = [this](std::size_t who) { return std::stod(identity_[who].serial.substr(2)); };  // after "RB"
  lie(board, BoardFaultKind::kSerial, number(other));
  if (fault.kind == Kind::kUsbSameSerial) {
    identity_[board].serial = identity_[other].serial;
  } else {
    // What stands in one place now is the other one's electronics, with all that it says of itself.
    lie(other, BoardFaultKind::kSerial, number(board));
    lie(board, BoardFaultKind::kPlace, static_cast<double>(other * kSensorsPerBoard));
    lie(other, BoardFaultKind::kPlace, static_cast<double>(board * kSensorsPerBoard));
    std::swap(identity_[board].serial, identity_[other].serial);
  }
  for (const std::size_t one : {board, other}) {
    if (host_) host_->SetIdentity(one, identity_[one].serial, identity_[one].port_path);
  }
}

void UsbFaultActor::Rebuild() {
  for (std::size_t board = 0; board < boards(); ++board) {
    UsbFaultPlan plan;
    plan.seed = MixSeed(MixSeed(ground_.seed, kForUsb), board);
    for (const HoldingFaults::Holding& holding : holding_.all()) {
      if (Meets(holding.fault, board)) Apply(holding.fault, plan);
    }
    plan_[board] = plan;
  }
}

}  // namespace annulus::sim
