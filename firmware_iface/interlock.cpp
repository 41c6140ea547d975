#include "firmware_iface/interlock.h"

#include <algorithm>
#include <utility>

namespace annulus {
namespace {

using std::chrono::duration_cast;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

using In = InterlockInput;
using Out = InterlockOutput;

/// More edges than that are not waited for in one reading; a line that chatters so is not followed any more.
constexpr int kMostEdges = 1000;
constexpr std::array<Out, 3> kSafeOrder = {Out::kQuickStop, Out::kEmitters, Out::kEnable};
constexpr std::array<Out, 3> kLamps = {Out::kLampReady, Out::kLampRunning, Out::kLampFault};
constexpr const char* kNoResetYet = "no reset since the program started";

constexpr std::size_t Index(In input) { return static_cast<std::size_t>(input); }
constexpr std::size_t Index(Out output) { return static_cast<std::size_t>(output); }
constexpr std::size_t LineOf(Out output) { return kInterlockInputs + Index(output); }

bool IsHeldSafe(Out output) { return std::find(kSafeOrder.begin(), kSafeOrder.end(), output) != kSafeOrder.end(); }

std::string Milliseconds(nanoseconds time) { return std::to_string(duration_cast<milliseconds>(time).count()) + " ms"; }

class GpioInterlock final : public Interlock {
 public:
  GpioInterlock(std::unique_ptr<GpioLines> lines, Clock& clock) : lines_(std::move(lines)), clock_(clock) {}
  GpioInterlock(const GpioInterlock&) = delete;
  GpioInterlock& operator=(const GpioInterlock&) = delete;
  ~GpioInterlock() override { (void)AllOff(); }

  /// All outputs off, and the levels from which edges count.
  Status Start() {
    RETURN_IF_ERROR(AllOff());
    const auto levels = lines_->Read();
    if (!levels) return tl::unexpected<Error>(GpioError("read the interlock's lines", levels.error()));
    std::copy_n(levels->begin(), kInterlockInputs, level_.begin());
    changed_.fill(clock_.Now());
    low_since_.fill(clock_.Now() - interlock_time::kBounce);
    if (level_[Index(In::kReset)]) reset_held_since_ = clock_.Now();
    return {};
  }

  Result<InterlockReading> Read() override {
    InterlockReading reading;
    if (const auto sampled = Sample(reading); !sampled)
      return LinesFailed(GpioError("read the interlock's lines", sampled.error()));
    if (const Status off = OrderOffAgain(); !off) return LinesFailed(off.error());
    EndFault(InterlockFault::kLinesFailed);
    JudgeChannels(reading);
    JudgeFeedback(reading);
    JudgeWarnings(reading);
    if (const std::string cause = WhatStops(reading); !cause.empty()) {
      if (reading.reset_pressed) reading.reset_refused = cause;
      if (const Status held = Hold(cause); !held) return LinesFailed(held.error());
    } else {
      FollowReset(reading);
    }
    reading.latched = latched_;
    if (latched_) reading.held_by = hold_cause_;
    return reading;
  }

  Result<InterlockReading> WaitChange(nanoseconds deadline) override {
    const auto edge = lines_->WaitEdge(deadline);
    if (!edge) return LinesFailed(GpioError("wait for a change of the interlock's lines", edge.error()));
    if (*edge) waited_for_ = **edge;
    return Read();
  }

  Status Set(Out output, bool level) override {
    const std::string attempted = std::string("switch on ") + InterlockName(output);
    if (output == Out::kWatchdog) {
      return Fail("set the watchdog's line", "its pulses come from beats only", "call KickWatchdog");
    }
    if (level && IsHeldSafe(output) && latched_) {
      return Fail(attempted, "outputs are held safe: " + hold_cause_, "end the cause, then press the reset button");
    }
    if (const std::string still_on = Unconfirmed(); level && IsHeldSafe(output) && !still_on.empty()) {
      return Fail(attempted, still_on, "wait for a reading that succeeds");
    }
    if (level && output == Out::kEnable && !output_[Index(Out::kEnable)]) {
      if (!level_[Index(In::kWatchdogFeedback)]) {
        return Fail(attempted, "the watchdog relay is off", "send it beats; if it stays off, check its wiring");
      }
      if (level_[Index(In::kEnableFeedback)]) {
        return Fail(attempted, "the enable relay has not dropped out yet", "wait; if it stays on, a contact is welded");
      }
    }
    Status written = Write(output, level);
    // It may have been switched on all the same.
    if (!written && level && IsHeldSafe(output)) (void)Write(output, false);
    return written;
  }

