// Scans with reference sensors: what is recorded of them, replays, and that a scan goes on without them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "acquisition/reference_returns.h"
#include "acquisition/scan_json.h"
#include "tests/acquisition/replay_fixture.h"
#include "tests/acquisition/scan_fixture.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using test::Compare;
using test::ExpectIdentical;
using test::NoisyCone;
using test::RingCase;
using test::ShortPlan;
using test::TapeSink;
using test::TappedBooth;
using test::ThinkingClock;
using testing::HasSubstr;

constexpr std::size_t kBoard = sim::BoothDevices::kReference;

std::size_t LevelsWithReference(const Scan& scan) {
  std::size_t count = 0;
  for (const ScanLevel& level : scan.levels) {
    EXPECT_EQ(level.reference.size(), 4U);
    count += level.reference_time != nanoseconds(0) ? 1 : 0;
  }
  return count;
}

bool HasEvent(const Recording& recording, const std::string& text) {
  return std::any_of(recording.events.begin(), recording.events.end(),
                     [&](const RecordedEvent& event) { return event.text.find(text) != std::string::npos; });
}

class ReferenceScan : public testing::TestWithParam<RingCase> {
 protected:
  [[nodiscard]] static sim::BoothOptions Options() {
    sim::BoothOptions options = NoisyCone(GetParam());
    options.reference = StandardReferenceSensors();
    return options;
  }
  /// Takes the board away, whatever it hangs on.
  static void Lose(TappedBooth& booth) {
    const nanoseconds time = booth.clock.Now() + milliseconds(3);
    if (GetParam().can_buses == 0) {
      booth.booth.board(kBoard).UnplugAt(time);
    } else {
      booth.booth.can_board(kBoard).PowerOffAt(time);
    }
  }
};

TEST_P(ReferenceScan, EachLevelHasItsReadingsAtTheirOwnTimeAndReplaysToTheLastBit) {
  TappedBooth booth(Options());
  ASSERT_NE(booth.ring, nullptr);
  TapeSink tape;
  const auto summary = booth.Scan(ShortPlan(), tape);
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_EQ(summary->missing_levels, 0U);
  EXPECT_EQ(summary->reference_levels, summary->levels);
  EXPECT_EQ(summary->reference_trouble, "");
  EXPECT_EQ(LevelsWithReference(tape.recording.scan), tape.recording.scan.levels.size());
  std::size_t near = 0;
  std::size_t returns = 0;
  for (const ScanLevel& level : tape.recording.scan.levels) {
    EXPECT_LT(std::abs((level.reference_time - level.time).count()), 1'000'000) << "all fire within a millisecond";
    for (std::size_t i = 0; i < 4; ++i) {
      if (std::isnan(level.reference[i].range_mm)) continue;
      ++returns;
      // Where the cone's surface is for a beam from the wall; outliers are rare.
      const double height = i < 2 ? 950.0 : 1500.0;
      const double truth = 900.0 - (sim::ConeSubject::kFootRadiusMm - sim::ConeSubject::kSlope * height);
      near += std::abs(level.reference[i].range_mm - truth) < 3.0 ? 1U : 0U;
    }
  }
  // The ring itself is in the way in the lowest of these levels only.
  EXPECT_GT(returns, 3 * tape.recording.scan.levels.size());
  EXPECT_GT(near, returns * 8 / 10);
  ExpectIdentical(tape.recording);
}

TEST_P(ReferenceScan, GoesOnWithoutTheBoardAndSaysSo) {
  TappedBooth booth(Options());
  TapeSink tape;
  tape.on_level = [&](std::size_t count) {
    if (count == 20) Lose(booth);
    return Status{};
  };
  const auto summary = booth.Scan(ShortPlan(), tape);
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_EQ(summary->missing_levels, 0U);
  EXPECT_EQ(summary->levels, summary->planned_levels);
  EXPECT_EQ(summary->ring.lost_frames, 0U);
  const std::size_t with = LevelsWithReference(tape.recording.scan);
  EXPECT_GE(with, 20U);
  EXPECT_LE(with, 24U);
  EXPECT_EQ(summary->reference_levels, with);
  EXPECT_THAT(summary->reference_trouble, HasSubstr("1013"));
  EXPECT_THAT(summary->BriefReport(), HasSubstr("1013"));
  EXPECT_TRUE(HasEvent(tape.recording, "reference board 1013 gives no readings"));
  ExpectIdentical(tape.recording);

  // So does the next scan, from its beginning.
  TapeSink next;
  const auto again = booth.Scan(ShortPlan(), next);
  ASSERT_TRUE(again) << again.error().Text();
  EXPECT_EQ(again->missing_levels, 0U);
  EXPECT_EQ(again->reference_levels, 0U);
  EXPECT_TRUE(HasEvent(next.recording, "reference board 1013 gives no readings"));
  ExpectIdentical(next.recording);
}

TEST_P(ReferenceScan, ReplaysAHostThatTakesTimeToThinkAndLosesTheBoard) {
  TappedBooth booth(Options(), {}, std::make_unique<ThinkingClock>());
  TapeSink tape;
  tape.on_level = [&](std::size_t count) {
    if (count == 30) Lose(booth);
    return Status{};
  };
  const auto summary = booth.Scan(ShortPlan(), tape);
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_GE(LevelsWithReference(tape.recording.scan), 30U);
  EXPECT_NE(summary->reference_trouble, "");
  ExpectIdentical(tape.recording);
}

INSTANTIATE_TEST_SUITE_P(Buses, ReferenceScan, test::kRingCases, test::RingCaseName);

