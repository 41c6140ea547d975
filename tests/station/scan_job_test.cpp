#include "station/scan_job.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "acquisition/recording.h"
#include "modeling/mesh/mesh_io.h"
#include "station/sim_subject.h"

namespace annulus {
namespace {

using testing::HasSubstr;

class ScanJob : public testing::Test {
 protected:
  void SetUp() override {
    const auto folder =
        std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    folder_ = folder.string();
    ProfileConfig belt;
    belt.z_top_mm = 1100.0;
    belt.z_bottom_mm = 1000.0;
    belt.pitch_mm = 10.0;
    belt.speed_mm_s = 300.0;
    config_.profiles["belt"] = belt;
  }
  [[nodiscard]] std::string Path(const std::string& name) const { return folder_ + "/" + name; }

  Config config_ = SimulatedConfig();
  PosixStorage storage_;
  std::string folder_;
};

TEST_F(ScanJob, WritesARecordingThatSaysEverythingOfItself) {
  config_.station_id = "booth-3";
  config_.sim.seed = 9;
  const auto outcome = RunScanJob(config_, {"belt", Path("scan.mcap"), "p-17", "c-4"}, storage_, {});
  ASSERT_TRUE(outcome) << outcome.error().Text();
  EXPECT_TRUE(outcome->recorded);
  EXPECT_EQ(outcome->summary.missing_levels, 0U);
  const auto recording = ReadWholeRecording(storage_, Path("scan.mcap"));
  ASSERT_TRUE(recording) << recording.error().Text();
  EXPECT_TRUE(recording->report.clean());
  EXPECT_FALSE(recording->axis.empty());
  const ScanHeader& header = recording->scan.header;
  EXPECT_EQ(header.station_id, "booth-3");
  EXPECT_EQ(header.source, "body");
  EXPECT_EQ(header.subject_id, "p-17");
  EXPECT_EQ(header.consent_reference, "c-4");
  EXPECT_EQ(header.profile, "belt");
  EXPECT_THAT(header.plan_json, HasSubstr("\"pitch_mm\""));
  EXPECT_EQ(header.seed, 9U);
  EXPECT_EQ(header.ring_radius_mm, 600.0);
  EXPECT_EQ(header.calibration.sensors.size(), 180U);
  EXPECT_GE(header.wall_start_ns, ManualClock::kWallStart.count());
  EXPECT_EQ(recording->scan.levels.size(), outcome->summary.levels);
}

TEST_F(ScanJob, TheSameSeedGivesTheSameBytesAndAnotherSeedOthers) {
  ASSERT_TRUE(RunScanJob(config_, {"belt", Path("a.mcap"), "", ""}, storage_, {}));
  ASSERT_TRUE(RunScanJob(config_, {"belt", Path("b.mcap"), "", ""}, storage_, {}));
  config_.sim.seed = 2;
  ASSERT_TRUE(RunScanJob(config_, {"belt", Path("c.mcap"), "", ""}, storage_, {}));
  const auto a = storage_.ReadAll(Path("a.mcap"), kMaxInputBytes);
  EXPECT_EQ(*a, *storage_.ReadAll(Path("b.mcap"), kMaxInputBytes));
  EXPECT_NE(*a, *storage_.ReadAll(Path("c.mcap"), kMaxInputBytes));
}

TEST_F(ScanJob, AnAdjustedPlanSaysWhyInItsRecording) {
  config_.profiles["belt"].speed_mm_s = 900.0;  // the simulated machine allows 300
  const auto outcome = RunScanJob(config_, {"belt", Path("scan.mcap"), "", ""}, storage_, {});
  ASSERT_TRUE(outcome) << outcome.error().Text();
  ASSERT_FALSE(outcome->adjusted.empty());
  EXPECT_EQ(outcome->plan.speed_mm_s, 300.0);
  const auto recording = ReadWholeRecording(storage_, Path("scan.mcap"));
  ASSERT_TRUE(recording);
  ASSERT_FALSE(recording->events.empty());
  EXPECT_THAT(recording->events.front().text, HasSubstr(outcome->adjusted.front()));
}

TEST_F(ScanJob, AnImpossiblePlanIsRefusedWithItsReasonAndLeavesNothing) {
  config_.profiles["belt"].z_top_mm = 900.0;  // below its bottom
  const auto outcome = RunScanJob(config_, {"belt", Path("scan.mcap"), "", ""}, storage_, {});
  ASSERT_FALSE(outcome);
  EXPECT_THAT(outcome.error().Text(), HasSubstr("z_top_mm"));
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(ScanJob, AProfileOfItsOwnMustGiveItsLengths) {
  config_.profiles["belt"].pitch_mm.reset();
  const auto outcome = RunScanJob(config_, {"belt", Path("scan.mcap"), "", ""}, storage_, {});
  ASSERT_FALSE(outcome);
  EXPECT_THAT(outcome.error().Text(), HasSubstr("pitch_mm"));
  const auto unknown = RunScanJob(config_, {"nobody", Path("scan.mcap"), "", ""}, storage_, {});
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().Text(), HasSubstr("nobody"));
}

TEST_F(ScanJob, AStopRequestWhileScanningKeepsWhatWasTaken) {
  std::stop_source stop;
  TaskContext task;
  task.stop = stop.get_token();
  task.progress = [&](std::string_view stage, double done, double) {
    if (stage == "scan" && done >= 4.0) stop.request_stop();
  };
  const auto outcome = RunScanJob(config_, {"belt", Path("scan.mcap"), "", ""}, storage_, task);
  ASSERT_TRUE(outcome) << outcome.error().Text();
  EXPECT_TRUE(outcome->summary.cancelled);
  const auto recording = ReadWholeRecording(storage_, Path("scan.mcap"));
  ASSERT_TRUE(recording) << recording.error().Text();
  EXPECT_TRUE(recording->report.finished);
  EXPECT_GE(recording->scan.levels.size(), 4U);
}

TEST_F(ScanJob, AMeshFileCanStandInTheBooth) {
  // A box 200 mm x 100 mm, 1700 high, y up in the file: half its width is seen from the subject's right.
  TriangleMesh box;
  for (const double y : {0.0, 1.7}) {
    box.vertices.insert(box.vertices.end(), {{-0.1, y, -0.05}, {0.1, y, -0.05}, {0.1, y, 0.05}, {-0.1, y, 0.05}});
  }
  box.faces = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}, {0, 5, 1}, {0, 4, 5},
               {1, 6, 2}, {1, 5, 6}, {2, 7, 3}, {2, 6, 7}, {3, 4, 0}, {3, 7, 4}};
  ASSERT_TRUE(WriteFileAtomically(storage_, Path("box.obj"), WriteObj(box)));
  config_.sim.subject = Path("box.obj");
  config_.sim.subject_scale = 1000.0;
  config_.sim.subject_y_up = true;
  config_.sim.noise_mm = 0.0;
  config_.sim.outlier_rate = 0.0;
  config_.sim.dropout_rate = 0.0;
  const auto outcome = RunScanJob(config_, {"belt", Path("scan.mcap"), "", ""}, storage_, {});
  ASSERT_TRUE(outcome) << outcome.error().Text();
  const auto scan = ReadRecording(storage_, Path("scan.mcap"));
  ASSERT_TRUE(scan);
  EXPECT_EQ(scan->header.source, "box");
  for (const ScanLevel& level : scan->levels) {
    EXPECT_NEAR(level.readings[0].range_mm, 600.0 - 100.0, 0.2);  // theta 0
    EXPECT_NEAR(level.readings[45].range_mm, 600.0 - 50.0, 0.2);  // theta 90 degrees
  }
}

