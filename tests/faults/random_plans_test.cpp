// Several faults at once: seeded plans of storage and axis, sensor bus and chain, a killed program and anything.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "tests/faults/ring_rows.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr std::uint64_t kSeries = 6;
constexpr std::uint64_t kSampled = 25;  ///< Of so many plans one is run twice.

std::uint64_t HowMany() {
  if (std::getenv("ANNULUS_SOAK") != nullptr) return 10'000;
  return std::getenv("ANNULUS_LONG") != nullptr ? 2'000 : 200;
}

struct Outcome {
  std::string wrong;  ///< Empty: all is as it must be.
  std::string trace;  ///< What happened, for comparing: faults, states, causes, levels, bytes.
  bool killed = false;
  bool stopped = false;
  bool complete = false;
  nanoseconds safe{0};  ///< From the first fault; 0 if nothing stopped.
};

/// Times that the program was killed by the plan.
std::size_t Kills(const FaultRig& rig) {
  const sim::FaultInjector& injector = const_cast<FaultRig&>(rig).injector();
  return static_cast<std::size_t>(std::count_if(injector.log().begin(), injector.log().end(), [&](const auto& event) {
    return event.begins && injector.plan().faults[event.fault].kind == sim::FaultKind::kHostKill;
  }));
}

/// What only service can put right: what a fault wrote to the drive, and a safety relay of which one channel alone
/// opened.
void CallService(FaultRig& rig) {
  for (const sim::FaultEvent& event : rig.injector().log()) {
    const sim::Fault& fault = rig.injector().plan().faults[event.fault];
    if (!event.begins) continue;
    if (fault.kind == sim::FaultKind::kAxisParameter) {
      sim::AxisMishap repair;
      repair.kind = sim::AxisMishapKind::kParameter;
      repair.from = rig.Now();
      repair.value = 200.0;
      repair.code = sim::AxisParameterRegisters::kHeartbeat;
      rig.drive().Suffer(repair);
    }
    if (fault.kind == sim::FaultKind::kChainEstop && fault.Whole(sim::FaultArg::kChannel) != 2) {
      rig.chain().PressEstopAt(rig.Now());
      rig.chain().ReleaseEstopAt(rig.Now() + milliseconds(200));
      rig.Pass(milliseconds(300));
    }
  }
}

/// At rest though nobody looks after the lines any more.
std::string JudgeHardware(FaultRig& rig) {
  std::string wrong;
  if (std::abs(rig.drive().TrueSpeed(rig.Now())) > 0.01) wrong += "the axis moves without a program\n";
  if (rig.chain().Level(sim::ChainSignal::kBrakeReleased)) wrong += "the brake is released without a program\n";
  if (rig.chain().Level(sim::ChainSignal::kStoA)) wrong += "there is torque without a program\n";
  return wrong;
}

std::string TraceOf(FaultRig& rig) {
  std::string trace = rig.injector().LogText();
  for (const auto& at : rig.watch().states()) trace += InMs(at.time) + " " + ScanStateText(at.state) + "\n";
  for (const ScanCause& cause : rig.watch().shown())
    trace += std::string(TraitsOf(cause.code).name) + cause.text + "\n";
  for (const auto& [name, bytes] : rig.storage().files) {
    std::uint64_t sum = 1469598103934665603U;  // FNV-1a
    for (const std::byte byte : bytes) sum = (sum ^ static_cast<std::uint64_t>(byte)) * 1099511628211U;
    trace += name + " " + std::to_string(bytes.size()) + " " + std::to_string(sum) + "\n";
  }
  return trace;
}

/// An operator takes a scan while it all happens; then everything is put right, and the next scan must pass.
Outcome RunPlan(const sim::FaultPlan& plan) {
  FaultRigOptions options = FaultRig::Defaults();
  options.plan = plan;
  FaultRig rig(std::move(options));
  Outcome outcome;
  if (!rig.opened()) {
    outcome.wrong = rig.opened().message();
    return outcome;
  }
  const auto over = [&] {
    return Kills(rig) > 0 || (rig.Now() > seconds(2) && IsStopped(rig)) ||
           (rig.status().scan && rig.status().job.empty());
  };
  static_cast<void>(rig.Operate(over, seconds(40)));
  outcome.killed = Kills(rig) > 0;
  outcome.stopped = !outcome.killed && IsStopped(rig);
  outcome.complete = rig.status().scan && rig.status().scan->complete;
  // Consequences, and faults that come a little later.
  rig.Pass(seconds(2));
  rig.injector().Disarm();
  static_cast<void>(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(5)));
  rig.Pass(seconds(1));
  if (rig.fault_time() && (outcome.stopped || outcome.killed)) outcome.safe = TimeToSafe(rig, *rig.fault_time());
  CallService(rig);
  outcome.wrong += Kills(rig) > 0 ? JudgeHardware(rig) : JudgeRest(rig);
  outcome.wrong += JudgeRecording(rig, "scan.mcap");
  if (Kills(rig) > 0) {
    if (const auto again = rig.Restart(); !again) {
      outcome.wrong += std::string("not started again: ") + again.message();
      return outcome;
    }
  }
  if (const std::string next = rig.NextScan(); !next.empty()) outcome.wrong += next + "\n";
  outcome.wrong += JudgeRest(rig);
  for (const std::string& one : rig.watch().violations()) outcome.wrong += one + "\n";
  if (rig.injector().usb_host_model().leaked_transfers() != 0) outcome.wrong += "transfers were leaked\n";
  if (rig.injector().usb_host_model().open_ports() != sim::BoothDevices::kBoards) outcome.wrong += "ports leak\n";
  if (!outcome.wrong.empty()) outcome.wrong += rig.Told();
  outcome.trace = TraceOf(rig);
  return outcome;
}

TEST(RandomFaultPlans, LeaveTheBoothAtRestTheRecordingReadableAndTheNextScanWhole) {
  const std::uint64_t many = HowMany();
  const char* only = std::getenv("ANNULUS_FAULT_PLAN");  // one number, to look at it
  const ProcessUse before = UseOfProcess();
  std::map<std::string, int> counts;
  std::vector<nanoseconds> safe;
  for (std::uint64_t number = only != nullptr ? std::strtoull(only, nullptr, 10) : 0; number < many; ++number) {
    const sim::FaultPlan plan = sim::RandomFaultPlan(kSeries, number);
    const Outcome outcome = RunPlan(plan);
    EXPECT_EQ(outcome.wrong, "") << "plan " << number << " of series " << kSeries << ":\n" << WriteFaultPlan(plan);
    ++counts[outcome.killed ? "killed" : outcome.stopped ? "stopped" : outcome.complete ? "complete" : "ended"];
    if (outcome.safe > nanoseconds(0)) safe.push_back(outcome.safe);
    if (number % kSampled == 0) {
      EXPECT_EQ(RunPlan(plan).trace, outcome.trace) << "plan " << number << " does not run the same twice";
    }
    if (many > 200 && number % 500 == 499) std::printf("%d plans\n", static_cast<int>(number + 1));
    if (only != nullptr) break;
  }
  const ProcessUse after = UseOfProcess();
  EXPECT_EQ(after.descriptors, before.descriptors);
  EXPECT_EQ(after.threads, before.threads);
  std::printf("%d plans: %d stopped, %d killed, %d complete, %d ended otherwise\n", static_cast<int>(many),
              counts["stopped"], counts["killed"], counts["complete"], counts["ended"]);
}

}  // namespace
}  // namespace annulus::faults
