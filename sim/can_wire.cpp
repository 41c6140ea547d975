#include "sim/can_wire.h"

#include <algorithm>
#include <utility>

#include "base/ensure.h"

namespace annulus::sim {

using std::chrono::nanoseconds;

namespace {

constexpr int kErrorFrameBits = 23;      ///< Error flag, its echo, delimiter, interframe space: about.
constexpr int kRecoveryBits = 128 * 11;  ///< Recessive bits that end bus-off.
constexpr int kPassiveLimit = 127;
constexpr int kWarningLimit = 95;
constexpr int kBusOffLimit = 255;

/// The lower wins the bus: the bits of the arbitration field in the order of sending.
std::uint64_t ArbitrationOf(const CanFrame& frame) {
  const std::uint64_t base = frame.extended ? frame.id >> 18 : frame.id;
  const std::uint64_t rest = frame.extended ? (std::uint64_t{1} << 20 | (frame.id & 0x3FFFFU) << 1) : 0;
  return base << 24 | rest << 1 | (frame.remote ? 1U : 0U);
}

tl::unexpected<CanFailure> FailWith(CanFault fault, std::string detail) {
  return tl::unexpected<CanFailure>(CanFailure{fault, std::move(detail)});
}

}  // namespace

/// One controller on the bus, a board's or a host's.
struct CanWire::Contender {
  CanStation* station = nullptr;
  Port* port = nullptr;
  std::deque<CanFrame> queue;
  int transmit_errors = 0;
  int receive_errors = 0;
  CanState state = CanState::kErrorActive;
  std::optional<nanoseconds> back_at;  ///< Bus-off: joins again then.
  bool told_no_acknowledge = false;

  [[nodiscard]] bool off() const { return state == CanState::kBusOff; }
};

/// A host's controller and its queues.
class CanWire::Port final : public CanBus {
 public:
  Port(CanWire& wire, Contender& contender, std::string name)
      : wire_(wire), contender_(contender), name_(std::move(name)) {}

  CanResult<CanLink> ReadLink() override {
    wire_.Advance();
    CanLink link;
    link.name = name_;
    link.state = contender_.state;
    link.fd = wire_.options_.fd;
    link.bit_rate = wire_.options_.bit_rates.nominal;
    if (link.fd) link.data_bit_rate = wire_.options_.bit_rates.data;
    link.restart_ms = wire_.options_.restart_ms;
    link.queue_length = static_cast<std::uint32_t>(wire_.options_.queue_length);
    return link;
  }
  CanResult<void> Send(const CanFrame& frame) override {
    ENSURE(frame.id <= (frame.extended ? 0x1FFFFFFFU : 0x7FFU), "the identifier fits its kind");
    ENSURE(frame.fd ? IsCanFdSize(frame.size) && !frame.remote : frame.size <= 8, "CAN has such a frame");
    if (frame.fd && !wire_.options_.fd) return FailWith(CanFault::kError, "the interface takes no FD frames");
    wire_.Advance();
    if (contender_.off() || contender_.queue.size() >= wire_.options_.queue_length) {
      return FailWith(CanFault::kQueueFull, "no buffer space available");
    }
    contender_.queue.push_back(frame);
    wire_.Advance();
    return {};
  }
  CanResult<std::optional<CanReception>> Receive(nanoseconds deadline) override {
    while (true) {
      wire_.Advance();
      if (!received_.empty()) {
        std::optional<CanReception> first(received_.front());
        received_.pop_front();
        return first;
      }
      if (wire_.clock_.Now() >= deadline) return std::optional<CanReception>();
      const auto next = wire_.NextEvent();
      wire_.clock_.SleepUntil(next ? std::min(*next, deadline) : deadline);
    }
  }
  [[nodiscard]] std::uint64_t overflows() const override { return overflows_; }
  CanResult<void> Reopen() override {
    wire_.Advance();
    received_.clear();
    return {};
  }
  CanResult<void> Restart() override {
    wire_.Advance();
    if (contender_.off() && !contender_.back_at) contender_.back_at = wire_.time_ + wire_.BitTime(kRecoveryBits);
    return {};
  }

