#include "acquisition/scan_quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "acquisition/quality_coverage.h"
#include "acquisition/quality_motion.h"
#include "sim/acting_subject.h"
#include "sim/head.h"
#include "sim/moving_subject.h"
#include "sim/person.h"
#include "tests/sim/simulated_scan.h"

namespace annulus {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

sim::BeamOptions Noiseless() {
  sim::BeamOptions options;
  options.noise_sigma_mm = 0.0;
  options.dropout_rate = 0.0;
  options.outlier_rate = 0.0;
  return options;
}

ScanPlan TorsoPlan() { return *BuiltInPlan("torso", Millimetres(1700.0)); }

/// The trunk of the simulated person, without noise; cast once.
const Scan& ExactTorso() {
  static const Scan scan = sim::SimulateScan(sim::MakePerson({}), TorsoPlan(), Noiseless(), 1);
  return scan;
}
const Scan& ExactHead() {
  static const Scan scan =
      sim::SimulateScan(sim::MakeHead({}), *BuiltInPlan("head", Millimetres(1700.0)), Noiseless(), 1);
  return scan;
}
Scan NoisyTorso(std::uint64_t seed) { return sim::NoisyCopy(ExactTorso(), {}, seed); }

std::vector<NoticeCode> CodesOf(const ScanQuality& quality) {
  std::vector<NoticeCode> codes;
  for (const QualityNotice& notice : quality.notices) codes.push_back(notice.code);
  return codes;
}

void Silence(Scan& scan, std::size_t first, std::size_t count) {
  for (ScanLevel& level : scan.levels) {
    for (std::size_t sensor = first; sensor < first + count; ++sensor) level.readings[sensor].range_mm = kNan;
  }
}

TEST(ScanQuality, S1_AStuckSensorIsFlaggedWithinTenLevelsWhileItsNeighboursMove) {
  for (const std::size_t sensor : {0UL, 47UL, 179UL}) {
    Scan scan = NoisyTorso(3);
    constexpr std::size_t kFrom = 21;
    const double value = scan.levels[kFrom].readings[sensor].range_mm = 480.0;
    for (std::size_t k = kFrom; k < scan.levels.size(); ++k) scan.levels[k].readings[sensor].range_mm = value;
    QualityMonitor monitor(scan.header);
    std::size_t flagged = 0;
    for (std::size_t k = 0; k < kFrom + 10; ++k) {
      monitor.Add(scan.levels[k]);
      if (k < kFrom + 7) {
        ASSERT_THAT(monitor.live().stuck, IsEmpty()) << k;
      }
      if (flagged == 0 && !monitor.live().stuck.empty()) flagged = k;
    }
    EXPECT_LT(flagged - kFrom, 10U);
    EXPECT_THAT(monitor.live().stuck, ElementsAre(sensor));
  }
}

TEST(ScanQuality, S1_AStuckSensorDoesNotMakeTheOneOppositeLookDead) {
  Scan scan = NoisyTorso(3);
  constexpr std::size_t kLevels = 60;
  ASSERT_GE(scan.levels.size(), kLevels);
  QualityMonitor monitor(scan.header);
  for (std::size_t k = 0; k < kLevels; ++k) {
    // Nothing lies before eleven sensors and those opposite, but two of them repeat that something does.
    for (std::size_t sensor = 35; sensor <= 45; ++sensor) {
      scan.levels[k].readings[sensor].range_mm = kNan;
      scan.levels[k].readings[sensor + 90].range_mm = kNan;
    }
    scan.levels[k].readings[40].range_mm = 480.0;
    scan.levels[k].readings[41].range_mm = 481.0;
    monitor.Add(scan.levels[k]);
  }
  EXPECT_THAT(monitor.live().stuck, ElementsAre(40U, 41U));
  EXPECT_THAT(monitor.live().dead, IsEmpty());
}

TEST(ScanQuality, S1_AFrozenBoardIsFlaggedAndItsReadingsCountForNothing) {
  Scan scan = NoisyTorso(4);
  constexpr std::size_t kFrom = 30;
  for (std::size_t k = kFrom; k < scan.levels.size(); ++k) {
    for (std::size_t sensor = 15; sensor < 30; ++sensor) {
      scan.levels[k].readings[sensor].range_mm = 450.0 + static_cast<double>(sensor);
    }
  }
  const std::vector<float> weights = QualityWeights(scan);
  ASSERT_EQ(weights.size(), scan.levels.size() * 180U);
  for (std::size_t k = 0; k < scan.levels.size(); ++k) {
    for (std::size_t sensor = 0; sensor < 180; ++sensor) {
      const bool frozen = k >= kFrom && sensor >= 15 && sensor < 30;
      ASSERT_EQ(weights[k * 180 + sensor], frozen ? 0.0F : 1.0F) << k << " " << sensor;
    }
  }
  for (const SurfaceSample& sample : BuildSamples(scan)) {
    if (sample.sensor >= 15 && sample.sensor < 30 && sample.level >= kFrom && sample.sweep == 0) {
      ASSERT_EQ(sample.weight, 0.0F);
    }
  }
}

TEST(ScanQuality, S1_ASensorThatSeesAConstantDistanceLikeItsNeighboursIsNotStuck) {
  Scan scan = ExactTorso();
  for (ScanLevel& level : scan.levels) {
    for (RangeReading& reading : level.readings) reading.range_mm = 450.0;  // a cylinder, exactly
  }
  const ScanQuality quality = AssessScan(scan);
  EXPECT_TRUE(std::none_of(quality.sensors.begin(), quality.sensors.end(), [](const auto& s) { return s.stuck; }));
}

TEST(ScanQuality, S2_AReadingOutOfRangeIsAHoleExactlyThere) {
  Scan scan = ExactTorso();
  // A patch of 8 sensors x 60 mm at the front, by every code that is no range.
  const std::array<double, 4> codes{kNan, std::numeric_limits<double>::infinity(), 0.0, -1.0};
  std::size_t next = 0;
  for (ScanLevel& level : scan.levels) {
    const double z = level.readings[0].z_mm;
    for (std::size_t sensor = 40; sensor < 48 && z > 1100.0 && z < 1160.0; ++sensor) {
      level.readings[sensor].range_mm = codes[next++ % codes.size()];
    }
  }
  const ScanQuality quality = AssessScan(scan);
  const ScanQuality whole = AssessScan(ExactTorso());
  ASSERT_EQ(quality.map.cells.size(), whole.map.cells.size());
  for (std::size_t row = 0; row < quality.map.rows; ++row) {
    const double z = quality.map.z_min + (static_cast<double>(row) + 0.5) * quality.map.row_mm;
    for (std::size_t column = 0; column < 180; ++column) {
      const bool hole = column >= 40 && column < 48 && z > 1100.0 && z < 1160.0;
      ASSERT_EQ(quality.map.At(row, column), hole ? CoverageCell::kGap : whole.map.At(row, column))
          << z << " " << column;
    }
  }
  ASSERT_EQ(quality.gaps.size(), 1U);
  EXPECT_NEAR(quality.gaps[0].z_min, 1102.5, 2.6);
  EXPECT_NEAR(quality.gaps[0].z_max, 1157.5, 2.6);
  EXPECT_EQ(RegionText(quality.gaps[0]).substr(0, 5), "front");
  EXPECT_EQ(quality.verdict, QualityVerdict::kUsable);
  for (const SurfaceSample& sample : BuildSamples(scan)) ASSERT_GT(sample.radius, 0.0);
}

TEST(ScanQuality, S3_SpikesAreCountedAndTold) {
  sim::BeamOptions beam;
  beam.outlier_rate = 0.01;
  beam.outlier_min_mm = 100.0;
  beam.outlier_max_mm = 100.0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const ScanQuality quality = AssessScan(sim::NoisyCopy(ExactTorso(), beam, seed));
    EXPECT_NEAR(quality.spike_rate, 0.01, 0.002) << seed;  // 3 sd of a binomial of 20,000 are 0.002
    EXPECT_THAT(CodesOf(quality), testing::Contains(NoticeCode::kSpikes));
    EXPECT_NEAR(quality.noise_sigma_mm, 0.5, 0.1);  // a twentieth of the differences holds a spike
  }
}

