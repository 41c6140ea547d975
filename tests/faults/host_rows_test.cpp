// Rows H: the host.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

#include "tests/faults/judge.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

constexpr milliseconds kDrop{250};
constexpr ScanState kAllStates[] = {ScanState::kSafe,     ScanState::kIdle,     ScanState::kHoming, ScanState::kArmed,
                                    ScanState::kScanning, ScanState::kStopping, ScanState::kFault,  ScanState::kJog};
constexpr ScanState kMovingStates[] = {ScanState::kHoming, ScanState::kScanning, ScanState::kJog};

/// The enable relay's instant contact, after `from`; it is off at once in states without enable.
nanoseconds DropAfter(FaultRig& rig, nanoseconds from) {
  const auto off = WhenSignal(rig, sim::ChainSignal::kQuickStopInput, false, from);
  return off ? *off - from : nanoseconds::max();
}

TEST(FaultMatrix, H1_AKilledProgramDropsEnableAndBeginsInSafeWithItsRecordingKept) {
  nanoseconds drop{0};
  nanoseconds safe{0};
  for (const ScanState state : kAllStates) {
    for (const milliseconds after : {milliseconds(0), milliseconds(17), milliseconds(450)}) {
      FaultRig rig;
      ASSERT_TRUE(rig.BringTo(state)) << rig.Told();
      rig.Pass(after);
      const nanoseconds killed = rig.Now();
      rig.Kill();
      rig.Pass(milliseconds(700));
      EXPECT_LE(DropAfter(rig, killed), kDrop) << ScanStateText(state);
      drop = std::max(drop, DropAfter(rig, killed));
      safe = std::max(safe, TimeToSafe(rig, killed));
      const std::size_t motions = rig.drive().motion_log().size();
      ASSERT_TRUE(rig.Restart());
      EXPECT_EQ(rig.state(), ScanState::kSafe);
      rig.Pass(seconds(2));
      EXPECT_EQ(rig.drive().motion_log().size(), motions);
      // Nothing is shown: the new program has seen nothing; the interrupted recording is found by the store.
      if (state == ScanState::kFault) {
        EXPECT_EQ(JudgeRecording(rig, "scan.mcap") + rig.NextScan(), "") << rig.Told();
      } else {
        EXPECT_EQ(JudgeRun(rig, {}), "") << ScanStateText(state) << " + " << InMs(after);
      }
    }
  }
  ReportTimeToSafe(safe);
  ReportNote("enable dropped after at most " + InMs(drop));
}

TEST(FaultMatrix, H2_AProgramThatStoodStillWakesInSafeAndResumesNothing) {
  nanoseconds drop{0};
  nanoseconds safe{0};
  for (const bool worker_first : {false, true}) {
    for (const ScanState state : kAllStates) {
      for (const milliseconds after : {milliseconds(0), milliseconds(30)}) {
        FaultRig rig;
        ASSERT_TRUE(rig.BringTo(state)) << rig.Told();
        rig.Pass(after);
        const nanoseconds hung = rig.Now();
        const std::size_t motions = rig.drive().motion_log().size();
        worker_first ? rig.HangWorkerFirst(seconds(5)) : rig.Hang(seconds(5));
        ASSERT_TRUE(rig.RunUntil([&] { return rig.Now() > hung + milliseconds(5200); }, seconds(6)));
        const std::string where = std::string(ScanStateText(state)) + (worker_first ? ", worker first" : "");
        EXPECT_EQ(rig.state(), ScanState::kSafe) << where << rig.Told();
        EXPECT_LE(DropAfter(rig, hung), kDrop) << where;
        drop = std::max(drop, DropAfter(rig, hung));
        safe = std::max(safe, TimeToSafe(rig, hung));
        rig.Pass(seconds(2));
        EXPECT_EQ(rig.drive().motion_log().size(), motions) << where;
        Expected expected{{CauseCode::kHostHang}};
        if (state == ScanState::kFault) expected.causes = {CauseCode::kAxisFault};
        EXPECT_EQ(JudgeRun(rig, expected), "") << where;
      }
    }
  }
  ReportTimeToSafe(safe);
  ReportNote("enable dropped after at most " + InMs(drop));
}