  [[nodiscard]] bool output(Out output) const override { return output_.at(Index(output)); }

  Status KickWatchdog() override {
    if (const std::string still_on = Unconfirmed(); !still_on.empty()) {
      return Fail("send a beat to the watchdog relay", still_on, "let the relay drop: it is what still switches off");
    }
    const bool edge = beats_++ % 2 == 0;
    return edge ? Write(Out::kWatchdog, !output_[Index(Out::kWatchdog)]) : Status{};
  }

  Status MakeSafe() override {
    Status first;
    for (const Out output : kSafeOrder) {
      const Status status = Write(output, false);
      if (!status && first) first = status;
    }
    return first;
  }

  [[nodiscard]] std::vector<InterlockNotice> Diagnose() const override { return notices_; }

  Status Acknowledge() override {
    for (const InterlockNotice& notice : notices_) {
      if (notice.present && ClassOf(notice.fault) == InterlockFaultClass::kService) {
        return Fail("acknowledge the fault of the safety chain", notice.text, notice.advice);
      }
    }
    std::erase_if(notices_,
                  [](const InterlockNotice& notice) { return ClassOf(notice.fault) == InterlockFaultClass::kService; });
    return {};
  }

 private:
  // --- lines ---

  /// What was to be switched off counts as off even if the chip did not take the order, whatever the reason; it is then
  /// unconfirmed, and ordered off again until the chip takes it.
  Status Write(Out output, bool level) {
    const auto written = lines_->Write(LineOf(output), level);
    const std::size_t i = Index(output);
    const bool ordered_off = !level && IsHeldSafe(output);
    if (written || ordered_off) {
      if (output_[i] != level || unconfirmed_[i]) changed_[i] = clock_.Now();
      output_[i] = level;
      unconfirmed_[i] = !written;
    }
    if (output == Out::kEnable && !level) pulled_in_ = false;
    if (written) return {};
    return tl::unexpected<Error>(GpioError(std::string("set ") + InterlockName(output), written.error()));
  }

  /// The first output that could not be switched off, in words; empty: none.
  [[nodiscard]] std::string Unconfirmed() const {
    for (const Out output : kSafeOrder) {
      if (unconfirmed_[Index(output)]) return std::string(InterlockName(output)) + " could not be switched off";
    }
    return {};
  }

  Status OrderOffAgain() { return Unconfirmed().empty() ? Status{} : MakeSafe(); }

  Status AllOff() {
    Status first = MakeSafe();
    for (const Out output : {Out::kWatchdog, Out::kLampReady, Out::kLampRunning, Out::kLampFault}) {
      const Status status = Write(output, false);
      if (!status && first) first = status;
    }
    return first;
  }

  tl::unexpected<Error> LinesFailed(const Error& error) {
    Raise(InterlockFault::kLinesFailed, error.attempted + ": " + error.seen, error.advice);
    waited_for_.reset();
    (void)Hold(error.seen);
    return tl::unexpected<Error>(error);
  }

