#pragma once

#include <cstdint>
#include <random>

#include "tests/support/scan_machine_session.h"

namespace annulus::test {

/// An operation that leads on from a state, so that the walk does not stay where most events mean nothing.
inline std::uint8_t LeadsOn(const MachineView& view, std::mt19937_64& engine) {
  constexpr auto kPass = MachineSession<ScanMachine>::kPass;
  constexpr auto kBeat = MachineSession<ScanMachine>::kBeat;
  const auto of = [](ScanEventKind kind) { return static_cast<std::uint8_t>(kind); };
  const auto draw = engine() % 10;
  switch (view.state) {
    case ScanState::kSafe:
      return of(ScanEventKind::kResetTaken);
    case ScanState::kIdle:
      if (draw < 3) return of(ScanEventKind::kJogOrdered);
      return of(view.homed && draw < 9 ? ScanEventKind::kArmed : ScanEventKind::kHomeOrdered);
    case ScanState::kHoming:
      return draw < 2 ? kPass : of(ScanEventKind::kHomed);
    case ScanState::kArmed:
      return draw < 3 ? kPass : of(ScanEventKind::kStarted);
    case ScanState::kScanning:
      return draw < 4 ? kPass : of(draw < 8 ? ScanEventKind::kLastLevel : ScanEventKind::kFaulted);
    case ScanState::kStopping:
      return draw < 6 ? kPass : of(ScanEventKind::kStopped);
    case ScanState::kFault:
      return of(draw < 8 ? ScanEventKind::kAcknowledged : ScanEventKind::kFaulted);
    case ScanState::kJog:
      return draw < 3 ? kBeat : draw < 8 ? kPass : of(ScanEventKind::kJogReleased);
  }
  return kPass;
}

/// Until `events` events were taken, or a rule is broken: then that rule.
template <class Machine>
const char* Walk(MachineSession<Machine>& session, std::uint64_t events, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  while (session.events() < events) {
    const std::uint64_t draw = engine();
    const auto argument = static_cast<std::uint8_t>(draw >> 8 & 0xFFU);
    const bool anything = draw % 4 == 0;
    const auto operation = anything ? static_cast<std::uint8_t>((draw >> 16) % MachineSession<Machine>::kOperations)
                                    : LeadsOn(session.view(), engine);
    if (const char* broken = session.Do(operation, argument)) return broken;
  }
  return nullptr;
}

}  // namespace annulus::test
