#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "ring_rig.h"
#include "tests/support/dice.h"

namespace annulus::test {
namespace {

/// A quick rig: three placements of the first cylinder.
Rig SmallRig(std::uint64_t seed) {
  Rig rig = StandardRig(seed);
  rig.plan.resize(3);
  rig.options.pitch_mm = 24.0;
  return rig;
}

Result<RingSolution> Solve(const Rig& rig, const std::vector<TargetScan>& scans) {
  return CalibrateRing(RingCalibration::Ideal(600.0), rig.Targets(), scans, {}, {});
}

TEST(CalibrationFailures, SayThatThereIsNothingToGoBy) {
  const auto solution = Solve(SmallRig(1), {});
  ASSERT_FALSE(solution);
  EXPECT_EQ(solution.error().attempted, "calibrate the ring");
  EXPECT_FALSE(solution.error().advice.empty());
}

TEST(CalibrationFailures, NameThePlacementThatShowsNoTarget) {
  const Rig rig = SmallRig(1);
  std::vector<TargetScan> scans = rig.Scans();
  scans[1].readings.clear();
  const auto empty = Solve(rig, scans);
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().attempted, "find the target in placement 2");

  scans = rig.Scans();
  scans[1].readings.resize(500);  // a strip of it
  const auto strip = Solve(rig, scans);
  ASSERT_FALSE(strip);
  EXPECT_EQ(strip.error().attempted, "find the target in placement 2");
}

TEST(CalibrationFailures, NameATargetOfAnotherSize) {
  const Rig rig = SmallRig(1);
  for (const double wrong : {-20.0, 20.0, 60.0}) {
    std::vector<CalibrationTarget> targets = rig.Targets();
    targets[0].radius_mm += wrong;
    const auto solution = CalibrateRing(RingCalibration::Ideal(600.0), targets, rig.Scans(), {}, {});
    ASSERT_FALSE(solution) << wrong;
    EXPECT_EQ(solution.error().attempted, "find the target in placement 1");
    EXPECT_NE(solution.error().advice.find("radius"), std::string::npos);
  }
}

TEST(CalibrationFailures, NameACylinderThatWasTakenForAnotherKind) {
  const Rig rig = SmallRig(1);
  for (const auto kind : {CalibrationTarget::Kind::kSphere, CalibrationTarget::Kind::kPlane}) {
    std::vector<CalibrationTarget> targets = rig.Targets();
    targets[0].kind = kind;
    const auto solution = CalibrateRing(RingCalibration::Ideal(600.0), targets, rig.Scans(), {}, {});
    if (solution) {
      EXPECT_TRUE(solution->failed() || solution->chi_square > 3.0) << static_cast<int>(kind) << Codes(*solution);
    }
  }
}

TEST(CalibrationFailures, SurviveReadingsThatAreNoNumbers) {
  const Rig rig = SmallRig(2);
  std::vector<TargetScan> scans = rig.Scans();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Dice dice(1);
  for (TargetScan& scan : scans) {
    for (int k = 0; k < 200; ++k) {
      TargetReading& reading = scan.readings[dice.Below(scan.readings.size())];
      switch (dice.Below(7)) {
        case 0:
          reading.range_mm = kNan;
          break;
        case 1:
          reading.z_mm = kNan;
          break;
        case 2:
          reading.range_mm = kInfinity;
          break;
        case 3:
          reading.z_mm = -kInfinity;
          break;
        case 4:
          reading.weight = std::numeric_limits<float>::quiet_NaN();
          break;
        case 5:
          reading.sensor = 60'000;
          break;
        default:
          reading.range_mm = -1.0;
      }
    }
  }
  const auto solution = Solve(rig, scans);
  ASSERT_TRUE(solution) << solution.error().Text();
  EXPECT_LE(RigErrors::Rms(ErrorsAt(rig.truth, solution->calibration, 450.0).radial_mm), 0.15);
  for (TargetScan& scan : scans) {
    for (TargetReading& reading : scan.readings) reading.range_mm = kNan;
  }
  const auto nothing = Solve(rig, scans);
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().attempted, "find the target in placement 1");
}