TEST(FaultMatrix, H3_AControlTickThatIsLateStopsAndIsNamed) {
  nanoseconds safe{0};
  for (const ScanState state : kMovingStates) {
    for (const int late_ms : {25, 40, 80, 150, 190, 250, 500}) {
      FaultRig rig;
      ASSERT_TRUE(rig.BringTo(state)) << rig.Told();
      rig.Pass(milliseconds(30));
      const nanoseconds began = rig.Now();
      rig.DelayTicks(milliseconds(late_ms));
      rig.Pass(milliseconds(late_ms + 600));
      const std::string where = std::string(ScanStateText(state)) + ", " + std::to_string(late_ms) + " ms";
      EXPECT_THAT(rig.state(), testing::AnyOf(ScanState::kFault, ScanState::kSafe)) << where;
      safe = std::max(safe, TimeToSafe(rig, began) - milliseconds(late_ms));
      // The worker may notice it before the tick comes, and says "late" when it is not a hang yet.
      Expected expected{{CauseCode::kHostLate}};
      if (late_ms > 200) expected.causes.push_back(CauseCode::kHostHang);
      EXPECT_EQ(JudgeRun(rig, expected), "") << where;
    }
  }
  EXPECT_LE(safe, milliseconds(500));
  ReportTimeToSafe(safe);
}

TEST(FaultMatrix, H3_ThreeTicksThatAreALittleLateAreAWarningAndStopNothing) {
  FaultRig rig;
  ASSERT_TRUE(rig.BringTo(ScanState::kScanning));
  for (int i = 0; i < 3; ++i) {
    rig.SkipTicks(1);  // 20 ms from one to the next: late, and just not too late
    rig.Pass(milliseconds(100));
  }
  EXPECT_THAT(rig.status().warnings, testing::Contains(testing::Field(&ScanWarning::code, WarningCode::kTicksLate)));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.status().scan.has_value(); })) << rig.Told();
  EXPECT_TRUE(rig.status().scan->complete) << rig.Told();
  EXPECT_EQ(JudgeRun(rig, {}), "");
}

TEST(FaultMatrix, H5_ADeadWorkerDropsEnableInTimeAndIsNamed) {
  nanoseconds drop{0};
  nanoseconds safe{0};
  for (const ScanState state : kMovingStates) {
    for (const milliseconds after : {milliseconds(0), milliseconds(13), milliseconds(60), milliseconds(400)}) {
      FaultRig rig;
      ASSERT_TRUE(rig.BringTo(state)) << rig.Told();
      const nanoseconds until = rig.Now() + after;
      static_cast<void>(rig.RunUntil([&] {
        if (state == ScanState::kJog) static_cast<void>(rig.Jog(Scanner::JogDirection::kDown));
        return rig.Now() >= until;
      }));
      const nanoseconds died = rig.Now();
      rig.KillWorker();
      // One that had no power yet, and so no enable to drop, is missed later.
      static_cast<void>(rig.RunUntil([&] { return !rig.status().causes.empty(); }, seconds(7)));
      rig.Pass(seconds(1));
      EXPECT_LE(DropAfter(rig, died), kDrop) << ScanStateText(state) << " + " << InMs(after);
      drop = std::max(drop, DropAfter(rig, died));
      safe = std::max(safe, TimeToSafe(rig, died));
      // A jog that nobody holds any more is stopped before that.
      EXPECT_EQ(JudgeCause(rig, {{CauseCode::kThreadDead, CauseCode::kStopOverdue}}), "")
          << ScanStateText(state) << rig.Told();
      EXPECT_EQ(JudgeRest(rig), "");
      ASSERT_TRUE(rig.Restart());
      EXPECT_EQ(JudgeRecording(rig, "scan.mcap") + rig.NextScan(), "");
      EXPECT_THAT(rig.watch().violations(), testing::IsEmpty()) << rig.Told();
    }
  }
  ReportTimeToSafe(safe);
  ReportNote("worker dead: enable dropped after at most " + InMs(drop));
}