TEST(ScanQuality, S5_TheRuleForDeadSensorsIsExact) {
  EXPECT_EQ(JudgeDeadSensors({}, 180), SensorsVerdict::kGood);
  EXPECT_EQ(JudgeDeadSensors({7}, 180), SensorsVerdict::kDegraded);
  EXPECT_EQ(JudgeDeadSensors({7, 9}, 180), SensorsVerdict::kDegraded);
  EXPECT_EQ(JudgeDeadSensors({7, 8}, 180), SensorsVerdict::kRefuse);
  EXPECT_EQ(JudgeDeadSensors({0, 179}, 180), SensorsVerdict::kRefuse);
  EXPECT_EQ(JudgeDeadSensors({1, 179}, 180), SensorsVerdict::kDegraded);
  EXPECT_EQ(JudgeDeadSensors({7, 50, 90}, 180), SensorsVerdict::kRefuse);
  EXPECT_EQ(JudgeDeadSensors({7, 50, 90, 120, 150}, 180), SensorsVerdict::kRefuse);
  EXPECT_EQ(JudgeDeadSensors({7}, 180, 0), SensorsVerdict::kRefuse);
}

TEST(ScanQuality, S5_DeadSensorsAreFoundWhileScanning) {
  struct Case {
    std::vector<std::size_t> dead;
    SensorsVerdict verdict;
  };
  for (const Case& c : {Case{{47}, SensorsVerdict::kDegraded}, Case{{47, 120}, SensorsVerdict::kDegraded},
                        Case{{47, 48}, SensorsVerdict::kRefuse}, Case{{0, 30, 60, 90, 120}, SensorsVerdict::kRefuse}}) {
    Scan scan = NoisyTorso(5);
    for (const std::size_t sensor : c.dead) Silence(scan, sensor, 1);
    QualityMonitor monitor(scan.header);
    for (const ScanLevel& level : scan.levels) monitor.Add(level);
    EXPECT_EQ(monitor.live().dead, c.dead);
    EXPECT_EQ(monitor.live().sensors_verdict, c.verdict);
    const ScanQuality quality = monitor.Assess();
    EXPECT_EQ(quality.verdict,
              c.verdict == SensorsVerdict::kRefuse ? QualityVerdict::kRepeat : QualityVerdict::kUsable);
  }
}