TEST(ReferenceReplay, SaysWhereAReferenceReadingDiffers) {
  sim::BoothOptions options = NoisyCone();
  options.reference = StandardReferenceSensors();
  TappedBooth booth(std::move(options));
  TapeSink tape;
  ASSERT_TRUE(booth.Scan(ShortPlan(), tape));
  tape.recording.scan.levels.at(17).reference.at(2).range_mm = 123.0;
  const ReplayComparison compared = Compare(tape.recording);
  ASSERT_TRUE(compared.first);
  EXPECT_EQ(compared.first->level, 17U);
  EXPECT_EQ(compared.first->sensor, 2U);
  EXPECT_EQ(compared.first->field, "reference_range_mm");
}

/// A scan with every number of the reference sensors that text could spoil.
Scan WithReference(std::uint32_t levels) {
  Scan scan = test::MakeScan(levels, 30);
  scan.header.reference = RecordedReference{4'294'967'295U, "1.2.\u00b5", StandardReferenceSensors()};
  scan.header.reference->sensors[1].theta = -0.1 - 0.2;
  scan.header.reference->sensors[2].aim = 1e-17;
  for (ScanLevel& level : scan.levels) {
    level.reference.assign(4, {std::numeric_limits<double>::quiet_NaN(), 0.0, 0});
    if (level.index % 5 == 4) continue;  // a lost frame
    level.reference_time = level.time + nanoseconds(300'017);
    for (std::size_t i = 0; i < 3; ++i) level.reference[i] = {700.0 + 0.1 * static_cast<double>(i), 0.0, 77};
  }
  return scan;
}

TEST(ReferenceRecording, ReadsBackToTheLastBit) {
  PosixStorage storage;
  const std::string path = testing::TempDir() + "/reference_recording.mcap";
  const Scan scan = WithReference(12);
  ASSERT_TRUE(WriteRecording(storage, path, scan));
  const auto read = ReadWholeRecording(storage, path);
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_TRUE(read->report.clean()) << "the hash counts the reference readings";
  EXPECT_TRUE(test::SameScan(read->scan, scan));
}

TEST(ReferenceRecording, WithoutTheSensorsNothingOfThemIsWritten) {
  const Scan scan = test::MakeScan(1, 30);
  EXPECT_EQ(JsonFromHeader(scan.header).find("\"reference"), std::string::npos);
  EXPECT_EQ(JsonFromLevel(scan.levels[0]).find("\"reference"), std::string::npos);
}

TEST(ReferenceRecording, ItsHashKnowsTheReadingsAndWhereTheSensorsStand) {
  const Scan scan = WithReference(5);
  const std::string hash = ScanHash(scan);
  Scan other = scan;
  other.levels[3].reference[1].range_mm += 1e-9;
  EXPECT_NE(ScanHash(other), hash);
  other = scan;
  other.header.reference->sensors[0].height_mm += 1e-9;
  EXPECT_NE(ScanHash(other), hash);
  other = scan;
  other.header.reference->firmware_version = "9.9.9";
  EXPECT_EQ(ScanHash(other), hash) << "the board is not what was measured";
}

TEST(ReferenceRecording, RefusesWhatCannotBe) {
  const Scan scan = WithReference(1);
  const auto refused = [&](auto spoil) {
    ScanHeader header = scan.header;
    spoil(*header.reference);
    return !HeaderFromJson(JsonFromHeader(header));
  };
  EXPECT_FALSE(refused([](RecordedReference&) {}));
  EXPECT_TRUE(refused([](RecordedReference& reference) { reference.sensors.clear(); }));
  EXPECT_TRUE(refused([](RecordedReference& reference) { reference.sensors[1].channel = 0; }));
  EXPECT_TRUE(refused([](RecordedReference& reference) { reference.sensors[1].channel = 15; }));
  EXPECT_TRUE(refused([](RecordedReference& reference) { reference.sensors[1].distance_mm = 0.0; }));
  EXPECT_TRUE(refused([](RecordedReference& reference) { reference.sensors[1].theta = NAN; }));

  const std::string level = JsonFromLevel(scan.levels[0]);
  EXPECT_TRUE(LevelFromJson(level, 30, 4));
  EXPECT_FALSE(LevelFromJson(level, 30, 3));
  EXPECT_TRUE(LevelFromJson(level, 30)) << "who knows of no reference sensors skips their keys";
  EXPECT_FALSE(LevelFromJson(JsonFromLevel(test::MakeScan(1, 30).levels[0]), 30, 4));
}

TEST(ReferenceReturns, AreOfThePersonAndNotOfTheRingThatPasses) {
  Scan scan = WithReference(2);
  scan.header.reference->sensors = StandardReferenceSensors();
  scan.levels[0].reference[1].range_mm = 250.0;  // the ring, 650 mm from the axis
  const auto returns = ReferenceReturns(scan);
  ASSERT_EQ(returns.size(), 5U);  // of three per level, one less
  EXPECT_EQ(returns[0].sensor, 0U);
  EXPECT_EQ(returns[1].sensor, 2U);
  EXPECT_EQ(returns[0].time, scan.levels[0].reference_time);
  EXPECT_EQ(returns[0].range_mm, 700.0);
  EXPECT_EQ(returns[0].quality, 77);
  // From the front at 900 mm a range of 700 mm ends 200 mm before the axis.
  const Eigen::Vector3d end = returns[0].ray.origin + returns[0].range_mm * returns[0].ray.direction;
  EXPECT_NEAR(end.x(), 0.0, 1e-9);
  EXPECT_NEAR(end.y(), 200.0, 1e-9);
  EXPECT_NEAR(end.z(), 950.0, 1e-9);
  EXPECT_TRUE(ReferenceReturns(test::MakeScan(2, 30)).empty());
}

}  // namespace
}  // namespace annulus