TEST(FaultMatrix, H5_ADeadControlThreadDropsEnableInTime) {
  nanoseconds drop{0};
  nanoseconds safe{0};
  for (const ScanState state : kMovingStates) {
    FaultRig rig;
    ASSERT_TRUE(rig.BringTo(state)) << rig.Told();
    rig.Pass(milliseconds(40));
    const nanoseconds died = rig.Now();
    rig.KillControl();
    rig.Pass(seconds(1));
    EXPECT_LE(DropAfter(rig, died), kDrop) << ScanStateText(state);
    drop = std::max(drop, DropAfter(rig, died));
    safe = std::max(safe, TimeToSafe(rig, died));
    rig.Kill();
    ASSERT_TRUE(rig.Restart());
    EXPECT_EQ(JudgeRest(rig) + JudgeRecording(rig, "scan.mcap") + rig.NextScan(), "") << ScanStateText(state);
  }
  ReportTimeToSafe(safe);
  ReportNote("control thread dead: enable dropped after at most " + InMs(drop));
}

TEST(FaultMatrix, H6_AWallClockThatJumpsTripsNothingAndIsNoted) {
  for (const auto jump : {std::chrono::hours(1), std::chrono::hours(-1)}) {
    FaultRig rig;
    ASSERT_TRUE(rig.Operate([&] { return rig.levels("scan.mcap") >= 10; })) << rig.Told();
    rig.wall().JumpWall(jump);
    ASSERT_TRUE(rig.RunUntil([&] { return rig.status().scan.has_value(); })) << rig.Told();
    EXPECT_TRUE(rig.status().scan->complete) << rig.Told();
    const auto file = ReadWholeRecording(rig.storage(), "scan.mcap");
    ASSERT_TRUE(file) << file.error().Text();
    EXPECT_TRUE(std::any_of(file->events.begin(), file->events.end(), [](const RecordedEvent& event) {
      return event.text.find("wall clock") != std::string::npos;
    }));
    EXPECT_EQ(JudgeRun(rig, {}), "");
  }
}

TEST(FaultMatrix, H8_WithTwoThousandFilesOpenAScanIsAScan) {
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
  const rlimit before = limit;
  limit.rlim_cur = std::min<rlim_t>(4096, limit.rlim_max);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0);
  std::vector<int> files;
  for (int i = 0; i < 2000; ++i) files.push_back(open("/dev/null", O_RDONLY | O_CLOEXEC));
  EXPECT_EQ(std::count(files.begin(), files.end(), -1), 0);
  {
    const ProcessUse use = UseOfProcess();
    {
      FaultRig rig;
      ASSERT_TRUE(rig.Operate([&] { return rig.status().scan.has_value(); })) << rig.Told();
      EXPECT_TRUE(rig.status().scan->complete) << rig.Told();
      EXPECT_EQ(JudgeRun(rig, {}), "");
    }
    EXPECT_EQ(UseOfProcess(), use);
  }
  for (const int file : files) close(file);
  EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
}

TEST(FaultMatrix, H9_AHotComputerIsNotArmedAndSaysSo) {
  auto hot = std::make_shared<bool>(true);
  FaultRigOptions options = FaultRig::Defaults();
  options.scanner.host_checks = [hot] {
    std::vector<ArmCheck> checks;
    checks.push_back(
        {"temperature", *hot ? Fail("arm a scan", "the computer is 95 degrees hot", "let it cool down") : Status{}});
    return checks;
  };
  FaultRig rig(std::move(options));
  ASSERT_TRUE(rig.Operate([&] { return rig.status().arm.has_value(); })) << rig.Told();
  rig.Pass(milliseconds(200));
  EXPECT_EQ(rig.state(), ScanState::kIdle);
  EXPECT_FALSE(rig.status().arm->passed());
  EXPECT_THAT(rig.Told(), HasSubstr("95 degrees"));
  *hot = false;
  EXPECT_EQ(JudgeRun(rig, {}), "");
}

}  // namespace
}  // namespace annulus::faults
