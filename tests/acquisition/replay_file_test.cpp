// From the buses into a file and back through the drivers.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "acquisition/recording.h"
#include "tests/acquisition/replay_fixture.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using test::Compare;
using test::ExpectIdentical;
using test::LongPlan;
using test::NoisyCone;
using test::RingCase;
using test::ShortPlan;
using test::TappedBooth;
using test::TestStorage;

constexpr char kPath[] = "scan.mcap";

ScanHeader Header(const ScanPlan& plan) {
  ScanHeader header;
  header.station_id = "sim";
  header.ring_radius_mm = 600.0;
  header.calibration = RingCalibration::Ideal(600.0);
  header.plan_json = PlanJson(plan);
  return header;
}

/// Records a scan into a file; false: it ended with an error, and the file was left as it was then.
bool Record(TappedBooth& booth, const ScanPlan& plan, TestStorage& storage, std::string& path) {
  auto writer = RecordingWriter::Create(storage, kPath, Header(plan));
  EXPECT_TRUE(writer) << writer.error().Text();
  path = writer->temporary_path();
  const auto summary = booth.Scan(plan, *writer);
  if (!summary) return false;
  EXPECT_TRUE(writer->Finish());
  path = kPath;
  return true;
}

Recording ReadBack(TestStorage& storage, const std::string& path) {
  auto recording = ReadWholeRecording(storage, path);
  EXPECT_TRUE(recording) << recording.error().Text();
  return recording ? std::move(*recording) : Recording();
}

class ReplayFile : public testing::TestWithParam<RingCase> {};

TEST_P(ReplayFile, IsReplayedToTheLastBit) {
  TappedBooth booth(NoisyCone(GetParam()));
  TestStorage storage;
  std::string path;
  ASSERT_TRUE(Record(booth, LongPlan(), storage, path));
  std::printf("%s: %.2f MB for 360 levels\n", GetParam().name, static_cast<double>(storage.files[kPath].size()) / 1e6);
  const Recording recording = ReadBack(storage, path);
  ASSERT_EQ(recording.scan.levels.size(), 360U);
  EXPECT_TRUE(recording.report.clean());
  ExpectIdentical(recording);
}

TEST_P(ReplayFile, OfTheSecondScanOfASessionIsReplayedToo) {
  TappedBooth booth(NoisyCone(GetParam()));
  TestStorage storage;
  std::string path;
  ASSERT_TRUE(Record(booth, ShortPlan(), storage, path));
  storage.files.clear();
  booth.clock.SleepUntil(booth.clock.Now() + std::chrono::minutes(2));
  ASSERT_TRUE(Record(booth, ShortPlan(), storage, path));
  ExpectIdentical(ReadBack(storage, path));
}

INSTANTIATE_TEST_SUITE_P(Buses, ReplayFile, test::kRingCases, test::RingCaseName);

TEST(ReplayFile, OfAScanThatALostBoardCutShortEndsAsItDid) {
  TappedBooth booth(NoisyCone());
  // Homing and the way to the start take some seconds; then it is in the middle of a sweep.
  booth.booth.board(4).UnplugAt(booth.clock.Now() + milliseconds(5'300));
  TestStorage storage;
  std::string path;
  ASSERT_FALSE(Record(booth, ShortPlan(), storage, path));
  const Recording recording = ReadBack(storage, path);
  ASSERT_GT(recording.scan.levels.size(), 5U);
  EXPECT_FALSE(recording.report.finished);
  ExpectIdentical(recording);
}

TEST(ReplayFile, ThatIsCutAnywhereIsReplayedAsFarAsItGoes) {
  TappedBooth booth(NoisyCone());
  TestStorage storage;
  std::string path;
  ASSERT_TRUE(Record(booth, ShortPlan(), storage, path));
  const std::vector<std::byte> whole = storage.files[kPath];
  std::size_t replayed = 0;
  for (int part = 40; part < 100; part += 5) {
    const auto size = whole.size() * static_cast<std::size_t>(part) / 100;
    const auto recording = ParseRecording(std::span(whole).first(size), "cut");
    if (!recording) continue;  // not one level left
    SCOPED_TRACE(part);
    const ReplayComparison compared = Compare(*recording);
    EXPECT_TRUE(compared.identical()) << compared.BriefReport();
    EXPECT_EQ(compared.identical_levels, recording->scan.levels.size());
    replayed += compared.identical_levels;
  }
  EXPECT_GT(replayed, 50U);
}

TEST(ReplayFile, WithADamagedPlaceIsIdenticalUpToItAndCloseBehind) {
  TappedBooth booth(NoisyCone());
  TestStorage storage;
  std::string path;
  ASSERT_TRUE(Record(booth, LongPlan(), storage, path));
  std::vector<std::byte> bytes = storage.files[kPath];
  bytes[bytes.size() * 7 / 10] ^= std::byte{0x10};
  const auto recording = ParseRecording(bytes, "damaged");
  ASSERT_TRUE(recording) << recording.error().Text();
  ASSERT_FALSE(recording->report.clean());
  const ReplayComparison compared = Compare(*recording);
  ASSERT_TRUE(compared.first);
  EXPECT_GT(compared.identical_levels, 100U);
  std::printf("%s; worst %.2g mm of range, %.2g mm of height\n", compared.BriefReport().c_str(),
              compared.worst_range_mm, compared.worst_z_mm);
}

TEST(ReplayFile, ThatWasImportedSaysThatItHasNoRawBytes) {
  TestStorage storage;
  Scan scan;
  scan.header = Header(ShortPlan());
  ScanLevel level;
  level.readings.resize(180, RangeReading{400.0, 1000.0, 200});
  scan.levels.push_back(level);
  ASSERT_TRUE(WriteRecording(storage, kPath, scan));
  const auto compared = CompareWithRecorded(ReadBack(storage, kPath), {}, {});
  ASSERT_FALSE(compared);
  EXPECT_THAT(compared.error().Text(), testing::HasSubstr("holds no raw bytes"));
}

}  // namespace
}  // namespace annulus
