#include "sim/fault_schedule.h"

#include <algorithm>

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using Trigger = FaultTrigger::Kind;

/// Whether the model can be told of a fault before it comes, so that it comes exactly in time.
bool GivenAhead(FaultKind kind) {
  switch (kind) {
    case FaultKind::kUsbUnplug:
    case FaultKind::kCanBoardOff:
    case FaultKind::kCanEmergency:
    case FaultKind::kChainEstop:
    case FaultKind::kChainOpen:
    case FaultKind::kChainPress:
      return true;
    default:
      break;
  }
  const FaultTarget target = TraitsOf(kind).target;
  return target == FaultTarget::kAxis || target == FaultTarget::kSensors;
}

bool Concerns(const Fault& fault, const FaultCall& call) {
  if (TraitsOf(fault.kind).target != call.target) return false;
  if (fault.kind == FaultKind::kUsbNoMemory && !call.submits) return false;
  const FaultArg place = call.target == FaultTarget::kCan ? FaultArg::kBus : FaultArg::kBoard;
  const auto wanted = fault.Choice(place);
  return !wanted || call.where == FaultCall::kAnywhere || *wanted == call.where;
}

}  // namespace

FaultSchedule::FaultSchedule(const FaultPlan& plan, nanoseconds start)
    : plan_(plan), start_(start), runs_(plan.faults.size()) {
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const Fault& fault = plan_.faults[i];
    if (fault.at.kind == Trigger::kTime) runs_[i].from = start_ + fault.at.delay;
    if (fault.until && fault.until->kind == Trigger::kTime) runs_[i].to = start_ + fault.until->delay;
  }
}

void FaultSchedule::NoteState(const std::string& state, nanoseconds now) {
  if (state == state_) return;
  state_ = state;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const Fault& fault = plan_.faults[i];
    Run& run = runs_[i];
    const auto enters = [&](const FaultTrigger& trigger) {
      return trigger.kind == Trigger::kState && trigger.state == state;
    };
    if (fault.until && enters(*fault.until) && run.from && *run.from <= now && !run.to) {
      run.to = now + fault.until->delay;
    }
    if (enters(fault.at) && !run.from) run.from = now + fault.at.delay;
  }
}

void FaultSchedule::NoteLevel(std::uint64_t number, nanoseconds now) {
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const Fault& fault = plan_.faults[i];
    Run& run = runs_[i];
    if (fault.until && fault.until->kind == Trigger::kLevel && number >= fault.until->number && run.from && !run.to) {
      run.to = now;
    }
    if (fault.at.kind == Trigger::kLevel && number >= fault.at.number && !run.from) run.from = now;
  }
}

void FaultSchedule::NoteCall(const FaultCall& call, nanoseconds now) {
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const Fault& fault = plan_.faults[i];
    if (fault.at.kind != Trigger::kCall || runs_[i].from || !Concerns(fault, call)) continue;
    if (++runs_[i].calls == fault.at.number) runs_[i].from = now;
  }
}

void FaultSchedule::NoteBegun(std::size_t fault, nanoseconds now) {
  Run& run = runs_.at(fault);
  if (!run.from) run.from = now;
}

std::vector<FaultSchedule::Step> FaultSchedule::Take(nanoseconds now) {
  std::vector<Step> steps;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const Fault& fault = plan_.faults[i];
    Run& run = runs_[i];
    if (!run.from || run.disarmed) continue;
    if (fault.lasting && !run.to) run.to = *run.from + *fault.lasting;
    if (run.to && *run.to <= *run.from) run.to = *run.from + nanoseconds(1);
    const bool ahead = GivenAhead(fault.kind);
    if (!run.told && (ahead || *run.from <= now)) {
      run.told = true;
      steps.push_back({i, true, *run.from, run.to.value_or(nanoseconds::max())});
    }
    if (!run.begun && *run.from <= now) {
      run.begun = true;
      Log(i, *run.from, true);
    }
    if (run.told && !run.ended && run.to && *run.to <= now) {
      run.ended = true;
      steps.push_back({i, false, *run.to, *run.to});
      Log(i, *run.to, false);
    }
  }
  std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.time < b.time; });
  return steps;
}

std::vector<std::size_t> FaultSchedule::Disarm() {
  std::vector<std::size_t> disarmed;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (runs_[i].told) continue;
    runs_[i].disarmed = true;
    disarmed.push_back(i);
  }
  return disarmed;
}

void FaultSchedule::Log(std::size_t fault, nanoseconds time, bool begins) {
  FaultEvent event{time, fault, begins, FaultText(plan_.faults[fault])};
  const auto after = std::upper_bound(log_.begin(), log_.end(), event,
                                      [](const FaultEvent& a, const FaultEvent& b) { return a.time < b.time; });
  log_.insert(after, std::move(event));
}

bool FaultSchedule::finished() const {
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (runs_[i].disarmed) continue;
    if (!runs_[i].begun || (Ends(i) && !runs_[i].ended)) return false;
  }
  return true;
}

}  // namespace annulus::sim
