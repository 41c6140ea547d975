// The whole calibration on the simulated booth: guided, solved, verified, written, and used again.

#include "station/calibration_job.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "station/calibration_verdict.h"
#include "station/guided_calibration.h"
#include "tests/calibration/ring_rig.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using testing::Contains;
using testing::HasSubstr;

Config ImperfectBooth() {
  Config config = SimulatedConfig();
  config.sim.ring.errors = 1.0;
  config.sim.ring.seed = 5;
  ProfileConfig coarse;  // as few levels as the ring can: 15 a second
  coarse.pitch_mm = 20.0;
  coarse.speed_mm_s = 300.0;
  config.profiles["target"] = coarse;
  return config;
}

CalibrationPlan ThreeCylinders() {
  const auto plan = ParseCalibrationPlan(R"(
technician = "T. Ester"
[[target]]
spec = "cylinder:radius_mm=150,u_mm=0.02,serial=C-150,certificate=K-4711,height_mm=1300"
[[target]]
spec = "cylinder:radius_mm=70,u_mm=0.02,serial=C-70,certificate=K-4712,height_mm=1300"
[[target]]
spec = "cylinder:radius_mm=110,u_mm=0.02,serial=C-110,certificate=K-4713,height_mm=1300"
verify = true
)",
                                         "plan");
  EXPECT_TRUE(plan) << plan.error().Text();
  return *plan;
}

/// A guided run with what was said.
struct GuidedRun {
  Result<GuidedScans> scans = tl::unexpected(Error{});
  std::vector<std::string> said;
};

GuidedRun Guide(const CalibrationPlan& plan, PlacementTaker& taker) {
  GuidedRun run;
  const CalibrationGuide guide(plan, RingCalibration::Ideal(600.0));
  const auto say = [&](const std::string& line) -> Status {
    run.said.push_back(line);
    return {};
  };
  run.scans = RunGuidedCalibration(guide, "folder", taker, say, {});
  return run;
}

GuidedRun Guide(const CalibrationPlan& plan, const Config& config) {
  test::TestStorage storage;
  BoothPlacements booth(config, storage, nullptr);
  return Guide(plan, booth);
}

CalibrationJob JobOf(const CalibrationPlan& plan, const GuidedScans& taken) {
  CalibrationJob job;
  job.plan = plan;
  job.scans = taken.scans;
  return job;
}

/// The first calibration of the booth's ring. Taken and solved once.
struct Calibrated {
  GuidedRun run;
  CalibrationJob job;
  CalibrationOutcome outcome;
};
const Calibrated& First() {
  static const Calibrated first = [] {
    Calibrated made;
    const CalibrationPlan plan = ThreeCylinders();
    made.run = Guide(plan, ImperfectBooth());
    if (!made.run.scans) throw std::runtime_error(made.run.scans.error().Text());
    made.job = JobOf(plan, *made.run.scans);
    auto outcome = Calibrate(made.job, {});
    if (!outcome) throw std::runtime_error(outcome.error().Text());
    made.outcome = std::move(*outcome);
    return made;
  }();
  return first;
}

/// The file of the first calibration, as it would be read.
CalibrationFile Written(CalibrationFile file) {
  test::TestStorage storage;
  EXPECT_TRUE(WriteCalibrationFile(storage, "CAL.json", file));
  return *ReadCalibrationFile(storage, "CAL.json");
}

TEST(GuidedCalibration, SaysWhatToDoHowItWentAndHowWellTheRingIsKnown) {
  const GuidedRun& run = First().run;
  EXPECT_EQ(run.scans->scans.size(), 10U);
  EXPECT_EQ(run.scans->files.front(), "folder/placement-1.mcap");
  EXPECT_THAT(run.said.front(), HasSubstr("placement 1 of 10: stand the cylinder of 150 mm radius (C-150)"));
  EXPECT_THAT(run.said, Contains(HasSubstr("placement 10 of 10 (verification)")));
  EXPECT_THAT(run.said, Contains("  not enough placements yet to solve"));
  EXPECT_THAT(run.said, Contains(HasSubstr("known so far: radius common to all")));
  EXPECT_THAT(run.said.back(), HasSubstr("all placements scanned in"));
  EXPECT_LT(run.scans->seconds, 600.0) << "ten minutes, on the booth's own clock";
}