TEST(CalibrationFailures, LeaveOutWhatElseStandsInTheRing) {
  Rig rig = StandardRig(3);
  std::vector<TargetScan> scans = rig.Scans();
  // A technician's leg beside the target in a third of the heights: it hides the target from 20 sensors.
  std::mt19937_64 random(1);
  for (TargetReading& reading : scans[2].readings) {
    if (reading.z_mm < 450.0 && reading.sensor >= 100 && reading.sensor < 120) {
      reading.range_mm = 180.0 + 0.5 * static_cast<double>(random() % 100);
    }
  }
  const auto solution = Solve(rig, scans);
  ASSERT_TRUE(solution) << solution.error().Text();
  EXPECT_GT(solution->placements[2].elsewhere, 1000U);
  const RigErrors errors = ErrorsAt(rig.truth, solution->calibration, 450.0);
  EXPECT_LE(std::abs(errors.common_mm), 0.1);
  EXPECT_LE(RigErrors::Rms(errors.radial_mm), 0.15);
  EXPECT_FALSE(solution->failed()) << Codes(*solution);
}

TEST(CalibrationFailures, StopOnRequestWhereverTheyAre) {
  const Rig rig = SmallRig(4);
  const std::vector<TargetScan> scans = rig.Scans();
  for (const std::string stage : {"placements", "solve"}) {
    std::stop_source source;
    TaskContext context;
    context.stop = source.get_token();
    context.progress = [&](std::string_view now, double done, double total) {
      EXPECT_LE(done, total);
      if (now == stage) source.request_stop();
    };
    const auto solution = CalibrateRing(RingCalibration::Ideal(600.0), rig.Targets(), scans, {}, context);
    ASSERT_FALSE(solution) << stage;
    EXPECT_EQ(solution.error().seen, "stopped on request") << stage;
  }
}

TEST(CalibrationFailures, KeepTwoSwappedSensorsFromSpoilingTheOthers) {
  Rig rig = StandardRig(5);
  std::vector<TargetScan> scans = rig.Scans();
  constexpr std::uint16_t kOne = 20;
  constexpr std::uint16_t kOther = 75;
  for (TargetScan& scan : scans) {
    for (TargetReading& reading : scan.readings) {
      if (reading.sensor == kOne) {
        reading.sensor = kOther;
      } else if (reading.sensor == kOther) {
        reading.sensor = kOne;
      }
    }
  }
  const auto solution = Solve(rig, scans);
  ASSERT_TRUE(solution) << solution.error().Text();
  RigErrors errors = ErrorsAt(rig.truth, solution->calibration, 450.0);
  std::printf("[ figures  ] swapped: common %.3f mm, own errors of both %.2f and %.2f mm, %d iterations\n",
              errors.common_mm, errors.radial_mm[kOne], errors.radial_mm[kOther], solution->iterations);
  const CalibrationFinding* finding = Found(*solution, "sensor_doubtful");
  ASSERT_NE(finding, nullptr) << Codes(*solution);
  EXPECT_NE(finding->text.find(" 20"), std::string::npos) << finding->text;
  EXPECT_NE(finding->text.find(" 75"), std::string::npos) << finding->text;
  for (const Eigen::Index swapped : {kOne, kOther}) {
    errors.radial_mm[swapped] = errors.lateral_mm[swapped] = errors.vertical_mm[swapped] = 0.0;
  }
  EXPECT_LE(std::abs(errors.common_mm), 0.2);
  EXPECT_LE(RigErrors::Rms(errors.radial_mm), 0.15);
  EXPECT_LE(RigErrors::Rms(errors.lateral_mm), 450.0 * RadiansFromDegrees(0.02));
  EXPECT_LE(RigErrors::Rms(errors.vertical_mm), 450.0 * RadiansFromDegrees(0.1));
}

}  // namespace
}  // namespace annulus::test