  /// Levels first, then edges: whatever happened before the levels were read is among the edges, and what came after
  /// corrects them.
  GpioResult<void> Sample(InterlockReading& reading) {
    reading.host_time = clock_.Now();
    const auto levels = lines_->Read();
    if (!levels) return tl::unexpected<GpioFailure>(levels.error());
    for (std::size_t i = 0; i < kInterlockInputs; ++i) {
      reading.level[i] = (*levels)[i];
      reading.opened[i] = IsChainInput(static_cast<In>(i)) && (!level_[i] || !reading.level[i]);
    }
    for (std::size_t i = 0; i < kInterlockOutputs; ++i) read_back_[i] = (*levels)[kInterlockInputs + i];
    if (waited_for_) FollowEdge(*std::exchange(waited_for_, std::nullopt), reading);
    for (int count = 0;; ++count) {
      const auto edge = lines_->WaitEdge(reading.host_time);
      if (!edge) return tl::unexpected<GpioFailure>(edge.error());
      if (!*edge) break;
      FollowEdge(**edge, reading);
      if (count < kMostEdges) continue;
      reading.edges_lost = true;
      break;
    }
    level_ = reading.level;
    for (std::size_t i = 0; i < kInterlockInputs; ++i) {
      reading.opened[i] = IsChainInput(static_cast<In>(i)) && (reading.opened[i] || !level_[i]);
    }
    reading.chain_closed = std::none_of(reading.opened.begin(), reading.opened.end(), [](bool open) { return open; });
    return {};
  }

  /// Any edge of a chain input means that it was open: before a rising one, after a falling one.
  void FollowEdge(const GpioEdge& edge, InterlockReading& reading) {
    if (edge.line >= kInterlockInputs) return;
    const In input = static_cast<In>(edge.line);
    if (IsChainInput(input)) reading.opened[edge.line] = true;
    reading.edges_lost = reading.edges_lost || edge.after_loss;
    // Pressing is seen, never concluded: an edge that stands for lost ones does not count.
    // A button that bounces, also when it is let go, is not pressed again.
    const bool rested = edge.host_time - low_since_[edge.line] >= interlock_time::kBounce;
    const bool pressed = edge.level && !edge.after_loss && rested;
    if (!edge.level) low_since_[edge.line] = edge.host_time;
    reading.reset_pressed = reading.reset_pressed || (pressed && input == In::kReset);
    reading.start_pressed = reading.start_pressed || (pressed && input == In::kStartKey);
    reading.call_pressed = reading.call_pressed || (pressed && input == In::kCall);
    level_[edge.line] = edge.level;
    FollowChannels(edge.host_time);
    if (edge.host_time > reading.host_time) reading.level[edge.line] = edge.level;
  }

  void FollowChannels(nanoseconds time) {
    const bool differ = level_[Index(In::kEstopA)] != level_[Index(In::kEstopB)];
    if (!differ && differ_since_) longest_differ_ = std::max(longest_differ_, time - *differ_since_);
    if (!differ) differ_since_.reset();
    if (differ && !differ_since_) differ_since_ = time;
  }

  // --- judgement ---

  void JudgeChannels(InterlockReading& reading) {
    FollowChannels(reading.host_time);
    if (differ_since_) reading.channels_disagree = std::max(nanoseconds(1), reading.host_time - *differ_since_);
    const nanoseconds longest = std::max(std::exchange(longest_differ_, nanoseconds(0)), reading.channels_disagree);
    if (longest > interlock_time::kDisagreement) {
      Raise(InterlockFault::kChannelsDisagree,
            "the two E-stop channels disagreed for " + Milliseconds(longest) + ": " +
                (level_[Index(In::kEstopA)] ? "estop_b is open" : "estop_a is open"),
            "check the chain: E-stop contacts, wires and inputs of both channels");
    }
    if (!differ_since_) EndFault(InterlockFault::kChannelsDisagree);
  }