TEST(ScanQuality, S6_ADeadBoardIsRefused) {
  Scan scan = NoisyTorso(6);
  Silence(scan, 45, 15);
  const ScanQuality quality = AssessScan(scan);
  EXPECT_EQ(quality.sensors_verdict, SensorsVerdict::kRefuse);
  for (std::size_t sensor = 0; sensor < 180; ++sensor) {
    EXPECT_EQ(quality.sensors[sensor].dead, sensor >= 45 && sensor < 60) << sensor;
  }
  EXPECT_EQ(quality.verdict, QualityVerdict::kRepeat);
  EXPECT_LT(quality.coverage, 0.93);
}

TEST(ScanQuality, EstimatesTheNoiseOfAReadingWithinATenth) {
  for (const double sigma : {0.1, 0.25, 0.5, 1.0, 2.0}) {
    sim::BeamOptions beam;
    beam.noise_sigma_mm = sigma;
    EXPECT_NEAR(AssessScan(sim::NoisyCopy(ExactTorso(), beam, 11)).noise_sigma_mm, sigma, 0.1 * sigma + 0.02) << sigma;
    EXPECT_NEAR(AssessScan(sim::NoisyCopy(ExactHead(), beam, 12)).noise_sigma_mm, sigma, 0.1 * sigma) << sigma;
  }
}

TEST(ScanQuality, CleanScansHaveNoNoticeAndKeepTheirWeights) {
  const std::uint64_t seeds = std::getenv("ANNULUS_LONG") != nullptr ? 100 : 20;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Scan head = sim::NoisyCopy(ExactHead(), {}, seed);
    const ScanQuality of_head = AssessScan(head);
    EXPECT_EQ(of_head.verdict, QualityVerdict::kGood) << seed << TextFromQuality(of_head);
    const ScanQuality of_torso = AssessScan(NoisyTorso(seed));
    EXPECT_EQ(of_torso.verdict, QualityVerdict::kGood) << seed << TextFromQuality(of_torso);
    EXPECT_THAT(QualityWeights(head), IsEmpty());
    EXPECT_THAT(QualityWeights(NoisyTorso(seed)), IsEmpty());
  }
}

TEST(ScanQuality, MeasuresARigidShiftAndTurnBetweenTwoLevels) {
  // An ellipse of 150 x 100 mm about (5, -3), moved by (12, -7) mm and turned by 3 degrees about the ring's axis.
  const QualityGrid grid(RingCalibration::Ideal(600.0));
  const auto radii_of = [](double dx, double dy, double yaw) {
    std::vector<float> radii;
    for (int i = 0; i < 180; ++i) {
      // The ray back in the ellipse's own frame: |A (t u - c)| = 1 for the largest t.
      const double theta = kTwoPi * i / 180.0;
      const Eigen::Vector2d u(std::cos(theta - yaw), std::sin(theta - yaw));
      const Eigen::Rotation2Dd back(-yaw);
      const Eigen::Vector2d c = back * Eigen::Vector2d(dx, dy) + Eigen::Vector2d(5.0, -3.0);
      const Eigen::Array2d half(150.0, 100.0);
      const Eigen::Vector2d a = u.array() / half;
      const Eigen::Vector2d b = c.array() / half;
      const double p = a.dot(b);
      radii.push_back(
          static_cast<float>((p + std::sqrt(p * p - a.squaredNorm() * (b.squaredNorm() - 1.0))) / a.squaredNorm()));
    }
    return radii;
  };
  const LevelShift shift = AlignLevel(grid, radii_of(12.0, -7.0, RadiansFromDegrees(3.0)), radii_of(0.0, 0.0, 0.0));
  EXPECT_EQ(shift.points, 180U);
  EXPECT_NEAR(shift.x, 12.0, 0.15);
  EXPECT_NEAR(shift.y, -7.0, 0.15);
  EXPECT_NEAR(DegreesFromRadians(shift.yaw), 3.0, 0.15);
  EXPECT_NEAR(shift.growth, 0.0, 0.002);
}

