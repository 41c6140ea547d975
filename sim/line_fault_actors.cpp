#include <algorithm>
#include <cmath>

#include "sim/fault_actors.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using Kind = FaultKind;

constexpr std::uint64_t kForLink = 0x6c696e6b;
constexpr std::uint64_t kForGpio = 0x6770696f;

nanoseconds DelayOf(const Fault& fault) { return nanoseconds(std::llround(1e6 * fault.Value(FaultArg::kDelayMs))); }

void Apply(const Fault& fault, ModbusFate& fate) {
  switch (fault.kind) {
    case Kind::kLinkLoseRequest:
      fate.request_lost = true;
      return;
    case Kind::kLinkLoseReply:
      fate.copies = 0;
      return;
    case Kind::kLinkLate:
      fate.delay = DelayOf(fault);
      return;
    case Kind::kLinkRepeat:
      fate.delay = DelayOf(fault);
      fate.copies = 2;
      return;
    case Kind::kLinkTruncate:
      fate.missing = fault.Whole(FaultArg::kRegisters);
      return;
    case Kind::kLinkDamage:
      fate.damaged = true;
      return;
    case Kind::kLinkMerge:
      fate.merged = true;
      return;
    case Kind::kLinkException:
      fate.exception = static_cast<std::uint8_t>(fault.Whole(FaultArg::kCode));
      return;
    default:
      return;
  }
}

}  // namespace

LinkFaultActor::LinkFaultActor(FaultGround ground, ModbusNumbering numbering)
    : ground_(std::move(ground)),
      link_(ground_.booth.axis_link(), ground_.clock, numbering, [this] { return Fate(); }) {
  link_.OnCall([this] { ground_.on_call({FaultTarget::kAxisLink, FaultCall::kAnywhere, false}); });
}

ModbusFate LinkFaultActor::Fate() {
  ModbusFate fate;
  for (HoldingFaults::Holding& holding : holding_.all()) {
    const bool comes_and_goes = holding.fault.kind != Kind::kLinkFreeze && holding.fault.kind != Kind::kLinkUnplug;
    if (!comes_and_goes || holding.left == 0) continue;
    const double draw = UnitFromBits(MixSeed(MixSeed(ground_.seed, kForLink), ++drawn_));
    if (draw >= holding.fault.Value(FaultArg::kShare)) continue;
    --holding.left;
    Apply(holding.fault, fate);
  }
  return fate;
}

void LinkFaultActor::Begin(std::size_t number, const Fault& fault, nanoseconds from, nanoseconds to) {
  holding_.Add(number, fault, from, to);
  if (fault.kind == Kind::kLinkUnplug) link_.Unplug();
  if (fault.kind != Kind::kLinkFreeze) return;
  if (to == nanoseconds::max()) {
    link_.Freeze();
  } else {
    link_.FreezeUntil(to);
  }
}

void LinkFaultActor::End(std::size_t number, const Fault& fault, nanoseconds) {
  holding_.Remove(number);
  if (fault.kind == Kind::kLinkUnplug) link_.Plug();
  if (fault.kind == Kind::kLinkFreeze) static_cast<void>(link_.Thaw());
}

GpioFaultActor::GpioFaultActor(FaultGround ground) : ground_(std::move(ground)) {
  plan_.seed = MixSeed(ground_.seed, kForGpio);
}

std::unique_ptr<GpioLines> GpioFaultActor::Wrap(std::unique_ptr<GpioLines> lines) {
  auto faulty = std::make_unique<FaultyGpioLines>(std::move(lines), plan_, ground_.clock);
  faulty->FollowPlan(plan_);
  faulty->OnCall([this] { ground_.on_call({FaultTarget::kGpio, FaultCall::kAnywhere, false}); });
  return faulty;
}

void GpioFaultActor::Begin(std::size_t number, const Fault& fault, nanoseconds from, nanoseconds to) {
  holding_.Add(number, fault, from, to);
  Rebuild();
}

void GpioFaultActor::End(std::size_t number, const Fault&, nanoseconds) {
  holding_.Remove(number);
  Rebuild();
}

void GpioFaultActor::Rebuild() {
  GpioFaultPlan plan;
  plan.seed = plan_.seed;
  for (const HoldingFaults::Holding& holding : holding_.all()) {
    const Fault& fault = holding.fault;
    GpioFaultPlan::Outage outage{holding.from, holding.to, GpioFault::kError, {}, GpioFaultPlan::Calls::kAll};
    switch (fault.kind) {
      case Kind::kGpioStuck:
        plan.stuck.push_back(
            {fault.Whole(FaultArg::kInput), fault.Whole(FaultArg::kLevel) != 0, holding.from, holding.to});
        break;
      case Kind::kGpioLoseEdges:
        plan.loss_rate = fault.Value(FaultArg::kShare);
        break;
      case Kind::kGpioChatter:
        plan.chatter_rate = fault.Value(FaultArg::kShare);
        plan.most_chatter = static_cast<int>(fault.Whole(FaultArg::kPairs));
        break;
      case Kind::kGpioLateEdges:
        plan.late = DelayOf(fault);
        break;
      case Kind::kGpioFail:
        plan.outages.push_back(outage);
        break;
      case Kind::kGpioFailWrites:
        outage.calls = GpioFaultPlan::Calls::kWrites;
        plan.outages.push_back(outage);
        break;
      case Kind::kGpioGone:
        outage.fault = GpioFault::kGone;
        plan.outages.push_back(outage);
        break;
      default:
        break;
    }
  }
  plan_ = plan;
}

}  // namespace annulus::sim
