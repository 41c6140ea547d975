#include "sim/safety_chain.h"

#include <algorithm>
#include <deque>
#include <utility>

#include "base/ensure.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

using In = InterlockInput;
using Out = InterlockOutput;

/// What the kernel keeps for each line.
constexpr std::size_t kFifo = 16;
constexpr nanoseconds kResetPress = std::chrono::milliseconds(150);
constexpr std::array<Out, 3> kLamps = {Out::kLampReady, Out::kLampRunning, Out::kLampFault};

constexpr std::size_t Index(In input) { return static_cast<std::size_t>(input); }
constexpr std::size_t Index(Out output) { return static_cast<std::size_t>(output); }

tl::unexpected<GpioFailure> Gone() {
  return tl::unexpected<GpioFailure>(GpioFailure{GpioFault::kGone, "the simulated chip is unplugged"});
}

}  // namespace

/// One request of lines: the logical side of the pins, and a FIFO of edges for each.
class SafetyChain::Lines final : public GpioLines {
 public:
  struct Wired {
    GpioLineSpec spec;
    std::optional<In> input;
    std::optional<Out> output;
    bool level = false;  ///< As last seen, logical.
    std::deque<GpioEdge> fifo;
  };

  Lines(SafetyChain& chain, std::vector<Wired> lines) : chain_(chain), lines_(std::move(lines)) {
    chain_.requests_.push_back(this);
    for (Wired& line : lines_) {
      if (line.output) chain_.WritePin(*line.output, line.spec.initial != line.spec.active_low);
      if (line.input) line.level = LevelOf(line);
    }
  }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;
  ~Lines() override {
    for (const Wired& line : lines_) {
      chain_.consumer_.erase(line.spec.name);
      if (line.output && !chain_.options_.hold_on_release) chain_.WritePin(*line.output, false);
    }
    std::erase(chain_.requests_, this);
  }

  [[nodiscard]] std::size_t count() const override { return lines_.size(); }

  GpioResult<std::vector<bool>> Read() override {
    chain_.Advance();
    if (chain_.removed_) return Gone();
    std::vector<bool> levels;
    for (const Wired& line : lines_) levels.push_back(LevelOf(line));
    return levels;
  }

  GpioResult<void> Write(std::size_t line, bool level) override {
    ENSURE(line < lines_.size() && lines_[line].output.has_value(), "only outputs can be set");
    chain_.Advance();
    if (chain_.removed_) return Gone();
    chain_.WritePin(*lines_[line].output, level != lines_[line].spec.active_low);
    return {};
  }

  GpioResult<std::optional<GpioEdge>> WaitEdge(nanoseconds deadline) override {
    while (true) {
      chain_.Advance();
      if (chain_.removed_) return Gone();
      if (auto edge = TakeFirst()) return edge;
      const nanoseconds now = chain_.clock_.Now();
      if (now >= deadline) return std::nullopt;
      const auto next = chain_.NextEvent();
      chain_.clock_.SleepUntil(next ? std::max(now, std::min(*next, deadline)) : deadline);
    }
  }

  /// The hardware has changed at `time`: edges of the inputs. A full FIFO loses what comes.
  void Follow(nanoseconds time) {
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      Wired& line = lines_[i];
      const bool level = LevelOf(line);
      if (!line.input || level == line.level) continue;
      line.level = level;
      if (!line.spec.edges) continue;
      if (line.fifo.size() < kFifo) line.fifo.push_back({i, level, time, false});
    }
  }

 private:
  [[nodiscard]] bool LevelOf(const Wired& line) const {
    const bool pin = line.input ? chain_.PinOf(*line.input) : chain_.Output(*line.output);
    return pin != line.spec.active_low;
  }

  std::optional<GpioEdge> TakeFirst() {
    Collect();
    if (edges_.empty()) return std::nullopt;
    const GpioEdge edge = edges_.front();
    edges_.pop_front();
    return edge;
  }

  /// Empties the FIFOs in the order of time. After a full one, which may have lost edges, the line's level is said.
  void Collect() {
    const auto first_new = static_cast<std::ptrdiff_t>(edges_.size());
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      Wired& line = lines_[i];
      const bool full = line.fifo.size() == kFifo;
      edges_.insert(edges_.end(), line.fifo.begin(), line.fifo.end());
      line.fifo.clear();
      if (full) edges_.push_back({i, line.level, chain_.clock_.Now(), true});
    }
    std::stable_sort(edges_.begin() + first_new, edges_.end(),
                     [](const GpioEdge& a, const GpioEdge& b) { return a.host_time < b.host_time; });
  }

  SafetyChain& chain_;
  std::vector<Wired> lines_;
  std::deque<GpioEdge> edges_;  ///< Collected.
};

