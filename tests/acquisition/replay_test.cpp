#include "acquisition/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "acquisition/bus_record.h"
#include "tests/acquisition/replay_fixture.h"
#include "tests/acquisition/scan_fixture.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using test::Compare;
using test::ExpectIdentical;
using test::LongPlan;
using test::NoisyCone;
using test::RingCase;
using test::ShortPlan;
using test::TapeSink;
using test::TappedBooth;
using test::ThinkingClock;
using testing::HasSubstr;

class ReplayOnBuses : public testing::TestWithParam<RingCase> {
 protected:
  [[nodiscard]] static sim::BoothOptions Booth() { return NoisyCone(GetParam()); }
};

TEST_P(ReplayOnBuses, GivesTheSameLevelsToTheLastBit) {
  TappedBooth booth(Booth());
  TapeSink tape;
  const auto summary = booth.Scan(LongPlan(), tape);
  ASSERT_TRUE(summary) << summary.error().Text();
  ASSERT_GE(summary->levels, 300U);
  ExpectIdentical(tape.recording);
  std::size_t bytes = 0;
  for (const RawRecord& record : tape.recording.raw) bytes += record.bytes.size();
  std::printf("%s: %zu levels, %zu records, %.0f bytes of raw records per level\n", GetParam().name,
              tape.recording.scan.levels.size(), tape.recording.raw.size(),
              static_cast<double>(bytes) / static_cast<double>(summary->levels));
}

TEST_P(ReplayOnBuses, GivesTheSecondScanOfASessionToo) {
  TappedBooth booth(Booth());
  TapeSink first;
  ASSERT_TRUE(booth.Scan(ShortPlan(), first));
  // Questions between the scans, which are in neither recording.
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(booth.ring->ReadClock(3));
  booth.clock.SleepUntil(booth.clock.Now() + std::chrono::minutes(3));
  TapeSink second;
  ASSERT_TRUE(booth.Scan(ShortPlan(), second));
  ExpectIdentical(second.recording);
}

TEST_P(ReplayOnBuses, GivesACancelledScan) {
  TappedBooth booth(Booth());
  TapeSink tape;
  tape.on_level = [&](std::size_t count) {
    if (count == 40) booth.stop.request_stop();
    return Status{};
  };
  const auto summary = booth.Scan(ShortPlan(), tape);
  ASSERT_TRUE(summary) << summary.error().Text();
  ASSERT_TRUE(summary->cancelled);
  ExpectIdentical(tape.recording);
}

INSTANTIATE_TEST_SUITE_P(Buses, ReplayOnBuses, test::kRingCases, test::RingCaseName);

TEST(Replay, EndsWithTheErrorOfALostBoard) {
  TappedBooth booth(NoisyCone());
  TapeSink tape;
  tape.on_level = [&](std::size_t count) {
    if (count == 30) booth.booth.board(4).UnplugAt(booth.clock.Now() + milliseconds(3));
    return Status{};
  };
  const auto summary = booth.Scan(ShortPlan(), tape);
  ASSERT_FALSE(summary);
  ASSERT_THAT(summary.error().Text(), HasSubstr("unplugged"));
  ExpectIdentical(tape.recording);
}

TEST_P(ReplayOnBuses, GivesAScanOfAHostThatTakesTimeToThink) {
  TappedBooth booth(Booth(), {}, std::make_unique<ThinkingClock>());
  TapeSink tape;
  const auto summary = booth.Scan(ShortPlan(), tape);
  ASSERT_TRUE(summary) << summary.error().Text();
  ExpectIdentical(tape.recording);
}

TEST(Replay, SaysWhereARecordingDiffers) {
  TappedBooth booth(NoisyCone());
  TapeSink tape;
  ASSERT_TRUE(booth.Scan(ShortPlan(), tape));
  RangeReading& changed = tape.recording.scan.levels.at(17).readings.at(42);
  changed.range_mm = 123.0;
  const ReplayComparison compared = Compare(tape.recording);
  ASSERT_TRUE(compared.first);
  EXPECT_EQ(compared.first->level, 17U);
  EXPECT_EQ(compared.first->sensor, 42U);
  EXPECT_EQ(compared.first->field, "range_mm");
  EXPECT_EQ(compared.first->recorded, "123");
  EXPECT_EQ(compared.differing, 1U);
  EXPECT_THAT(compared.BriefReport(), HasSubstr("level 17 (sweep 0, index 17), sensor 42, range_mm"));
}

TEST(Replay, NoticesOneChangedByteOfTheRawRecords) {
  TappedBooth booth(NoisyCone());
  TapeSink tape;
  ASSERT_TRUE(booth.Scan(ShortPlan(), tape));
  // The range of one frame: its checksum is wrong then, and the frame is lost.
  std::size_t seen = 0;
  for (RawRecord& record : tape.recording.raw) {
    auto decoded = *DecodeBusRecord(record);
    auto* ended = std::get_if<bus_record::UsbEnded>(&decoded);
    if (ended == nullptr || ended->data.empty() || ++seen != 12 * 40) continue;
    ended->data.at(60) ^= std::byte{1};
    record = EncodeBusRecord(*ended, record.time);
  }
  const ReplayComparison compared = Compare(tape.recording);
  ASSERT_TRUE(compared.first);
  EXPECT_EQ(compared.first->replayed, "nan") << compared.first->Text();
  // Of the board's 15 sensors one is the first; the level and the two counters of the lost frame differ.
  EXPECT_EQ(compared.first->field, "range_mm");
  EXPECT_EQ(*compared.first->sensor % 15, 0U);
  EXPECT_EQ(compared.identical_levels, tape.recording.scan.levels.size() - 1);
}

