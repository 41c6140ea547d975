// Row S4: a sensor whose bias creeps, found by the drift watch in scans of customers.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "acquisition/drift_alarm.h"
#include "tests/acquisition/customer_scans.h"
#include "tests/faults/ring_rows.h"

namespace annulus::faults {
namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr std::size_t kSensor = 47;
constexpr double kSpeedMmS = 0.02;
constexpr double kLimitMm = 0.5;

/// A person on the booth's stand, noise and lost returns as they are. The drift begins with this level of the scan.
FaultRigOptions WithCustomer(std::uint64_t seed, std::uint64_t level, ScanPlan& plan) {
  Customer customer = MakeCustomer(seed);
  plan = customer.plan;
  FaultRigOptions options = FaultRig::With("S4");
  options.plan.faults.front().at.number = level;
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

/// What a watch that is asked after every sweep has told by the end of `sweeps` of them.
DriftState StateAfter(const Scan& scan, std::uint16_t sweeps) {
  Scan so_far = scan;
  std::erase_if(so_far.levels, [&](const ScanLevel& level) { return level.sweep >= sweeps; });
  DriftHistory history;
  EXPECT_TRUE(history.Add(EstimateDrift(so_far)));
  return JudgeDrift(history, scan.header.machine.boards);
}

TEST(FaultMatrix, S4_ABiasThatCreepsIsToldBeforeItReachesHalfAMillimetre) {
  // The drift begins with the scan; in the middle of its first sweep; at the end of it.
  double latest = 0.0;
  for (const std::uint64_t level : {std::uint64_t{1}, std::uint64_t{90}, std::uint64_t{170}}) {
    ScanPlan plan;
    FaultRig rig(WithCustomer(7, level, plan));
    ASSERT_TRUE(TakeScan(rig, plan)) << rig.Told();
    const nanoseconds began = *rig.fault_time();
    const auto recording = ReadWholeRecording(rig.storage(), "customer.mcap");
    ASSERT_TRUE(recording) << recording.error().Text();
    const Scan& scan = recording->scan;
    double told_at = 0.0;
    for (std::uint16_t sweeps = 1; sweeps <= plan.sweeps && told_at == 0.0; ++sweeps) {
      const DriftState state = StateAfter(scan, sweeps);
      if (state.alarms.empty()) continue;
      ASSERT_EQ(state.alarms.size(), 1U);
      EXPECT_EQ(state.alarms.front().sensor, kSensor) << state.alarms.front().Text();
      for (const ScanLevel& taken : scan.levels) {
        if (taken.sweep + 1 == sweeps) {
          told_at = kSpeedMmS * std::chrono::duration<double>(taken.time - began).count();
        }
      }
    }
    EXPECT_GT(told_at, 0.0) << "level " << level;
    EXPECT_LT(told_at, kLimitMm) << "level " << level;
    latest = std::max(latest, told_at);
  }
  ReportNote("told at " + std::to_string(latest).substr(0, 4) + " mm at the latest, with no earlier scan to compare");
}

}  // namespace
}  // namespace annulus::faults
