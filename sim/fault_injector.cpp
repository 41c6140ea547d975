#include "sim/fault_injector.h"

#include <cmath>
#include <cstdio>
#include <utility>

namespace annulus::sim {

using std::chrono::nanoseconds;

/// Another clock's time, with the host's own idea of the wall clock.
class FaultInjector::WallClock final : public Clock {
 public:
  WallClock(Clock& clock, const nanoseconds& offset) : clock_(clock), offset_(offset) {}
  [[nodiscard]] nanoseconds Now() const override { return clock_.Now(); }
  [[nodiscard]] nanoseconds WallNow() const override { return clock_.WallNow() + offset_; }
  void SleepUntil(nanoseconds deadline) override { clock_.SleepUntil(deadline); }

 private:
  Clock& clock_;
  const nanoseconds& offset_;
};

FaultGround FaultInjector::GroundFor(BoothDevices& booth) {
  return {booth, clock_, plan_.seed, [this](const FaultCall& call) {
            schedule_.NoteCall(call, clock_.Now());
            Poll();
          }};
}

FaultInjector::FaultInjector(FaultPlan plan, BoothDevices& booth, Clock& clock, Options options)
    : plan_(std::move(plan)),
      clock_(clock),
      schedule_(plan_, clock.Now()),
      usb_(GroundFor(booth)),
      can_(GroundFor(booth), plan_),
      link_(GroundFor(booth), options.numbering),
      gpio_(GroundFor(booth)),
      model_(GroundFor(booth)),
      storage_(GroundFor(booth), plan_) {
  // What is so from the beginning is so before anything is opened.
  Poll();
}

FaultInjector::~FaultInjector() = default;

Storage& FaultInjector::WrapStorage(Storage& storage) {
  disks_.push_back(std::make_unique<FaultyStorage>(storage, storage_));
  return *disks_.back();
}

Clock& FaultInjector::WrapClock(Clock& clock) {
  wall_clocks_.push_back(std::make_unique<WallClock>(clock, wall_offset_));
  return *wall_clocks_.back();
}

void FaultInjector::NoteState(const std::string& state) {
  Poll();
  schedule_.NoteState(state, clock_.Now());
  Poll();
}

void FaultInjector::NoteLevel(std::uint64_t number) {
  schedule_.NoteLevel(number, clock_.Now());
  Poll();
}

void FaultInjector::Poll() {
  // What is done may take its time, in which others ask.
  if (polling_) return;
  polling_ = true;
  for (const std::size_t begun : storage_.TakeBegun()) schedule_.NoteBegun(begun, clock_.Now());
  for (const FaultSchedule::Step& step : schedule_.Take(clock_.Now())) Carry(step);
  usb_.Follow();
  storage_.Follow();
  polling_ = false;
}

void FaultInjector::Disarm() {
  Poll();
  for (const std::size_t fault : schedule_.Disarm()) {
    if (FaultActor* actor = ActorOf(TraitsOf(plan_.faults[fault].kind).target); actor == &storage_) {
      storage_.End(fault, plan_.faults[fault], clock_.Now());
    }
  }
}

FaultActor* FaultInjector::ActorOf(FaultTarget target) {
  switch (target) {
    case FaultTarget::kUsb:
      return &usb_;
    case FaultTarget::kCan:
      return &can_;
    case FaultTarget::kAxisLink:
      return &link_;
    case FaultTarget::kGpio:
      return &gpio_;
    case FaultTarget::kStorage:
      return &storage_;
    case FaultTarget::kAxis:
    case FaultTarget::kSensors:
    case FaultTarget::kChain:
      return &model_;
    case FaultTarget::kHost:
      return nullptr;
  }
  return nullptr;
}

void FaultInjector::Carry(const FaultSchedule::Step& step) {
  const Fault& fault = plan_.faults.at(step.fault);
  FaultActor* actor = ActorOf(TraitsOf(fault.kind).target);
  if (actor == nullptr) return CarryOnHost(step, fault);
  if (step.begins) {
    actor->Begin(step.fault, fault, step.time, step.to);
  } else {
    actor->End(step.fault, fault, step.time);
  }
}

void FaultInjector::CarryOnHost(const FaultSchedule::Step& step, const Fault& fault) {
  if (!step.begins) return on_host_.Remove(step.fault);
  if (fault.kind == FaultKind::kHostKill) {
    killed_ = true;
  } else if (fault.kind == FaultKind::kHostWallJump) {
    wall_offset_ += nanoseconds(std::llround(1e9 * fault.Value(FaultArg::kJumpS)));
  } else {
    on_host_.Add(step.fault, fault, step.time, step.to);
  }
}

HostCondition FaultInjector::host() {
  schedule_.NoteCall({FaultTarget::kHost, FaultCall::kAnywhere, false}, clock_.Now());
  Poll();
  HostCondition condition;
  condition.killed = killed_;
  condition.wall_offset = wall_offset_;
  for (HoldingFaults::Holding& holding : on_host_.all()) {
    switch (holding.fault.kind) {
      case FaultKind::kHostHang:
        condition.hangs = true;
        break;
      case FaultKind::kHostLateTicks:
        if (holding.left == 0) break;
        --holding.left;
        condition.late = nanoseconds(std::llround(1e6 * holding.fault.Value(FaultArg::kDelayMs)));
        break;
      case FaultKind::kHostThreadDead:
        condition.dead.at(holding.fault.Whole(FaultArg::kThread)) = true;
        break;
      case FaultKind::kHostHot:
        condition.hot = true;
        break;
      default:
        break;
    }
  }
  return condition;
}

std::string FaultInjector::LogText() const {
  std::string text;
  for (const FaultEvent& event : log()) {
    char time[32];
    std::snprintf(time, sizeof(time), "%.9f", static_cast<double>(event.time.count()) * 1e-9);
    text += std::string(time) + (event.begins ? " begins " : " ends ") + std::to_string(event.fault) + ": " +
            event.text + "\n";
  }
  return text;
}

}  // namespace annulus::sim