TEST_F(ScanJob, SpectaclesNeedAFaceThatIsKnown) {
  config_.sim.subject = "bust.obj";
  config_.sim.spectacles = true;
  const auto outcome = RunScanJob(config_, {"belt", Path("scan.mcap"), "", ""}, storage_, {});
  ASSERT_FALSE(outcome);
  EXPECT_THAT(outcome.error().Text(), HasSubstr("spectacles"));
}

TEST_F(ScanJob, ATargetIsScannedByTheRingThatWasDrawn) {
  config_.sim.noise_mm = config_.sim.outlier_rate = config_.sim.dropout_rate = 0.0;
  config_.sim.ring.errors = 1.0;
  config_.sim.ring.seed = 12;
  config_.sim.ring.tilt_rad = 0.01;
  config_.sim.ring.temperature_c = 26.0;
  config_.sim.ring.range_mm_per_c = 0.02;
  SimTarget& target = config_.sim.target.emplace();
  target.target.radius_mm = 75.0;
  target.target.height_mm = 1300.0;
  target.truth.radius_mm = 75.1;
  target.placement.x_mm = 90.0;
  const auto outcome = RunScanJob(config_, {"belt", Path("scan.mcap"), "", ""}, storage_, {});
  ASSERT_TRUE(outcome) << outcome.error().Text();
  const auto scan = ReadRecording(storage_, Path("scan.mcap"));
  ASSERT_TRUE(scan) << scan.error().Text();
  EXPECT_EQ(scan->header.source, "cylinder");
  EXPECT_EQ(scan->header.calibration.sensors, RingCalibration::Ideal(600.0).sensors);  // nobody has calibrated it
  ASSERT_TRUE(scan->header.machine.ring_temperature_c);
  EXPECT_NEAR(*scan->header.machine.ring_temperature_c, 26.0, 0.5);
  const auto ring = SimulatedRing(config_.sim.ring, 600.0, config_.sim.seed);
  ASSERT_TRUE(ring);
  EXPECT_EQ(ring->ring_serial, "SIM-RING-12");
  const RingCalibration warm = ring->AtTemperature(26.0);
  std::size_t returns = 0;
  for (const ScanLevel& level : scan->levels) {
    for (std::size_t sensor = 0; sensor < level.readings.size(); ++sensor) {
      const RangeReading& reading = level.readings[sensor];
      if (!std::isfinite(reading.range_mm) || reading.quality < 100) continue;
      const Eigen::Vector3d p = warm.PointOf(sensor, reading.z_mm, reading.range_mm);
      // Upright: heights do not matter. A spot of 2 mm sees a little more than its middle.
      EXPECT_NEAR((p.head<2>() - Eigen::Vector2d(90.0, 0.0)).norm(), 75.1, 0.02);
      ++returns;
    }
  }
  EXPECT_GT(returns, 50 * scan->levels.size());
}

