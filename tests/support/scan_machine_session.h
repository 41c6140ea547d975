#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "acquisition/scan_machine.h"
#include "tests/support/scan_machine_checker.h"

namespace annulus::test {

/// How often each event met each state.
using VisitCounts = std::array<std::array<std::uint64_t, kScanEventKinds>, kScanStates>;

/// A machine (or something that behaves like one) with its checker and its time. An operation is a number below
/// kOperations and an argument, both from a random engine or a fuzzer: 0 … 17 is the event of that kind, then time that
/// passes, then a beat of the jog. The control tick asks what is due after every one.
template <class Machine>
class MachineSession {
 public:
  static constexpr std::uint8_t kPass = kScanEventKinds;
  static constexpr std::uint8_t kBeat = kPass + 1;
  static constexpr std::uint8_t kOperations = kBeat + 1;

  explicit MachineSession(Machine machine = {}) : machine_(std::move(machine)), checker_(LookAt(machine_)) {}

  /// Does the operation; the rule that the machine has broken by then, or null.
  const char* Do(std::uint8_t operation, std::uint8_t argument) {
    if (operation < kPass) {
      if (const char* broken = Hand(EventOf(static_cast<ScanEventKind>(operation), argument))) return broken;
    } else if (operation == kPass) {
      now_ += Step(argument);
    } else {
      machine_.JogBeat(now_);
      checker_.Beat(now_);
    }
    return Tick();
  }

  [[nodiscard]] const MachineView& view() const { return checker_.view(); }
  [[nodiscard]] std::uint64_t events() const { return events_; }
  [[nodiscard]] const VisitCounts& visits() const { return visits_; }

 private:
  /// Asks what is due until it says nothing: a stop may follow, but not for ever.
  const char* Tick() {
    for (int asked = 0; asked < 4; ++asked) {
      const std::optional<ScanEvent> due = machine_.Due(now_);
      if (const char* broken = checker_.AfterDue(due, now_)) return broken;
      if (!due) return nullptr;
      if (const char* broken = Hand(*due)) return broken;
    }
    return "I7: what is due stays due";
  }

  const char* Hand(const ScanEvent& event) {
    ++visits_.at(static_cast<std::size_t>(view().state)).at(static_cast<std::size_t>(event.kind));
    ++events_;
    const Status status = machine_.Handle(event);
    return checker_.AfterEvent(event, !status, LookAt(machine_));
  }

  /// From nothing over the tick to longer than any state lasts.
  static std::chrono::nanoseconds Step(std::uint8_t argument) {
    using std::chrono::milliseconds;
    constexpr std::array<std::chrono::nanoseconds, 10> kSteps{
        milliseconds(0),   milliseconds(1),   milliseconds(10),   milliseconds(99),    milliseconds(100),
        milliseconds(210), milliseconds(300), milliseconds(2000), milliseconds(59990), milliseconds(95000)};
    return kSteps.at(argument % kSteps.size()) + std::chrono::nanoseconds(argument / 128);
  }

  ScanEvent EventOf(ScanEventKind kind, std::uint8_t argument) const {
    ScanEvent event;
    event.kind = kind;
    event.time = now_;
    event.cause = {CodeOf(kind, argument), "seen", "do", now_};
    constexpr std::array<std::int64_t, 4> kLongest{0, 250, 20'000, 20'001};
    event.longest = std::chrono::milliseconds(kLongest.at(argument / 8 % 4));
    event.version = view().version + (argument % 8 == 0 ? argument / 64 - 2U : 0U);
    event.role = argument % 2 == 0 ? CauseRole::kOperator : CauseRole::kService;
    return event;
  }

  /// The likely cause of a kind, but also every other one.
  static CauseCode CodeOf(ScanEventKind kind, std::uint8_t argument) {
    const auto any = static_cast<CauseCode>(argument % kCauseCodes);
    if (argument < 128) return any;
    if (kind == ScanEventKind::kChainOpened) return CauseCode::kChainOpen;
    if (kind == ScanEventKind::kHomingFailed) return CauseCode::kHoming;
    if (kind == ScanEventKind::kStopOverdue) return CauseCode::kStopOverdue;
    if (kind == ScanEventKind::kAwoke) return CauseCode::kInternal;
    return any;
  }

  Machine machine_;
  ScanMachineChecker checker_;
  std::chrono::nanoseconds now_{0};
  std::uint64_t events_ = 0;
  VisitCounts visits_{};
};

}  // namespace annulus::test
