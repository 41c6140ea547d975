#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <vector>

#include "acquisition/scan_machine.h"

namespace annulus::test {

/// When every machine of these tests has come to its state.
inline constexpr std::chrono::nanoseconds kBegin = std::chrono::seconds(1000);
inline constexpr std::chrono::nanoseconds kLongest = std::chrono::seconds(16);

inline ScanEvent Event(ScanEventKind kind, std::chrono::nanoseconds time = kBegin) {
  ScanEvent event;
  event.kind = kind;
  event.time = time;
  event.longest = kLongest;
  event.role = CauseRole::kService;
  event.cause = {CauseCode::kSensorLost, "board 7 is gone", "check its cable", time};
  return event;
}

inline ScanEvent Event(ScanEventKind kind, CauseCode code, std::chrono::nanoseconds time = kBegin) {
  ScanEvent event = Event(kind, time);
  event.cause.code = code;
  return event;
}

inline Status Do(ScanMachine& machine, ScanEvent event) {
  event.version = machine.version();
  return machine.Handle(event);
}

/// A machine that has come to a state without a fault (to kFault by one that leaves it homed).
inline ScanMachine In(ScanState state) {
  ScanMachine machine;
  std::vector<ScanEventKind> way{ScanEventKind::kResetTaken, ScanEventKind::kHomeOrdered, ScanEventKind::kHomed,
                                 ScanEventKind::kArmed};
  if (state == ScanState::kSafe) way = {};
  if (state == ScanState::kIdle) way.resize(3);
  if (state == ScanState::kHoming) way.resize(2);
  if (state == ScanState::kScanning) way.push_back(ScanEventKind::kStarted);
  if (state == ScanState::kStopping) way.insert(way.end(), {ScanEventKind::kStarted, ScanEventKind::kLastLevel});
  if (state == ScanState::kFault) way.push_back(ScanEventKind::kFaulted);
  if (state == ScanState::kJog) way.back() = ScanEventKind::kJogOrdered;
  for (const ScanEventKind kind : way) EXPECT_TRUE(Do(machine, Event(kind)));
  EXPECT_EQ(machine.state(), state);
  return machine;
}

inline std::vector<CauseCode> Codes(const ScanMachine& machine) {
  std::vector<CauseCode> codes;
  for (const ScanCause& cause : machine.causes()) codes.push_back(cause.code);
  return codes;
}

template <class Each>
void ForEveryState(Each each) {
  for (std::size_t s = 0; s < kScanStates; ++s) {
    SCOPED_TRACE(ScanStateText(static_cast<ScanState>(s)));
    each(static_cast<ScanState>(s));
  }
}

}  // namespace annulus::test