TEST(GuidedCalibration, TakesTenMinutesAtMostWithTheBuiltInProfile) {
  Config config = ImperfectBooth();
  config.profiles.clear();
  CalibrationPlan plan = ThreeCylinders();
  plan.placements.resize(1);  // they all take the same time
  const GuidedRun run = Guide(plan, config);
  ASSERT_TRUE(run.scans) << run.scans.error().Text();
  EXPECT_LT(run.scans->seconds, CalibrationGuide::kStepBudget);
  EXPECT_LT(10.0 * run.scans->seconds, 600.0 - 10.0) << "and ten seconds to solve";
}

/// Hands out scans of the booth; in those of one step the target is pushed.
class PushedPlacements final : public PlacementTaker {
 public:
  PushedPlacements(int pushes)
      : still_(ImperfectBooth(), storage_, nullptr), pushed_(Pushed(), storage_, nullptr), pushes_(pushes) {}

  Result<TakenPlacement> Take(const CalibrationPlan& plan, std::size_t step, const std::string& file,
                              const TaskContext& task) override {
    ++taken;
    if (step != 0 || pushes_-- <= 0) return still_.Take(plan, step, file, task);
    return pushed_.Take(plan, step, file, task);
  }
  int taken = 0;

 private:
  static Config Pushed() {
    Config config = ImperfectBooth();
    SimTarget& target = config.sim.target.emplace();
    target.target.radius_mm = 150.0;
    target.moved.emplace();
    target.moved->at_s = 12.0;
    target.moved->lasts_s = 0.1;
    target.moved->x_mm = 2.0;
    return config;
  }
  test::TestStorage storage_;
  BoothPlacements still_;
  BoothPlacements pushed_;
  int pushes_;
};

TEST(GuidedCalibration, HasAPlacementWhoseTargetMovedScannedAgain) {
  CalibrationPlan plan = ThreeCylinders();
  plan.placements.resize(1);
  PushedPlacements taker(1);
  const GuidedRun run = Guide(plan, taker);
  ASSERT_TRUE(run.scans) << run.scans.error().Text();
  EXPECT_EQ(taker.taken, 2);
  EXPECT_THAT(run.said, Contains(HasSubstr("leave it alone and scan again")));
  EXPECT_THAT(run.said, Contains("  again, try 2 of 3"));
  EXPECT_EQ(run.scans->scans.size(), 1U);
}

TEST(GuidedCalibration, GivesUpAfterThreeTriesAndNamesThePlacement) {
  CalibrationPlan plan = ThreeCylinders();
  plan.placements.resize(1);
  PushedPlacements taker(9);
  const GuidedRun run = Guide(plan, taker);
  ASSERT_FALSE(run.scans);
  EXPECT_EQ(taker.taken, 3);
  EXPECT_THAT(run.scans.error().seen, HasSubstr("placement 1 did not succeed in 3 tries: it moved by"));
}

TEST(CalibrationGuide, SaysThatATargetStandsElsewhere) {
  const CalibrationPlan plan = ThreeCylinders();
  const CalibrationGuide guide(plan, RingCalibration::Ideal(600.0));
  // The scan of the second placement, held against what the third one asks for.
  const TargetScan scan = TargetScanOf(First().job.scans[1], plan.placements[1], "2", 20.0);
  EXPECT_TRUE(guide.Check(1, scan).good);
  const PlacementCheck check = guide.Check(2, scan);
  EXPECT_FALSE(check.good);
  ASSERT_FALSE(check.problems.empty());
  EXPECT_THAT(check.problems.front(), HasSubstr("from where it was asked for: move it and scan again"));
  // Upright instead of tilted.
  const TargetScan upright = TargetScanOf(First().job.scans[0], plan.placements[0], "1", 20.0);
  CalibrationPlan tilted = plan;
  tilted.placements[0].tilt_deg = 7.0;
  const CalibrationGuide other(tilted, RingCalibration::Ideal(600.0));
  EXPECT_THAT(other.Check(0, upright).problems.front(), HasSubstr("instead of about 7: tilt it and scan again"));
}

TEST(CalibrationGuide, SaysThatNoTargetIsThere) {
  const CalibrationGuide guide(ThreeCylinders(), RingCalibration::Ideal(600.0));
  const PlacementCheck check = guide.Check(0, TargetScan{});
  EXPECT_FALSE(check.good);
  EXPECT_EQ(check.problems.size(), 1U);
}