SafetyChain::SafetyChain(SafetyChainOptions options, Clock& clock)
    : options_(std::move(options)),
      clock_(clock),
      now_(clock.Now()),
      k1_(options_.pull_in, options_.drop_out),
      watchdog_(options_.kick_shortest, options_.kick_longest),
      k2_(options_.pull_in, options_.drop_out),
      k3_instant_(options_.pull_in, options_.drop_out),
      sto_a_(options_.pull_in, options_.drop_out + options_.stop_delay),
      sto_b_(options_.pull_in, options_.drop_out + options_.stop_delay),
      brake_(options_.brake_release, options_.brake_apply),
      lamp_current_(options_.lamp_current, options_.lamp_current) {
  for (const In closed : {In::kEstopA, In::kEstopB, In::kDoor, In::kUpperLimit, In::kLowerLimit}) {
    contact_[Index(closed)] = true;
  }
  for (std::size_t i = 0; i < kInterlockInputs; ++i) {
    const std::string name = InterlockName(static_cast<In>(i));
    name_of_[name] = name;
  }
  for (std::size_t i = 0; i < kInterlockOutputs; ++i) {
    const std::string name = InterlockName(static_cast<Out>(i));
    name_of_[name] = name;
  }
}

SafetyChain::~SafetyChain() = default;

// --- the GPIO chip ------------------------------------------------------------------------------------------------

std::vector<GpioChipInfo> SafetyChain::Chips() const {
  if (removed_) return {};
  GpioChipInfo info;
  info.name = "gpiochip0";
  info.label = options_.chip;
  info.path = "/dev/gpiochip0";
  const auto add = [&](const char* original) {
    const std::string& name = name_of_.at(original);
    const auto user = consumer_.find(name);
    info.lines.push_back({name, user != consumer_.end(), user != consumer_.end() ? user->second : std::string()});
  };
  for (std::size_t i = 0; i < kInterlockInputs; ++i) add(InterlockName(static_cast<In>(i)));
  for (std::size_t i = 0; i < kInterlockOutputs; ++i) add(InterlockName(static_cast<Out>(i)));
  return {info};
}

Result<std::unique_ptr<GpioLines>> SafetyChain::Request(const std::string& chip,
                                                        const std::vector<GpioLineSpec>& lines) {
  Advance();
  const auto places = FindGpioLines(Chips(), chip, lines);
  if (!places) return Fail(places);
  std::vector<Lines::Wired> wired;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::size_t offset = (*places)[i].offset;
    const bool is_input = offset < kInterlockInputs;
    if (is_input != (lines[i].direction == GpioDirection::kInput)) {
      return Fail("request line '" + lines[i].name + "'", "what is wired to it has the other direction",
                  "correct the wiring");
    }
    Lines::Wired line;
    line.spec = lines[i];
    if (is_input) line.input = static_cast<In>(offset);
    if (!is_input) line.output = static_cast<Out>(offset - kInterlockInputs);
    wired.push_back(std::move(line));
  }
  for (const GpioLineSpec& line : lines) consumer_[line.name] = "annulus";
  return std::make_unique<Lines>(*this, std::move(wired));
}

bool SafetyChain::Output(Out output) const {
  if (const auto shorted = shorted_.find(output); shorted != shorted_.end()) return shorted->second;
  return !removed_ && pin_.at(Index(output));
}

bool SafetyChain::Pin(Out output) {
  Advance();
  return Output(output);
}

void SafetyChain::WritePin(Out output, bool level) {
  Advance();
  pin_.at(Index(output)) = level;
  Settle(now_);
}

bool SafetyChain::PinOf(In input) const {
  if (broken_.at(Index(input))) return false;
  switch (input) {
    case In::kEnableFeedback:  // Both contacts closed at rest, in series.
      return !sto_a_.closed() && !sto_b_.closed();
    case In::kBrakeFeedback:
      return !brake_.closed();
    case In::kWatchdogFeedback:
      return k2_.closed();
    case In::kLampFeedback:
      return lamp_current_.closed();
    default:
      return Contact(input);
  }
}

// --- people and damage --------------------------------------------------------------------------------------------

void SafetyChain::Set(In contact, bool closed) { SetAt(clock_.Now(), contact, closed); }

