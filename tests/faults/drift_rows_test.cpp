// Row S4: a sensor whose bias creeps, found by the drift watch in scans of customers.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <optional>

#include "acquisition/drift_alarm.h"
#include "tests/acquisition/customer_scans.h"
#include "tests/faults/ring_rows.h"

namespace annulus::faults {
namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr double kSpeedMmS = 0.02;
constexpr double kLimitMm = 0.5;

/// Which sensor drifts, and from when on.
struct Creep {
  std::size_t sensor = 47;
  std::uint64_t level = 1;  ///< Of the scan.
};

/// A person on the booth's stand, noise and lost returns as they are.
FaultRigOptions WithCustomer(std::uint64_t seed, const Creep& creep, ScanPlan& plan) {
  Customer customer = MakeCustomer(seed);
  plan = customer.plan;
  FaultRigOptions options = FaultRig::With("S4");
  options.plan.faults.front().at.number = creep.level;
  options.plan.faults.front().args.Set(sim::FaultArg::kSensor, static_cast<double>(creep.sensor));
  options.booth.subject = std::move(customer.subject);
  options.booth.beam.noise_sigma_mm = 0.5;
  options.booth.beam.dropout_rate = 0.01;
  options.booth.beam.outlier_rate = 0.002;
  return options;
}

/// The operator takes one scan by the body profile.
bool TakeScan(FaultRig& rig, const ScanPlan& plan) {
  if (!rig.Operate([&] { return rig.state() == ScanState::kIdle && rig.status().homed; })) return false;
  rig.Pass(std::chrono::milliseconds(100));
  ArmRequest request;
  request.plan = plan;
  request.out = "customer.mcap";
  request.header.ring_radius_mm = 600.0;
  request.header.calibration = RingCalibration::Ideal(600.0);
  if (!rig.scanner().OrderArm(request) || !rig.RunUntil(ScanState::kArmed, seconds(10)) || !rig.Start()) return false;
  return rig.RunUntil([&] { return rig.status().scan && rig.state() == ScanState::kIdle; }, seconds(120));
}

/// The customers of the morning, before anything is wrong.
DriftHistory Morning() {
  DriftHistory history;
  for (std::uint64_t seed = 101; seed <= 110; ++seed) EXPECT_TRUE(history.Add(EstimateDrift(CustomerScan(seed))));
  return history;
}

/// The bias when a watch that is asked every half second tells it, mm; nothing: not while the scan lasts.
std::optional<double> ToldAt(const DriftHistory& history, const Scan& scan, nanoseconds began, std::size_t sensor) {
  Scan so_far = scan;
  so_far.levels.clear();
  nanoseconds asked = scan.levels.front().time;
  for (const ScanLevel& level : scan.levels) {
    so_far.levels.push_back(level);
    if (level.time - asked < std::chrono::milliseconds(500)) continue;
    asked = level.time;
    const auto state = JudgeScanSoFar(history, so_far);
    EXPECT_TRUE(state) << state.error().Text();
    for (const DriftAlarm& alarm : state->alarms) EXPECT_EQ(alarm.sensor, sensor) << alarm.Text();
    if (!state->alarms.empty()) return kSpeedMmS * std::chrono::duration<double>(level.time - began).count();
  }
  return std::nullopt;
}

TEST(FaultMatrix, S4_ABiasThatCreepsIsToldBeforeItReachesHalfAMillimetre) {
  const DriftHistory history = Morning();
  double latest = 0.0;
  // Sensors that see the body all the way and one that looks between the legs; from the scan's first level on, and
  // later.
  for (const Creep& creep : {Creep{47, 1}, Creep{100, 1}, Creep{160, 1}, Creep{100, 60}, Creep{10, 120}}) {
    ScanPlan plan;
    FaultRig rig(WithCustomer(7, creep, plan));
    ASSERT_TRUE(TakeScan(rig, plan)) << rig.Told();
    const auto recording = ReadWholeRecording(rig.storage(), "customer.mcap");
    ASSERT_TRUE(recording) << recording.error().Text();
    const auto told = ToldAt(history, recording->scan, *rig.fault_time(), creep.sensor);
    ASSERT_TRUE(told) << creep.sensor << " from level " << creep.level;
    EXPECT_GT(*told, 0.0) << creep.sensor;
    EXPECT_LT(*told, kLimitMm) << creep.sensor << " from level " << creep.level;
    latest = std::max(latest, *told);
  }
  ReportNote("told at " + std::to_string(latest).substr(0, 4) + " mm at the latest");
}

}  // namespace
}  // namespace annulus::faults
