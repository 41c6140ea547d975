#include "sim/faulty_can_bus.h"

#include <algorithm>

#include "sim/world.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kLongestHold = std::chrono::milliseconds(2);

tl::unexpected<CanFailure> FailWith(CanFault fault) { return tl::unexpected<CanFailure>(CanFailure{fault, "by plan"}); }

}  // namespace

FaultyCanBus::FaultyCanBus(CanBus& bus, Clock& clock, CanFrameFaults faults) : bus_(bus), clock_(clock) {
  SetFrameFaults(faults);
}

void FaultyCanBus::SetFrameFaults(CanFrameFaults faults) {
  faults_ = faults;
  random_.seed(faults.seed);
}

void FaultyCanBus::RefuseSendsBetween(nanoseconds from, nanoseconds to, CanFault fault) {
  refusals_.push_back({from, to, fault});
}

void FaultyCanBus::BreakBetween(nanoseconds from, nanoseconds to, CanFault fault) { broken_ = Window{from, to, fault}; }

void FaultyCanBus::ReportAt(nanoseconds time, const CanReport& report) {
  scheduled_.emplace(time, CanReception{time, report});
}

void FaultyCanBus::FrameAt(nanoseconds time, const CanFrame& frame) {
  scheduled_.emplace(time, CanReception{time, frame});
}

void FaultyCanBus::FloodBetween(nanoseconds from, nanoseconds to, nanoseconds period, const CanFrame& frame) {
  floods_.push_back({from, to, period, frame});
}

void FaultyCanBus::ReportBetween(nanoseconds from, nanoseconds to, nanoseconds period, const CanReport& report) {
  floods_.push_back({from, to, period, report});
}

void FaultyCanBus::EndBy(nanoseconds time) {
  for (Window& refusal : refusals_) refusal.to = std::min(refusal.to, time);
  if (broken_) broken_->to = std::min(broken_->to, time);
  for (Flood& flood : floods_) flood.to = std::min(flood.to, time);
}

/// A broken interface answers nothing else until it is reopened.
std::optional<CanFault> FaultyCanBus::Broken() {
  if (!broken_ || clock_.Now() < broken_->from) return std::nullopt;
  return broken_->fault;
}

CanResult<CanLink> FaultyCanBus::ReadLink() {
  Tell();
  const auto fault = Broken();
  if (fault && broken_->Holds(clock_.Now()) && *fault == CanFault::kGone) return FailWith(*fault);
  auto link = bus_.ReadLink();
  if (link && fault && broken_->Holds(clock_.Now())) link->state = CanState::kDown;
  if (link && restart_ms_) link->restart_ms = restart_ms_;
  return link;
}

CanResult<void> FaultyCanBus::Send(const CanFrame& frame) {
  Tell();
  if (const auto fault = Broken()) return FailWith(*fault);
  for (const Window& refusal : refusals_) {
    if (!refusal.Holds(clock_.Now())) continue;
    ++log_.refused_sends;
    return FailWith(refusal.fault);
  }
  log_.sent.push_back(frame);
  return bus_.Send(frame);
}

CanResult<void> FaultyCanBus::Reopen() {
  Tell();
  if (broken_ && broken_->Holds(clock_.Now())) return FailWith(broken_->fault);
  if (broken_ && clock_.Now() >= broken_->to) broken_.reset();
  ++log_.reopened;
  held_.clear();
  ready_.clear();
  return bus_.Reopen();
}

CanResult<void> FaultyCanBus::Restart() {
  Tell();
  log_.restarts.push_back(clock_.Now());
  return bus_.Restart();
}

std::optional<nanoseconds> FaultyCanBus::NextScheduled() const {
  std::optional<nanoseconds> next;
  const auto consider = [&](nanoseconds time) { next = std::min(next.value_or(time), time); };
  if (!scheduled_.empty()) consider(scheduled_.begin()->first);
  for (const Flood& flood : floods_) {
    if (flood.next < flood.to) consider(flood.next);
  }
  if (broken_ && broken_->from > clock_.Now()) consider(broken_->from);
  for (const Held& held : held_) consider(held.latest);
  return next;
}

std::optional<CanReception> FaultyCanBus::TakeScheduled(nanoseconds now) {
  // In the order of time: a bus that nobody has read for a while has several waiting.
  const auto earliest = [](const Flood& a, const Flood& b) {
    return (a.next < a.to ? a.next : nanoseconds::max()) < (b.next < b.to ? b.next : nanoseconds::max());
  };
  const auto flood = std::min_element(floods_.begin(), floods_.end(), earliest);
  const bool floods = flood != floods_.end() && flood->next < flood->to && flood->next <= now;
  const bool one = !scheduled_.empty() && scheduled_.begin()->first <= now;
  if (one && (!floods || scheduled_.begin()->first <= flood->next)) {
    CanReception first = scheduled_.begin()->second;
    scheduled_.erase(scheduled_.begin());
    return first;
  }
  if (!floods) return std::nullopt;
  CanReception next{flood->next, flood->what};
  flood->next += flood->period;
  return next;
}

void FaultyCanBus::ReleaseHeld() {
  for (auto held = held_.begin(); held != held_.end();) {
    if (held->frames_to_pass > 0 && held->latest > clock_.Now()) {
      ++held;
      continue;
    }
    ready_.push_back(held->reception);
    held = held_.erase(held);
  }
}

void FaultyCanBus::Pass(const CanReception& reception) {
  if (overflowing_ > 0) {
    --overflowing_;
    ++log_.overflowed;
    return;
  }
  if (lose_next_of_ && std::get<CanFrame>(reception.what).id == *lose_next_of_) {
    lose_next_of_.reset();
    ++log_.lost;
    return;
  }
  const auto happens = [&](double share) { return UnitFromBits(random_()) < share; };
  const auto distance = [&] { return 1 + random_() % std::max<std::size_t>(faults_.displace_by, 1); };
  for (Held& held : held_) {
    if (held.frames_to_pass > 0) --held.frames_to_pass;
  }
  if (happens(faults_.lose)) {
    ++log_.lost;
  } else if (happens(faults_.displace)) {
    ++log_.displaced;
    held_.push_back({distance(), clock_.Now() + kLongestHold, reception});
  } else {
    if (happens(faults_.repeat)) {
      ++log_.repeated;
      held_.push_back({distance(), clock_.Now() + kLongestHold, reception});
    }
    ready_.push_back(reception);
  }
  ReleaseHeld();
}

CanResult<std::optional<CanReception>> FaultyCanBus::Receive(nanoseconds deadline) {
  Tell();
  while (true) {
    if (const auto fault = Broken()) return FailWith(*fault);
    ReleaseHeld();
    if (!ready_.empty()) {
      std::optional<CanReception> first(ready_.front());
      ready_.pop_front();
      return first;
    }
    if (auto due = TakeScheduled(clock_.Now())) return due;
    const auto scheduled = NextScheduled();
    const nanoseconds until = scheduled ? std::min(*scheduled, deadline) : deadline;
    auto received = bus_.Receive(until);
    if (!received) return received;
    if (*received) {
      if (std::holds_alternative<CanReport>((*received)->what)) return received;
      Pass(**received);
    } else if (clock_.Now() >= deadline && ready_.empty()) {
      return received;
    }
  }
}

}  // namespace annulus::sim