void SafetyChain::SetAt(nanoseconds time, In contact, bool closed) {
  ENSURE(contact < In::kEnableFeedback, "feedbacks follow the relays");
  Advance();
  planned_.emplace(std::max(time, now_), [this, contact, closed] { ApplyContact(contact, closed); });
  Advance();
}

void SafetyChain::ApplyContact(In contact, bool closed) { contact_.at(Index(contact)) = closed; }

void SafetyChain::PressEstopAt(nanoseconds time) {
  SetAt(time, In::kEstopA, false);
  SetAt(time, In::kEstopB, false);
}

void SafetyChain::ReleaseEstopAt(nanoseconds time) {
  SetAt(time, In::kEstopA, true);
  SetAt(time, In::kEstopB, true);
}

void SafetyChain::PressResetAt(nanoseconds time) {
  SetAt(time, In::kReset, true);
  SetAt(time + kResetPress, In::kReset, false);
}

void SafetyChain::SetDriveReleasesBrake(bool release) {
  Advance();
  drive_releases_brake_ = release;
  Settle(now_);
}

void SafetyChain::Wire(WiredDrive& drive) {
  Advance();
  drive_ = &drive;
  Settle(now_);
}

void SafetyChain::DriveChanged() {
  Advance();
  Settle(now_);
}

void SafetyChain::BreakWire(In input) {
  Advance();
  broken_.at(Index(input)) = true;
  Settle(now_);
}

void SafetyChain::MendWire(In input) {
  Advance();
  broken_.at(Index(input)) = false;
  Settle(now_);
}

void SafetyChain::WeldStoA() {
  Advance();
  sto_a_.Weld();
}

void SafetyChain::WeldWatchdog() {
  Advance();
  k2_.Weld();
}

void SafetyChain::JamBrake() {
  Advance();
  brake_jammed_ = true;
}

void SafetyChain::BurnOut(Out lamp) {
  Advance();
  burnt_out_.insert(lamp);
  Settle(now_);
}

void SafetyChain::CutWatchdogWire() {
  Advance();
  watchdog_wire_cut_ = true;
}

void SafetyChain::HoldOutput(Out output, std::optional<bool> level) {
  Advance();
  shorted_.erase(output);
  if (level) shorted_[output] = *level;
  Settle(now_);
}

void SafetyChain::RemoveChip() {
  Advance();
  removed_ = true;
  Settle(now_);
}

void SafetyChain::Occupy(const std::string& line, const std::string& consumer) { consumer_[line] = consumer; }

void SafetyChain::Rename(const std::string& line, const std::string& name) { name_of_.at(line) = name; }

// --- the relays ---------------------------------------------------------------------------------------------------

std::optional<nanoseconds> SafetyChain::NextEvent() const {
  std::optional<nanoseconds> next;
  const auto consider = [&next](std::optional<nanoseconds> time) {
    if (time && (!next || *time < *next)) next = time;
  };
  if (!planned_.empty()) consider(planned_.begin()->first);
  consider(watchdog_.next());
  if (drive_ != nullptr) consider(drive_->NextChange());
  for (const TimedContact* contact : {&k1_, &k2_, &k3_instant_, &sto_a_, &sto_b_, &lamp_current_}) {
    consider(contact->next());
  }
  if (!brake_jammed_) consider(brake_.next());
  return next;
}

void SafetyChain::Advance() { AdvanceTo(clock_.Now()); }

void SafetyChain::AdvanceTo(nanoseconds time) {
  while (true) {
    const auto next = NextEvent();
    if (!next || *next > time) break;
    now_ = std::max(now_, *next);
    // One plan at a time: two changes at one time are two edges.
    if (!planned_.empty() && planned_.begin()->first <= now_) {
      const auto act = std::move(planned_.begin()->second);
      planned_.erase(planned_.begin());
      act();
    }
    watchdog_.Advance(now_);
    for (TimedContact* contact : {&k1_, &k2_, &k3_instant_, &sto_a_, &sto_b_, &lamp_current_}) contact->Advance(now_);
    if (!brake_jammed_) brake_.Advance(now_);
    Settle(now_);
  }
  now_ = std::max(now_, time);
}

bool SafetyChain::LoopClosed() const {
  return Contact(In::kEstopA) && Contact(In::kEstopB) && Contact(In::kDoor) && Contact(In::kUpperLimit) &&
         Contact(In::kLowerLimit);
}

