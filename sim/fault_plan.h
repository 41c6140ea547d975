#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "sim/fault_kinds.h"

namespace annulus::sim {

/// When a fault begins or ends.
struct FaultTrigger {
  enum class Kind {
    kTime,   ///< `delay` after the injector was made.
    kState,  ///< `delay` after the booth entered `state` for the first time (after the fault began, if it is an end).
    kLevel,  ///< When level `number` of a scan has been taken, 0 first.
    kCall,   ///< At the `number`-th call at the target's seam that the kind can concern, 1 first.
  };
  Kind kind = Kind::kTime;
  std::string state;                  ///< kState: "SAFE", "IDLE", …
  std::chrono::nanoseconds delay{0};  ///< kTime, kState; >= 0.
  std::uint64_t number = 0;           ///< kLevel, kCall.

  bool operator==(const FaultTrigger&) const = default;
};

/// What was given of a fault's arguments. A value.
class FaultArgs {
 public:
  void Set(FaultArg arg, double value) { values_.at(static_cast<std::size_t>(arg)) = value; }
  [[nodiscard]] std::optional<double> Get(FaultArg arg) const { return values_.at(static_cast<std::size_t>(arg)); }

  bool operator==(const FaultArgs&) const = default;

 private:
  std::array<std::optional<double>, kFaultArgs> values_{};
};

/// One thing that goes wrong.
struct Fault {
  FaultTrigger at;
  /// Both empty: it stays, unless it is of a moment. At most one is given.
  std::optional<std::chrono::nanoseconds> lasting = std::nullopt;  ///< > 0.
  std::optional<FaultTrigger> until = std::nullopt;                ///< Not kCall.
  FaultKind kind = FaultKind::kHostKill;
  FaultArgs args;

  /// An argument as given, or its default. Requires that the kind has one of these.
  [[nodiscard]] double Value(FaultArg arg) const;
  /// The same as a whole number.
  [[nodiscard]] std::uint64_t Whole(FaultArg arg) const;
  /// 1 / rate_hz.
  [[nodiscard]] std::chrono::nanoseconds Period() const;
  /// An argument that need not be given and has no default.
  [[nodiscard]] std::optional<std::uint64_t> Choice(FaultArg arg) const;

  bool operator==(const Fault&) const = default;
};

/// What goes wrong in a simulated booth, and when (docs/formats.md, "Fault plan"). The same plan over the same booth
/// and the same calls gives the same faults.
struct FaultPlan {
  static constexpr std::size_t kMostFaults = 1000;

  std::uint64_t seed = 1;  ///< Of everything that chance decides.
  std::vector<Fault> faults;

  bool operator==(const FaultPlan&) const = default;
};

/// Reads a plan. `name` is what messages call it. An Error names the place and what is allowed there: nothing that is
/// unknown, missing or out of range is passed over.
Result<FaultPlan> ParseFaultPlan(std::string_view text, const std::string& name);

/// The plan as text that ParseFaultPlan reads back to the same value, and that is the same for the same plan.
[[nodiscard]] std::string WriteFaultPlan(const FaultPlan& plan);

/// The fault in one line: "axis contact height_mm=1200 at state SCANNING + 1.5 s".
[[nodiscard]] std::string FaultText(const Fault& fault);

/// The states of the booth that a plan may name.
inline constexpr std::array<const char*, 8> kFaultStates{"SAFE",     "IDLE",     "HOMING", "ARMED",
                                                         "SCANNING", "STOPPING", "FAULT",  "JOG"};

/// A plan of 1 to 4 plausible faults, number `number` of the series `seed`: of pairs that meet in practice (storage and
/// axis, sensor bus and E-stop, a killed program and anything), each at its own time of a scan.
[[nodiscard]] FaultPlan RandomFaultPlan(std::uint64_t seed, std::uint64_t number);

}  // namespace annulus::sim