TEST(Calibrate, PassesAndSaysEverythingOfItself) {
  const CalibrationOutcome& outcome = First().outcome;
  std::string failing;
  for (const LimitLine& line : JudgeCalibration(outcome.report)) {
    if (line.left_verdict() == LimitLine::Verdict::kFail) failing += line.name + "; ";
  }
  EXPECT_TRUE(outcome.passed) << failing;
  const CalibrationFile& file = outcome.file;
  EXPECT_TRUE(file.traceable);
  EXPECT_EQ(file.boards.size(), 12U);
  EXPECT_EQ(file.recordings.size(), 10U);
  EXPECT_EQ(file.recordings.front(), ScanHash(First().job.scans.front()));
  EXPECT_EQ(file.targets.size(), 3U);
  EXPECT_EQ(file.technician, "T. Ester");
  EXPECT_EQ(file.calibration.ring_serial, RingSerialOf(file.boards));
  EXPECT_EQ(file.valid_until_ns - file.wall_ns, 90 * 86'400'000'000'000);
  EXPECT_TRUE(CheckCalibrationFor(file, file.boards, file.wall_ns));
  // All scans at one temperature: it is that one's, and how the ranges change with it is not known.
  EXPECT_NEAR(file.calibration.reference_c, 31.0, 1.0);
  EXPECT_EQ(file.calibration.range_mm_per_c, 0.0);
  EXPECT_THAT(file.unobservable, Contains("temperature coefficient"));
}

TEST(Calibrate, FindsTheRingThatWasDrawn) {
  const auto truth = SimulatedRing(ImperfectBooth().sim.ring, 600.0, 1);
  ASSERT_TRUE(truth);
  const RingCalibration& found = First().outcome.file.calibration;
  for (const double distance : {250.0, 350.0, 450.0, 530.0}) {
    const test::RigErrors errors = test::ErrorsAt(*truth, found, distance);
    EXPECT_NEAR(errors.common_mm, 0.0, 0.1 + 0.02) << distance;
    EXPECT_LE(test::RigErrors::Rms(errors.radial_mm), 0.15) << distance;
  }
  const test::RigErrors errors = test::ErrorsAt(*truth, found, 450.0);
  EXPECT_LE(DegreesFromRadians(test::RigErrors::Rms(errors.lateral_mm) / 450.0), 0.05);
  EXPECT_LE(DegreesFromRadians(test::RigErrors::Rms(errors.vertical_mm) / 450.0), 0.2);
  const test::RigErrors before = test::ErrorsAt(*truth, RingCalibration::Ideal(600.0), 450.0);
  EXPECT_GT(test::RigErrors::Rms(before.radial_mm), 1.0);
}

TEST(Calibrate, VerifiesWithWhatTookNoPartInTheSolve) {
  const auto& verification = First().outcome.report.verification;
  ASSERT_TRUE(verification);
  EXPECT_EQ(verification->target.serial, "C-110");
  EXPECT_NEAR(verification->found_radius_mm, 110.0, 0.1);
  EXPECT_LE(std::abs(verification->En()), 1.0);
  EXPECT_EQ(First().outcome.solution.placements.size(), 9U);
}

TEST(Calibrate, ASecondCalibrationSaysWhatWasAsFoundAndKeepsTheHistory) {
  CalibrationJob job = First().job;
  job.previous = Written(First().outcome.file);
  job.previous->history.push_back({"sha256:older", 1, 0.5, 0.25, true});
  // Something moved since: sensor 20 reads 0.5 mm longer by then.
  job.previous->calibration.sensors[20].range_offset_mm += 0.5;
  const auto second = Calibrate(job, {});
  ASSERT_TRUE(second) << second.error().Text();
  ASSERT_TRUE(second->report.as_found);
  EXPECT_NEAR(second->report.as_found->common_mm, 0.0, 0.02);
  EXPECT_NEAR(std::abs(second->report.as_found->radial_mm[20]), 0.5, 0.05);
  EXPECT_NEAR(second->report.as_found->radial_mm[100], 0.0, 0.05);
  ASSERT_EQ(second->file.history.size(), 2U);
  EXPECT_EQ(second->file.history[0].hash, "sha256:older");
  EXPECT_EQ(second->file.history[1].hash, job.previous->calibration.certificate);
  // One sensor of 180 by 0.5 mm.
  EXPECT_NEAR(second->file.history[1].sensor_shift_mm, 0.5 / std::sqrt(180.0), 0.01);
}