void SafetyChain::Settle(nanoseconds time) {
  SettleSafetyRelay(time);
  SettleRelays(time);
  const bool closed = LoopClosed();
  const bool was_closed = open_.empty() || open_.back().to.has_value();
  if (!closed && was_closed) open_.push_back({time, std::nullopt});
  if (closed && !was_closed) open_.back().to = time;
  LogChanges(time);
  for (Lines* lines : requests_) lines->Follow(time);
}

void SafetyChain::SettleSafetyRelay(nanoseconds time) {
  if (!LoopClosed()) {
    if (k1_on_) a_opened_ = b_opened_ = false;
    k1_on_ = false;
  }
  // Door and limits are in both channels.
  const bool both = !Contact(In::kDoor) || !Contact(In::kUpperLimit) || !Contact(In::kLowerLimit);
  a_opened_ = a_opened_ || both || !Contact(In::kEstopA);
  b_opened_ = b_opened_ || both || !Contact(In::kEstopB);
  const bool pressed = Contact(In::kReset) && !reset_before_;
  reset_before_ = Contact(In::kReset);
  const bool dropped = !sto_a_.closed() && !sto_b_.closed();
  if (pressed && LoopClosed() && a_opened_ && b_opened_ && dropped) k1_on_ = true;
  k1_.Drive(k1_on_, time);
}

void SafetyChain::SettleRelays(nanoseconds time) {
  const bool kick = Output(Out::kWatchdog) && !watchdog_wire_cut_;
  if (kick && !kick_before_) watchdog_.RisingEdge(time);
  kick_before_ = kick;
  k2_.Drive(watchdog_.on(), time);

  const bool enable = Output(Out::kEnable);
  const bool rising = enable && !enable_before_;
  enable_before_ = enable;
  const bool supplied = k1_.closed() && k2_.closed() && enable;
  const bool dropped = !sto_a_.closed() && !sto_b_.closed();
  k3_on_ = supplied && (k3_on_ || (rising && dropped));
  for (TimedContact* contact : {&k3_instant_, &sto_a_, &sto_b_}) contact->Drive(k3_on_, time);

  if (drive_ != nullptr) {
    drive_releases_brake_ = drive_->Follow(
        time, {SignalNow(ChainSignal::kQuickStopInput), sto_a_.closed(), sto_b_.closed(), brake_.closed()});
  }
  brake_.Drive(sto_a_.closed() && sto_b_.closed() && drive_releases_brake_, time);
  lamp_current_.Drive(std::any_of(kLamps.begin(), kLamps.end(),
                                  [this](Out lamp) { return Output(lamp) && !burnt_out_.contains(lamp); }),
                      time);
}

bool SafetyChain::SignalNow(ChainSignal signal) const {
  const auto lit = [this](Out lamp) { return Output(lamp) && !burnt_out_.contains(lamp); };
  switch (signal) {
    case ChainSignal::kSafetyRelay:
      return k1_.closed();
    case ChainSignal::kWatchdogRelay:
      return k2_.closed();
    case ChainSignal::kQuickStopInput:
      return k3_instant_.closed() && Output(Out::kQuickStop);
    case ChainSignal::kStoA:
      return sto_a_.closed();
    case ChainSignal::kStoB:
      return sto_b_.closed();
    case ChainSignal::kBrakeReleased:
      return brake_.closed();
    case ChainSignal::kEmitterSupply:
      return k1_.closed() && Output(Out::kEmitters);
    case ChainSignal::kLampReady:
      return lit(Out::kLampReady);
    case ChainSignal::kLampRunning:
      return lit(Out::kLampRunning);
    case ChainSignal::kLampFault:
      return lit(Out::kLampFault);
  }
  return false;
}

void SafetyChain::LogChanges(nanoseconds time) {
  for (std::size_t i = 0; i < kChainSignals; ++i) {
    const ChainSignal signal = static_cast<ChainSignal>(i);
    if (SignalNow(signal) == logged_[i]) continue;
    logged_[i] = !logged_[i];
    log_.push_back({time, signal, logged_[i]});
  }
}

bool SafetyChain::Level(ChainSignal signal) {
  Advance();
  return SignalNow(signal);
}

const std::vector<ChainEvent>& SafetyChain::log() {
  Advance();
  return log_;
}

bool SafetyChain::WasOpen(nanoseconds from, nanoseconds to) {
  Advance();
  return std::any_of(open_.begin(), open_.end(),
                     [from, to](const OpenSpan& span) { return span.from <= to && (!span.to || *span.to > from); });
}

}  // namespace annulus::sim
