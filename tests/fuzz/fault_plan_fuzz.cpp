/// Fault plans. Beyond "no crash": a plan that is accepted is written and read back to the same value, and its
/// schedule, run twice through the same states, levels and calls, gives the same log.
#include <cstdint>
#include <string_view>

#include "base/ensure.h"
#include "sim/fault_plan.h"
#include "sim/fault_schedule.h"

namespace {

using namespace annulus::sim;
using std::chrono::milliseconds;

std::vector<FaultEvent> LogOf(const FaultPlan& plan) {
  FaultSchedule schedule(plan, milliseconds(0));
  for (int tick = 0; tick < 64; ++tick) {
    const auto now = milliseconds(10 * tick);
    schedule.NoteState(kFaultStates.at(static_cast<std::size_t>(tick / 4) % kFaultStates.size()), now);
    schedule.NoteLevel(static_cast<std::uint64_t>(tick), now);
    for (std::size_t target = 0; target < kFaultTargets; ++target) {
      schedule.NoteCall({static_cast<FaultTarget>(target), static_cast<std::size_t>(tick) % 12, tick % 2 == 0}, now);
    }
    for (const FaultSchedule::Step& step : schedule.Take(now)) {
      ENSURE(step.fault < plan.faults.size(), "a step is of a fault of the plan");
      ENSURE(!step.begins || step.to > step.time, "what begins lasts");
    }
  }
  return schedule.log();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto plan = ParseFaultPlan({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!plan) {
    ENSURE(!plan.error().advice.empty(), "a refusal says what to do");
    return 0;
  }
  const auto again = ParseFaultPlan(WriteFaultPlan(*plan), "again");
  ENSURE(again.has_value() && *again == *plan, "a plan reads back as it was");
  ENSURE(LogOf(*plan) == LogOf(*again), "the same plan gives the same log");
  return 0;
}