TEST_F(ScanJob, ATargetThatHalfOfTheSensorsDoNotSeeIsScannedToTheEnd) {
  SimTarget& target = config_.sim.target.emplace();
  target.target.radius_mm = 60.0;
  target.placement.x_mm = 120.0;  // beams towards the axis that pass it more than 60 mm beside meet nothing
  ProfileConfig low = config_.profiles["belt"];
  low.z_top_mm = 900.0;
  low.z_bottom_mm = 200.0;
  low.of_target = true;
  config_.profiles["target"] = low;
  config_.sim.ring.errors = 1.0;
  const auto outcome = RunScanJob(config_, {"target", Path("scan.mcap"), "", ""}, storage_, {});
  ASSERT_TRUE(outcome) << outcome.error().Text();
  EXPECT_EQ(outcome->summary.missing_levels, 0U);
  EXPECT_GT(outcome->summary.no_returns, outcome->summary.returns);
  ASSERT_TRUE(outcome->quality);
  EXPECT_EQ(outcome->quality->verdict, QualityVerdict::kGood);
  low.of_target = false;
  config_.profiles["mine"] = low;
  const auto person = RunScanJob(config_, {"mine", Path("other.mcap"), "", ""}, storage_, {});
  ASSERT_FALSE(person);
  EXPECT_THAT(person.error().Text(), HasSubstr("too many sensors see nothing"));
}

TEST_F(ScanJob, ATargetDoesNotBreathe) {
  config_.sim.target.emplace().target.radius_mm = 150.0;
  config_.sim.breathing = 0.01;
  const auto outcome = RunScanJob(config_, {"belt", Path("scan.mcap"), "", ""}, storage_, {});
  ASSERT_FALSE(outcome);
  EXPECT_THAT(outcome.error().Text(), HasSubstr("sim.breathing"));
}

TEST_F(ScanJob, ATargetThatIsPushedStandsElsewhereAfterwards) {
  config_.sim.noise_mm = config_.sim.outlier_rate = config_.sim.dropout_rate = 0.0;
  SimTarget& target = config_.sim.target.emplace();
  target.target.radius_mm = 150.0;
  target.target.height_mm = 1300.0;
  const auto still = RunScanJob(config_, {"belt", Path("a.mcap"), "", ""}, storage_, {});
  ASSERT_TRUE(still) << still.error().Text();
  const auto before = ReadRecording(storage_, Path("a.mcap"));
  ASSERT_TRUE(before);
  const auto middle = before->levels[before->levels.size() / 2].time;
  target.moved.emplace();
  target.moved->at_s = std::chrono::duration<double>(middle).count();
  target.moved->lasts_s = 0.01;
  target.moved->x_mm = 3.0;
  target.moved->yaw_rad = 0.0;
  ASSERT_TRUE(RunScanJob(config_, {"belt", Path("b.mcap"), "", ""}, storage_, {}));
  const auto after = ReadRecording(storage_, Path("b.mcap"));
  ASSERT_TRUE(after);
  EXPECT_NEAR(after->levels.front().readings[0].range_mm, 450.0, 0.01);
  EXPECT_NEAR(after->levels.back().readings[0].range_mm, 447.0, 0.01);
}

TEST(SimSubject, DressAndMotionChangeWhatABeamMeets) {
  PosixStorage storage;
  SimConfig plain;
  plain.subject = "head";
  SimConfig dressed = plain;
  dressed.hair = dressed.dark_patches = dressed.spectacles = true;
  SimConfig moving = plain;
  moving.sway = 1.0;
  const auto bare = MakeSimSubject(plain, storage);
  const auto hairy = MakeSimSubject(dressed, storage);
  const auto swaying = MakeSimSubject(moving, storage);
  ASSERT_TRUE(bare && hairy && swaying);
  const Ray to_back_of_head{{0.0, -600.0, (*bare)->top_mm() - 60.0}, {0.0, 1.0, 0.0}};
  const auto skin = (*bare)->Cast(to_back_of_head, 5.0, 1200.0);
  const auto hair = (*hairy)->Cast(to_back_of_head, 5.0, 1200.0);
  const auto swayed = (*swaying)->Cast(to_back_of_head, 5.0, 1200.0);
  ASSERT_TRUE(skin && hair && swayed);
  EXPECT_LT(hair->distance_mm, skin->distance_mm);
  EXPECT_LT(hair->reflectance, skin->reflectance);
  EXPECT_GT(std::abs(swayed->distance_mm - skin->distance_mm), 0.05);
}

}  // namespace
}  // namespace annulus