TEST(Calibrate, AReplacedBoardIsCalibratedAloneInTheRingAroundIt) {
  // As if board 1004 had been another one before: its seven numbers per sensor are worthless.
  CalibrationJob job = First().job;
  job.previous = Written(First().outcome.file);
  const std::int64_t expires = job.previous->valid_until_ns - 1;
  job.previous->valid_until_ns = expires;
  for (std::size_t i = 45; i < 60; ++i) job.previous->calibration.sensors[i].range_offset_mm += 3.0;
  job.previous->boards[3].serial = 999;
  job.board = 1004;
  const auto alone = Calibrate(job, {});
  ASSERT_TRUE(alone) << alone.error().Text();
  const RingCalibration& found = alone->file.calibration;
  const RingCalibration& whole = First().outcome.file.calibration;
  for (std::size_t i = 0; i < 180; ++i) {
    if (i >= 45 && i < 60) {
      const double reading = whole.sensors[i].ReadingOf(450.0);
      EXPECT_LT((found.PointOf(i, 600.0, reading) - whole.PointOf(i, 600.0, reading)).norm(), 1.0) << i;
    } else {
      EXPECT_EQ(found.sensors[i], job.previous->calibration.sensors[i]) << i;
    }
  }
  ASSERT_TRUE(found.uncertainty);
  for (std::size_t i = 0; i < 180; ++i) EXPECT_GT(found.uncertainty->own_mm[i], 0.0) << i;
  EXPECT_LE(alone->file.valid_until_ns, expires) << "the rest of the ring is no younger than it was";
  EXPECT_EQ(alone->file.boards[3].serial, 1004U);
}

TEST(Calibrate, ABoardAloneNeedsTheRingAroundIt) {
  CalibrationJob job = First().job;
  job.board = 1004;
  EXPECT_THAT(Calibrate(job, {}).error().advice, HasSubstr("--previous"));
  job.previous = Written(First().outcome.file);
  job.board = 77;
  EXPECT_THAT(Calibrate(job, {}).error().seen, HasSubstr("board 77 is not in the ring"));
  job.board = 1004;
  job.previous->boards[7].serial = 999;
  EXPECT_THAT(Calibrate(job, {}).error().seen, HasSubstr("board 1008 is not in its place"));
}

TEST(Calibrate, RefusesThePreviousCalibrationOfAnotherRing) {
  CalibrationJob job = First().job;
  job.previous = Written(First().outcome.file);
  job.previous->calibration = RingCalibration::Ideal(600.0, 120);
  EXPECT_THAT(Calibrate(job, {}).error().seen, HasSubstr("of 120 sensors, the ring has 180"));
  job.previous = Written(First().outcome.file);
  for (RecordedBoard& board : job.previous->boards) board.serial += 5000;
  EXPECT_THAT(Calibrate(job, {}).error().seen, HasSubstr("of another ring"));
}

TEST(Calibrate, RefusesScansOfDifferentRings) {
  CalibrationJob job = First().job;
  job.scans[3].header.machine.boards[2].serial = 4711;
  EXPECT_THAT(Calibrate(job, {}).error().seen, HasSubstr("a board was changed between them"));
  job = First().job;
  job.scans.pop_back();
  EXPECT_THAT(Calibrate(job, {}).error().seen, HasSubstr("9 scans for 10 placements"));
}

TEST(Calibrate, NamesTwoChannelsThatAreExchangedAndDoesNotPass) {
  CalibrationJob job = First().job;
  for (Scan& scan : job.scans) {
    for (ScanLevel& level : scan.levels) std::swap(level.readings[48], level.readings[51]);
  }
  const auto swapped = Calibrate(job, {});
  ASSERT_TRUE(swapped) << swapped.error().Text();
  EXPECT_FALSE(swapped->passed);
  const CalibrationFinding& finding = swapped->solution.findings.front();
  EXPECT_EQ(finding.code, "channels_swapped");
  EXPECT_EQ(finding.grade, CalibrationFinding::Grade::kFailure);
  EXPECT_EQ(finding.text, "board 1004: channels 3 and 6 are exchanged (sensors 48 and 51)");
}

TEST(Calibrate, AWrongTargetRadiusIsNamedByTheSecondArtefact) {
  // All certificates but the verification's say 0.3 mm too much.
  CalibrationJob job = First().job;
  job.plan.targets[0].radius_mm += 0.3;
  job.plan.targets[1].radius_mm += 0.3;
  const auto wrong = Calibrate(job, {});
  ASSERT_TRUE(wrong) << wrong.error().Text();
  ASSERT_TRUE(wrong->report.verification);
  EXPECT_NEAR(wrong->report.verification->found_radius_mm - 110.0, 0.3, 0.1);
  EXPECT_GT(std::abs(wrong->report.verification->En()), 1.0);
  EXPECT_FALSE(wrong->passed);
}

}  // namespace
}  // namespace annulus