  void JudgeFeedback(const InterlockReading& reading) {
    const nanoseconds on_or_off_for = reading.host_time - changed_[Index(Out::kEnable)];
    const bool enable = output_[Index(Out::kEnable)];
    const bool feedback = reading[In::kEnableFeedback];
    const bool rested = !enable && on_or_off_for >= interlock_time::kDropOut;
    Judge(InterlockFault::kWeldedContact, rested && feedback,
          "enable is off but the feedback of its relay is on: a contact is welded, or its wire is broken",
          "do not run; replace the relay or mend the wire");
    Judge(InterlockFault::kBrakeOpen, rested && reading[In::kBrakeFeedback],
          "enable is off but the brake says that it is released", "secure the carriage; check brake and its switch");
    Judge(InterlockFault::kWatchdogDropped, enable && !reading[In::kWatchdogFeedback],
          "the watchdog relay has dropped: the program was held up, or its line is broken",
          "look for what held up the program; then press the reset button");
    pulled_in_ = enable && (pulled_in_ || feedback);
    // With the chain open, or without the watchdog relay, the enable relay has to drop.
    const bool expected = enable && reading.chain_closed && reading[In::kWatchdogFeedback];
    Judge(InterlockFault::kNoEnableFeedback,
          expected && !feedback && (pulled_in_ || on_or_off_for >= interlock_time::kPullIn),
          pulled_in_ ? "the enable relay has dropped though enable is on"
                     : "enable is on but the feedback of its relay is off after " + Milliseconds(on_or_off_for),
          "check the safety relay's reset, the enable relay and its feedback");
    JudgeReadBack(reading.host_time);
  }

  void JudgeReadBack(nanoseconds now) {
    std::string wrong;
    for (std::size_t i = 0; i < kInterlockOutputs; ++i) {
      if (read_back_[i] == output_[i] || now - changed_[i] < interlock_time::kReadBack) continue;
      wrong.append(wrong.empty() ? "" : ", ").append(InterlockName(static_cast<Out>(i)));
      if (!output_[i]) (void)Write(static_cast<Out>(i), false);
    }
    Judge(InterlockFault::kOutputDiffers, !wrong.empty(), "an output does not read back what was set: " + wrong,
          "check the I/O board and what is connected to that output");
  }

  void JudgeWarnings(const InterlockReading& reading) {
    if (!reading[In::kReset]) reset_held_since_.reset();
    if (reading[In::kReset] && (!reset_held_since_ || reading.reset_pressed)) reset_held_since_ = reading.host_time;
    Judge(InterlockFault::kResetStuck,
          reset_held_since_ && reading.host_time - *reset_held_since_ >= interlock_time::kResetHeld,
          "the reset button is pressed all the time", "release it; check the button and its wire");
    nanoseconds since{0};
    std::string lit;
    for (const Out lamp : kLamps) {
      if (!output_[Index(lamp)]) continue;
      since = std::max(since, changed_[Index(lamp)]);
      lit.append(lit.empty() ? "" : ", ").append(InterlockName(lamp));
    }
    Judge(InterlockFault::kLampLost,
          !lit.empty() && !reading[In::kLampFeedback] && reading.host_time - since >= interlock_time::kLamp,
          "no current flows through " + lit, "replace the lamp, or check its wire");
  }

  void Judge(InterlockFault fault, bool present, const std::string& text, const std::string& advice) {
    if (present) {
      Raise(fault, text, advice);
    } else {
      EndFault(fault);
    }
  }

  void Raise(InterlockFault fault, const std::string& text, const std::string& advice) {
    const auto known = Find(fault);
    if (known == notices_.end()) {
      notices_.push_back({fault, clock_.Now(), true, text, advice});
    } else {
      known->present = true;
    }
  }

  /// The cause has gone; a fault that stops is kept until somebody ends it.
  void EndFault(InterlockFault fault) {
    const auto known = Find(fault);
    if (known == notices_.end()) return;
    known->present = false;
    if (ClassOf(fault) == InterlockFaultClass::kWarning) notices_.erase(known);
  }

  std::vector<InterlockNotice>::iterator Find(InterlockFault fault) {
    return std::find_if(notices_.begin(), notices_.end(),
                        [fault](const InterlockNotice& notice) { return notice.fault == fault; });
  }

  /// The cause for which outputs must be safe now; empty: none.
  [[nodiscard]] std::string WhatStops(const InterlockReading& reading) const {
    for (const InterlockNotice& notice : notices_) {
      const InterlockFaultClass kind = ClassOf(notice.fault);
      const bool stops =
          kind == InterlockFaultClass::kService || (kind == InterlockFaultClass::kOperator && notice.present);
      if (stops) return notice.text;
    }
    return reading.chain_closed ? std::string() : "open: " + OpenedInputs(reading);
  }