TEST(Replay, GoesToAnyLevelAndBack) {
  TappedBooth booth(NoisyCone());
  TapeSink tape;
  ASSERT_TRUE(booth.Scan(ShortPlan(), tape));
  auto replay = Replay::Open(tape.recording.raw);
  ASSERT_TRUE(replay) << replay.error().Text();
  for (const std::uint64_t level : {0U, 50U, 51U, 3U, 59U}) {
    ASSERT_TRUE(replay->Seek(level));
    const auto step = replay->Next();
    ASSERT_TRUE(step && *step && (*step)->level);
    EXPECT_TRUE(test::SameLevel(*(*step)->level, tape.recording.scan.levels.at(level))) << level;
  }
  const Status beyond = replay->Seek(100'000);
  ASSERT_FALSE(beyond);
  EXPECT_THAT(beyond.error().Text(), HasSubstr("it has only"));
}

TEST(Replay, RefusesARecordingWithoutRawBytes) {
  const auto replay = Replay::Open({});
  ASSERT_FALSE(replay);
  EXPECT_THAT(replay.error().Text(), HasSubstr("no raw bytes"));
}

TEST(Replay, PassesOverRecordsOfUnknownKind) {
  TappedBooth booth(NoisyCone());
  TapeSink tape;
  ASSERT_TRUE(booth.Scan(ShortPlan(), tape));
  for (std::size_t at : {0U, 100U, 1000U}) {
    tape.recording.raw.insert(tape.recording.raw.begin() + static_cast<std::ptrdiff_t>(at),
                              {RawChannel::kCall, tape.recording.raw.at(at).time, {std::byte{99}, std::byte{1}}});
  }
  const ReplayComparison compared = Compare(tape.recording);
  EXPECT_TRUE(compared.identical()) << compared.BriefReport();
  EXPECT_EQ(compared.unknown_records, 3U);
}

TEST(Replay, RefusesANewerFormat) {
  bus_record::RingOpening opening;
  opening.format = bus_record::kFormat + 1;
  const std::vector<RawRecord> raw{EncodeBusRecord(opening, nanoseconds(1))};
  const auto replay = Replay::Open(raw);
  ASSERT_FALSE(replay);
  EXPECT_THAT(replay.error().Text(), HasSubstr("format 3, this program reads up to 2"));
}

TEST(Replay, RefusesOptionsOfARingThatNoDriverTakes) {
  const auto refused = [](const CanRangeRingOptions& options) {
    const std::vector<RawRecord> raw{
        EncodeBusRecord(bus_record::RingOpening{bus_record::kFormat, options, 1}, nanoseconds(1)),
        EncodeBusRecord(bus_record::RingOpened{}, nanoseconds(2)),
        EncodeBusRecord(bus_record::ScanBegun{PlanJson(ShortPlan())}, nanoseconds(3))};
    const auto replay = Replay::Open(raw);
    return !replay && replay.error().Text().find("cannot be") != std::string::npos;
  };
  CanRangeRingOptions options;
  EXPECT_FALSE(refused(options)) << "without boards it fails otherwise";
  for (const nanoseconds heartbeat : {nanoseconds(0), nanoseconds(999'999), nanoseconds(std::chrono::minutes(1))}) {
    options.heartbeat = heartbeat;
    EXPECT_TRUE(refused(options)) << heartbeat.count();
  }
  options = {};
  options.board_count = 128;
  EXPECT_TRUE(refused(options));
}

TEST(Replay, GivesWhatIsThereOfACutRecording) {
  TappedBooth booth(NoisyCone());
  TapeSink tape;
  ASSERT_TRUE(booth.Scan(ShortPlan(), tape));
  tape.recording.report.finished = false;
  std::size_t last = tape.recording.scan.levels.size();
  for (int cut = 0; cut < 20; ++cut) {
    // Homing and the way to the start are most of the records.
    tape.recording.raw.resize(tape.recording.raw.size() - 200);
    auto replay = Replay::Open(tape.recording.raw);
    ASSERT_TRUE(replay) << replay.error().Text();
    std::size_t levels = 0;
    for (auto step = replay->Next(); step && *step; step = replay->Next()) {
      EXPECT_FALSE((*step)->difference) << (*step)->difference->Text();
      if (!(*step)->level) continue;
      EXPECT_TRUE(test::SameLevel(*(*step)->level, tape.recording.scan.levels.at(levels)));
      ++levels;
    }
    EXPECT_LE(levels, last);
    last = levels;
  }
  EXPECT_LT(last, 40U);
}

}  // namespace
}  // namespace annulus