  void Take(nanoseconds time, const std::variant<CanFrame, CanReport>& what) {
    if (drop_ > 0 && std::holds_alternative<CanFrame>(what)) {
      --drop_;
      ++overflows_;
    } else if (received_.size() >= wire_.options_.receive_frames) {
      ++overflows_;
    } else {
      received_.push_back({time, what});
    }
  }
  void Drop(std::size_t frames) { drop_ += frames; }

 private:
  CanWire& wire_;
  Contender& contender_;
  std::string name_;
  std::deque<CanReception> received_;
  std::uint64_t overflows_ = 0;
  std::size_t drop_ = 0;
};

CanWire::CanWire(CanWireOptions options, Clock& clock)
    : options_(options), clock_(clock), time_(clock.Now()), idle_from_(clock.Now()) {}

CanWire::~CanWire() = default;

void CanWire::Attach(CanStation& station) {
  auto contender = std::make_unique<Contender>();
  contender->station = &station;
  contenders_.push_back(std::move(contender));
}

CanBus& CanWire::Connect(std::string name) {
  auto contender = std::make_unique<Contender>();
  ports_.push_back(std::make_unique<Port>(*this, *contender, std::move(name)));
  contender->port = ports_.back().get();
  contenders_.push_back(std::move(contender));
  return *ports_.back();
}

void CanWire::DropAtReceiver(CanBus& host, std::size_t frames) {
  for (const auto& port : ports_) {
    if (port.get() == &host) port->Drop(frames);
  }
}

nanoseconds CanWire::BitTime(int bits) const {
  return nanoseconds(std::int64_t{bits} * 1'000'000'000 / options_.bit_rates.nominal);
}

std::optional<nanoseconds> CanWire::NextEvent() const {
  std::optional<nanoseconds> next;
  const auto consider = [&](nanoseconds time) {
    const nanoseconds not_past = std::max(time, time_);
    next = std::min(next.value_or(not_past), not_past);
  };
  if (flight_) consider(flight_->end);
  for (const auto& contender : contenders_) {
    if (contender->station != nullptr) {
      if (const auto wanted = contender->station->NextTime()) consider(*wanted);
    }
    if (contender->back_at) consider(*contender->back_at);
    if (!flight_ && !contender->queue.empty() && !contender->off()) consider(idle_from_);
  }
  return next;
}

void CanWire::Advance() {
  const nanoseconds now = clock_.Now();
  while (true) {
    const auto next = NextEvent();
    if (!next || *next > now) break;
    time_ = *next;
    Process(time_);
  }
  time_ = std::max(time_, now);
}

void CanWire::Process(nanoseconds time) {
  if (flight_ && flight_->end <= time) EndTransmission();
  for (const auto& contender : contenders_) {
    if (contender->back_at && *contender->back_at <= time) Recover(*contender);
    if (contender->station == nullptr) continue;
    const auto wanted = contender->station->NextTime();
    if (wanted && *wanted <= time) contender->station->Act(time);
    Poll(*contender);
  }
  if (!flight_ && idle_from_ <= time) StartTransmission(time);
}

void CanWire::Poll(Contender& contender) {
  for (CanFrame& frame : contender.station->TakeFrames()) {
    if (!contender.off()) contender.queue.push_back(frame);
  }
}

void CanWire::StartTransmission(nanoseconds time) {
  std::uint64_t best = ~std::uint64_t{0};
  for (const auto& contender : contenders_) {
    if (!contender->queue.empty() && !contender->off()) best = std::min(best, ArbitrationOf(contender->queue.front()));
  }
  Flight flight;
  std::size_t listeners = 0;
  for (const auto& contender : contenders_) {
    if (contender->off()) continue;
    if (contender->queue.empty() || ArbitrationOf(contender->queue.front()) != best) {
      ++listeners;
      continue;
    }
    // Equal to the last bit, two frames are one on the bus; else the first differing bit is an error.
    if (!flight.senders.empty() && !(flight.frame == contender->queue.front())) flight.collision = true;
    if (flight.senders.empty()) flight.frame = contender->queue.front();
    flight.senders.push_back(contender.get());
  }
  if (flight.senders.empty()) return;
  flight.acknowledged = listeners > 0 || flight.senders.size() > 1;
  flight.start = time;
  flight.end = time + LongestFrameTime(flight.frame, options_.bit_rates);
  const bool disturbed = flight.start < disturbed_to_ && flight.end > disturbed_from_;
  if (disturbed) flight.collision = true;
  if (flight.collision || !flight.acknowledged) flight.end += BitTime(kErrorFrameBits);
  flight_ = std::move(flight);
}

void CanWire::EndTransmission() {
  const Flight flight = std::move(*flight_);
  flight_.reset();
  idle_from_ = flight.end;
  traffic_.busy += flight.end - flight.start;
  if (flight.collision || !flight.acknowledged) {
    ++traffic_.errors;
    for (Contender* sender : flight.senders) {
      // A controller that is alone becomes passive, but never bus-off for want of an acknowledgement.
      const bool alone = !flight.collision && sender->transmit_errors > kPassiveLimit;
      if (!flight.collision && sender->port != nullptr && !std::exchange(sender->told_no_acknowledge, true)) {
        CanReport report;
        report.no_acknowledge = true;
        sender->port->Take(time_, report);
      }
      Fail(*sender, alone ? 0 : 8);
    }
    return;
  }
  ++traffic_.frames;
  for (Contender* sender : flight.senders) {
    if (!sender->queue.empty()) sender->queue.pop_front();
    sender->told_no_acknowledge = false;
    sender->transmit_errors = std::max(0, sender->transmit_errors - 1);
    UpdateState(*sender);
    if (sender->station != nullptr) sender->station->OnSent(flight.frame, time_);
  }
  Deliver(flight);
}

void CanWire::Deliver(const Flight& flight) {
  for (const auto& contender : contenders_) {
    if (contender->off()) continue;
    if (std::find(flight.senders.begin(), flight.senders.end(), contender.get()) != flight.senders.end()) continue;
    contender->receive_errors = std::max(0, contender->receive_errors - 1);
    UpdateState(*contender);
    if (contender->station != nullptr) contender->station->OnFrame(flight.frame, time_);
    if (contender->port != nullptr) contender->port->Take(time_, flight.frame);
  }
}

void CanWire::Fail(Contender& contender, int transmit_errors) {
  contender.transmit_errors += transmit_errors;
  UpdateState(contender);
}

void CanWire::UpdateState(Contender& contender) {
  const int worst = std::max(contender.transmit_errors, contender.receive_errors);
  CanState state = CanState::kErrorActive;
  if (worst > kWarningLimit) state = CanState::kErrorWarning;
  if (worst > kPassiveLimit) state = CanState::kErrorPassive;
  if (contender.transmit_errors > kBusOffLimit) state = CanState::kBusOff;
  if (state == contender.state) return;
  contender.state = state;
  if (state == CanState::kBusOff) {
    contender.queue.clear();
    contender.back_at.reset();
    // A board's firmware joins again at once; a host's controller as it is set up.
    if (contender.station != nullptr) contender.back_at = time_ + BitTime(kRecoveryBits);
    if (contender.port != nullptr && options_.restart_ms > 0) {
      contender.back_at = time_ + std::chrono::milliseconds(options_.restart_ms);
    }
  }
  if (contender.station != nullptr) contender.station->OnState(state, time_);
  if (contender.port == nullptr) return;
  CanReport report;
  report.state = state;
  report.transmit_errors = static_cast<std::uint8_t>(std::min(contender.transmit_errors, 255));
  report.receive_errors = static_cast<std::uint8_t>(std::min(contender.receive_errors, 255));
  contender.port->Take(time_, report);
}

void CanWire::Recover(Contender& contender) {
  contender.back_at.reset();
  contender.transmit_errors = 0;
  contender.receive_errors = 0;
  contender.state = CanState::kErrorActive;
  if (contender.station != nullptr) contender.station->OnState(CanState::kErrorActive, time_);
  if (contender.port == nullptr) return;
  CanReport report;
  report.state = CanState::kErrorActive;
  report.restarted = true;
  contender.port->Take(time_, report);
}

}  // namespace annulus::sim