  // --- latch ---

  /// Keeps the first cause; switches off what is not, or may not be.
  Status Hold(const std::string& cause) {
    if (!latched_ || hold_cause_ == kNoResetYet) hold_cause_ = cause;
    latched_ = true;
    reset_at_.reset();
    const bool on = std::any_of(kSafeOrder.begin(), kSafeOrder.end(), [this](Out o) { return output_[Index(o)]; });
    return on ? MakeSafe() : OrderOffAgain();
  }

  void FollowReset(InterlockReading& reading) {
    if (!latched_) return;
    if (reading.reset_pressed && reading[In::kEnableFeedback]) {
      reading.reset_refused = "the enable relay has not dropped out yet";
      return;
    }
    if (reading.reset_pressed && !reset_at_) reset_at_ = reading.host_time;
    if (!reset_at_ || reading.host_time - *reset_at_ < interlock_time::kReset) return;
    latched_ = false;
    reset_at_.reset();
    std::erase_if(notices_, [](const InterlockNotice& notice) {
      return ClassOf(notice.fault) == InterlockFaultClass::kOperator;
    });
  }

  std::unique_ptr<GpioLines> lines_;
  Clock& clock_;
  std::array<bool, kInterlockInputs> level_{};             ///< As last known, edge by edge.
  std::array<nanoseconds, kInterlockInputs> low_since_{};  ///< Each input's last falling edge.
  std::array<bool, kInterlockOutputs> output_{};           ///< As ordered.
  std::array<bool, kInterlockOutputs> unconfirmed_{};      ///< Ordered off; the chip did not take it.
  std::array<bool, kInterlockOutputs> read_back_{};
  std::array<nanoseconds, kInterlockOutputs> changed_{};  ///< When each output last changed.
  std::optional<GpioEdge> waited_for_;                    ///< Collected by WaitChange, for the reading that follows.
  std::uint64_t beats_ = 0;
  bool pulled_in_ = false;  ///< The feedback has been there since enable was set.
  std::optional<nanoseconds> differ_since_;
  nanoseconds longest_differ_{0};  ///< Of disagreements that ended since the last reading.
  std::optional<nanoseconds> reset_held_since_;
  bool latched_ = true;
  std::string hold_cause_ = kNoResetYet;
  std::optional<nanoseconds> reset_at_;  ///< An accepted reset edge whose waiting time runs.
  std::vector<InterlockNotice> notices_;
};

}  // namespace

InterlockFaultClass ClassOf(InterlockFault fault) {
  switch (fault) {
    case InterlockFault::kResetStuck:
    case InterlockFault::kLampLost:
      return InterlockFaultClass::kWarning;
    case InterlockFault::kChannelsDisagree:
    case InterlockFault::kWeldedContact:
    case InterlockFault::kBrakeOpen:
      return InterlockFaultClass::kService;
    case InterlockFault::kNoEnableFeedback:
    case InterlockFault::kWatchdogDropped:
    case InterlockFault::kOutputDiffers:
    case InterlockFault::kLinesFailed:
      return InterlockFaultClass::kOperator;
  }
  return InterlockFaultClass::kService;
}

std::string OpenedInputs(const InterlockReading& reading) {
  std::string text;
  for (std::size_t i = 0; i < kInterlockInputs; ++i) {
    if (reading.opened[i]) text.append(text.empty() ? "" : ", ").append(InterlockName(static_cast<In>(i)));
  }
  return text;
}

Result<std::unique_ptr<Interlock>> MakeInterlock(std::unique_ptr<GpioLines> lines, Clock& clock) {
  const std::size_t count = kInterlockInputs + kInterlockOutputs;
  if (lines == nullptr || lines->count() != count) {
    return Fail("make the interlock",
                std::to_string(lines == nullptr ? 0 : lines->count()) + " lines instead of " + std::to_string(count),
                "request all lines of the wiring, inputs first");
  }
  auto interlock = std::make_unique<GpioInterlock>(std::move(lines), clock);
  RETURN_IF_ERROR(interlock->Start());
  return interlock;
}

}  // namespace annulus
