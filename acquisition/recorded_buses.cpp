#include "acquisition/recorded_buses.h"

#include <algorithm>

namespace annulus {
namespace {

using bus_record::CanFailed;
using bus_record::UsbRefused;
using std::chrono::nanoseconds;

/// In real time the replay's clock runs behind the recorded program by what that took for thinking: so much earlier may
/// a thing be had than it was, but never before it happened.
constexpr nanoseconds kThinking = std::chrono::milliseconds(1);

/// Whether something that happened at `happened` and was collected at `collected` can be had by a wait until
/// `deadline`; if so, the time passes until then.
bool Await(nanoseconds collected, nanoseconds happened, nanoseconds deadline, ManualClock& clock) {
  const nanoseconds latest = std::max(clock.Now(), deadline);
  if (std::max(happened, collected - kThinking) > latest) return false;
  clock.SleepUntil(std::min(collected, latest));
  return true;
}

}  // namespace

void RecordedUsbPort::Load(bus_record::UsbControl control) {
  controls_[{control.in, control.request.request}].push_back(std::move(control));
}

void RecordedUsbPort::Load(nanoseconds time, bus_record::UsbEnded ended) {
  events_.emplace_back(Ended{time, std::move(ended)});
}

void RecordedUsbPort::Load(UsbRefused refused) { events_.emplace_back(std::move(refused)); }

std::optional<bus_record::UsbControl> RecordedUsbPort::Answer(bool in, UsbRequest request) {
  const auto known = controls_.find({in, request.request});
  if (known == controls_.end() || known->second.empty()) return std::nullopt;
  bus_record::UsbControl answer = std::move(known->second.front());
  known->second.pop_front();
  clock_.SleepUntil(clock_.Now() + answer.took);
  return answer;
}

UsbResult<std::vector<std::byte>> RecordedUsbPort::ControlIn(UsbRequest request, std::size_t length,
                                                             nanoseconds timeout) {
  auto answer = Answer(true, request);
  if (!answer) {
    clock_.SleepUntil(clock_.Now() + timeout);
    return tl::unexpected<UsbFailure>(UsbFailure{UsbStatus::kTimedOut, "the recording holds no answer"});
  }
  if (answer->failure) return tl::unexpected<UsbFailure>(*answer->failure);
  answer->data.resize(std::min(answer->data.size(), length));
  return std::move(answer->data);
}

UsbResult<void> RecordedUsbPort::ControlOut(UsbRequest request, std::span<const std::byte>, nanoseconds) {
  const auto answer = Answer(false, request);
  if (answer && answer->failure) return tl::unexpected<UsbFailure>(*answer->failure);
  return {};
}

std::optional<UsbFailure> RecordedUsbPort::Refusal(UsbRefused::Call call, std::uint64_t number) {
  if (events_.empty()) return std::nullopt;
  const auto* refused = std::get_if<UsbRefused>(&events_.front());
  if (refused == nullptr || refused->call != call || number < refused->number) return std::nullopt;
  UsbFailure failure = refused->failure;
  events_.pop_front();
  return failure;
}

UsbResult<UsbToken> RecordedUsbPort::SubmitBulkIn(std::uint8_t, std::size_t) {
  if (auto failure = Refusal(UsbRefused::Call::kSubmit, submits_++)) {
    return tl::unexpected<UsbFailure>(std::move(*failure));
  }
  pending_.push_back({UsbToken{next_token_++}, false});
  return pending_.back().token;
}

void RecordedUsbPort::Cancel(UsbToken token) {
  for (Pending& one : pending_) one.cancelled = one.cancelled || one.token == token;
}

UsbResult<void> RecordedUsbPort::ClearHalt(std::uint8_t) {
  if (auto failure = Refusal(UsbRefused::Call::kClearHalt, clears_++)) {
    return tl::unexpected<UsbFailure>(std::move(*failure));
  }
  return {};
}

UsbCompletion RecordedUsbPort::Complete(const std::deque<Pending>::iterator& which, UsbStatus status) {
  UsbCompletion completion;
  completion.token = which->token;
  completion.status = status;
  completion.host_time = clock_.Now();
  pending_.erase(which);
  submits_ = clears_ = 0;
  return completion;
}

std::optional<UsbCompletion> RecordedUsbPort::WaitCompletion(nanoseconds deadline) {
  const auto ended = std::find_if(events_.begin(), events_.end(),
                                  [](const auto& event) { return std::holds_alternative<Ended>(event); });
  if (!pending_.empty() && ended != events_.end()) {
    auto& next = std::get<Ended>(*ended);
    if (Await(next.collected, next.ended.host_time, deadline, clock_)) {
      // Which one of the pending transfers it was does not matter: they are all alike.
      UsbCompletion completion = Complete(pending_.begin(), next.ended.status);
      completion.host_time = next.ended.host_time;
      completion.data = std::move(next.ended.data);
      // With it go the calls that failed before it and are not made now.
      events_.erase(events_.begin(), std::next(ended));
      return completion;
    }
  }
  const auto cancelled =
      std::find_if(pending_.begin(), pending_.end(), [](const Pending& one) { return one.cancelled; });
  if (cancelled != pending_.end()) return Complete(cancelled, UsbStatus::kCancelled);
  clock_.SleepUntil(deadline);
  return std::nullopt;
}

void RecordedCanBus::Load(nanoseconds time, bus_record::CanLinkRead link) {
  links_.emplace_back(time, std::move(link));
}

void RecordedCanBus::Load(nanoseconds time, bus_record::CanReceived received) { events_.push_back({time, received}); }

void RecordedCanBus::Load(nanoseconds time, CanFailed failed) {
  // The others happen only when the ring is opened again, which is not replayed.
  if (failed.call == CanFailed::Call::kSend || failed.call == CanFailed::Call::kReceive) {
    events_.push_back({time, std::move(failed)});
  }
}

void RecordedCanBus::Load(nanoseconds time, bus_record::CanOverflows overflows) {
  overflows_.emplace_back(time, overflows.count);
}

CanResult<CanLink> RecordedCanBus::ReadLink() {
  const bus_record::CanLinkRead* link = nullptr;
  for (const auto& [time, read] : links_) {
    if (link == nullptr || time <= clock_.Now()) link = &read;
  }
  if (link == nullptr) {
    return tl::unexpected<CanFailure>(CanFailure{CanFault::kError, "the recording does not tell how it is set up"});
  }
  if (link->failure) return tl::unexpected<CanFailure>(*link->failure);
  return link->link;
}

CanResult<void> RecordedCanBus::Send(const CanFrame&) {
  const std::uint64_t number = sends_++;
  if (events_.empty()) return {};
  const auto* failed = std::get_if<CanFailed>(&events_.front().what);
  if (failed == nullptr || failed->call != CanFailed::Call::kSend || number < failed->number) return {};
  CanFailure failure = failed->failure;
  events_.pop_front();
  return tl::unexpected<CanFailure>(std::move(failure));
}

CanResult<std::optional<CanReception>> RecordedCanBus::Receive(nanoseconds deadline) {
  const auto next = std::find_if(events_.begin(), events_.end(), [](const Event& event) {
    const auto* failed = std::get_if<CanFailed>(&event.what);
    return failed == nullptr || failed->call == CanFailed::Call::kReceive;
  });
  const auto* received = next == events_.end() ? nullptr : std::get_if<bus_record::CanReceived>(&next->what);
  const bool there =
      next != events_.end() &&
      Await(next->time, received != nullptr ? received->reception.host_time : next->time, deadline, clock_);
  if (there) {
    const Event event = std::move(*next);
    // With it go the sends that failed before it and are not made now.
    events_.erase(events_.begin(), std::next(next));
    sends_ = 0;
    if (const auto* failed = std::get_if<CanFailed>(&event.what)) {
      return tl::unexpected<CanFailure>(failed->failure);
    }
    return std::optional<CanReception>(std::get<bus_record::CanReceived>(event.what).reception);
  }
  clock_.SleepUntil(deadline);
  return std::optional<CanReception>();
}

std::uint64_t RecordedCanBus::overflows() const {
  std::uint64_t count = 0;
  for (const auto& [time, lost] : overflows_) {
    if (time <= clock_.Now()) count = lost;
  }
  return count;
}

}  // namespace annulus