TEST(ScanQuality, U4_AStepAsideIsMeasuredAndTheScanIsToBeRepeated) {
  sim::StepAside step;
  step.at_s = 3.0;
  step.x_mm = 30.0;
  step.y_mm = -20.0;
  step.yaw_rad = 0.0;
  const sim::WalkingSubject subject(std::make_unique<sim::ParametricBody>(sim::MakePerson({})), step, std::nullopt);
  const ScanQuality quality = AssessScan(sim::SimulateScan(subject, TorsoPlan(), {}, 2));
  EXPECT_EQ(quality.verdict, QualityVerdict::kRepeat);
  ASSERT_EQ(quality.notices.front().code, NoticeCode::kMoved);
  EXPECT_NEAR(quality.notices.front().size, std::hypot(30.0, 20.0), 1.0);
  EXPECT_EQ(quality.notices.front().unit, "mm");
}

TEST(ScanQuality, U4_LeavingTheBoothIsSeenLive) {
  for (const double leave_s : {1.0, 3.5}) {  // in the first sweep, in the second one
    const sim::WalkingSubject subject(std::make_unique<sim::ParametricBody>(sim::MakePerson({})), std::nullopt,
                                      leave_s);
    const Scan scan = sim::SimulateScan(subject, TorsoPlan(), {}, 3);
    QualityMonitor monitor(scan.header);
    double seen_s = 0.0;
    for (const ScanLevel& level : scan.levels) {
      monitor.Add(level);
      const double now_s = static_cast<double>(level.time.count()) * 1e-9;
      if (now_s < leave_s) {
        ASSERT_FALSE(monitor.live().left);
      }
      if (seen_s == 0.0 && monitor.live().left) seen_s = now_s;
    }
    EXPECT_GT(seen_s, leave_s);
    EXPECT_LT(seen_s, leave_s + 0.25);
    EXPECT_EQ(monitor.Assess().notices.front().code, NoticeCode::kLeft);
  }
}

TEST(ScanQuality, AnEmptyBoothIsToBeRepeatedAndATinyRingIsNotJudged) {
  Scan scan = ExactTorso();
  for (ScanLevel& level : scan.levels) {
    for (RangeReading& reading : level.readings) reading.range_mm = kNan;
  }
  EXPECT_EQ(AssessScan(scan).verdict, QualityVerdict::kRepeat);
  EXPECT_THAT(AssessScan(scan).notices.front().text, HasSubstr("nothing"));
  Scan tiny;
  tiny.header.calibration = RingCalibration::Ideal(500.0, 4);
  tiny.levels.resize(3);
  EXPECT_EQ(AssessScan(tiny).verdict, QualityVerdict::kUsable);
  EXPECT_THAT(AssessScan(tiny).notices, IsEmpty());
  EXPECT_THAT(AssessScan(Scan{}).notices, IsEmpty());
}

TEST(ScanQuality, NamesARegionAsPeopleDo) {
  const auto text = [](double from_deg, double to_deg) {
    return RegionText({RadiansFromDegrees(from_deg), RadiansFromDegrees(to_deg), 1200.0, 1350.0, 1});
  };
  EXPECT_EQ(text(80.0, 100.0), "front, 1.20-1.35 m");
  EXPECT_EQ(text(85.0, 185.0), "front to left, 1.20-1.35 m");
  EXPECT_EQ(text(350.0, 370.0), "right, 1.20-1.35 m");
  EXPECT_EQ(text(180.0, 360.0), "back half, 1.20-1.35 m");
  EXPECT_EQ(text(100.0, 440.0), "all round, 1.20-1.35 m");
}

TEST(ScanQuality, TheJsonHasEveryNotice) {
  Scan scan = NoisyTorso(8);
  Silence(scan, 45, 15);
  const ScanQuality quality = AssessScan(scan);
  const auto json = nlohmann::json::parse(JsonFromQuality(quality));
  EXPECT_EQ(json.at("verdict"), "repeat");
  EXPECT_EQ(json.at("notices").size(), quality.notices.size());
  EXPECT_EQ(json.at("sensors_dead").size(), 15U);
  EXPECT_EQ(json.at("sensors_verdict"), "refuse");
  EXPECT_EQ(json.at("dropouts_by_sensor").at(45), 1.0);
  EXPECT_NEAR(json.at("noise_sigma_mm").get<double>(), 0.5, 0.05);
  EXPECT_THAT(TextFromQuality(quality), HasSubstr("repeat"));
}

}  // namespace
}  // namespace annulus
