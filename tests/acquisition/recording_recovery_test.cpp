#include "acquisition/recording_recovery.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "acquisition/mcap_writer.h"
#include "acquisition/recording_channels.h"
#include "acquisition/scan_json.h"
#include "scan_fixture.h"
#include "tests/support/test_keys.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;
using test::MakeScan;
using test::SameScan;
using test::StorageFault;
using test::TestKeys;
using test::TestStorage;

constexpr char kOut[] = "out.mcap";

/// A recording with something on every channel; unfinished, it stays under the name that is returned.
enum class Ending { kFinished, kUnfinished };
std::string Record(Storage& storage, const std::string& path, const Scan& scan, Ending ending,
                   const KeySource* keys = nullptr) {
  RecordingOptions options;
  options.keys = keys;
  auto writer = RecordingWriter::Create(storage, path, scan.header, options);
  EXPECT_TRUE(writer);
  for (const ScanLevel& level : scan.levels) {
    for (std::size_t channel = 0; channel < kRawChannels; ++channel) {
      EXPECT_TRUE(writer->AppendRaw({static_cast<RawChannel>(channel), level.time, std::vector<std::byte>(channel)}));
    }
    EXPECT_TRUE(writer->AppendAxis(level.time, 1.0));
    EXPECT_TRUE(writer->AppendEvent(level.time, "event"));
    EXPECT_TRUE(writer->AppendSafety({level.time, {true}, {}}));
    EXPECT_TRUE(writer->AppendLevel(level));
  }
  if (ending == Ending::kUnfinished) return writer->temporary_path();
  EXPECT_TRUE(writer->Finish());
  return path;
}

TEST(RecoverRecording, OfAWholeRecordingGivesTheSameBytes) {
  TestStorage storage;
  Record(storage, "a.mcap", MakeScan(7, 4), Ending::kFinished);
  const auto summary = RecoverRecording(storage, "a.mcap", kOut);
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_TRUE(summary->lossless);
  EXPECT_EQ(summary->levels, 7U);
  EXPECT_EQ(storage.files[kOut], storage.files["a.mcap"]);
}

TEST(RecoverRecording, FinishesWhatWasNotAndKeepsEveryChannel) {
  TestStorage storage;
  const Scan scan = MakeScan(7, 4);
  const std::string part = Record(storage, "a.mcap", scan, Ending::kUnfinished);
  const auto before = storage.files[part];
  const auto summary = RecoverRecording(storage, part, kOut);
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_TRUE(summary->lossless);
  EXPECT_FALSE(summary->was_finished);
  EXPECT_EQ(storage.files[part], before);
  const auto read = ReadWholeRecording(storage, kOut);
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->report.clean());
  EXPECT_TRUE(read->report.recovered);
  EXPECT_TRUE(SameScan(read->scan, scan));
  EXPECT_EQ(read->raw.size(), 28U);
  EXPECT_EQ(read->axis.size() + read->events.size() + read->safety.size(), 21U);
  EXPECT_EQ(read->report.messages.at("/points"), 7U);
}

TEST(RecoverRecording, CutAtAnyByteSavesEveryWholeLevelAndASecondTimeTheSameBytes) {
  TestStorage storage;
  const Scan scan = MakeScan(3, 3);
  Record(storage, "a.mcap", scan, Ending::kFinished);
  const std::vector<std::byte> whole = storage.files["a.mcap"];
  std::size_t lossless = 0;
  const std::size_t step = std::getenv("ANNULUS_LONG") != nullptr ? 1 : 17;
  for (std::size_t cut = 0; cut < whole.size(); cut += step) {
    storage.files["cut.mcap"].assign(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut));
    const auto expected = ReadWholeRecording(storage, "cut.mcap");
    storage.files.erase(kOut);
    const auto summary = RecoverRecording(storage, "cut.mcap", kOut);
    ASSERT_EQ(summary.has_value(), expected.has_value()) << "cut at " << cut;
    if (!summary) {
      ASSERT_FALSE(storage.Exists(kOut));
      continue;
    }
    if (summary->lossless) ++lossless;
    const auto read = ReadWholeRecording(storage, kOut);
    ASSERT_TRUE(read) << "cut at " << cut;
    ASSERT_TRUE(SameScan(read->scan, expected->scan));
    ASSERT_TRUE(read->report.finished);
    ASSERT_TRUE(read->report.notes.empty()) << read->report.notes.front();
    const auto again = RecoverRecording(storage, kOut, "again.mcap");
    ASSERT_TRUE(again);
    ASSERT_TRUE(again->lossless) << "cut at " << cut;
    ASSERT_EQ(storage.files["again.mcap"], storage.files[kOut]) << "cut at " << cut;
  }
  EXPECT_GT(lossless, 0U);
}

TEST(RecoverRecording, WithABitFlippedLosesAtMostOneLevelAndChangesNone) {
  TestStorage storage;
  const Scan scan = MakeScan(4, 3);
  Record(storage, "a.mcap", scan, Ending::kFinished);
  std::vector<std::byte> bytes = storage.files["a.mcap"];
  const std::size_t step = std::getenv("ANNULUS_LONG") != nullptr ? 31 : 307;  // primes: all eight places of a byte
  std::size_t with_loss = 0;
  std::size_t tried = 0;
  std::size_t cautious = 0;
  for (std::size_t bit = 64; bit < 8 * bytes.size(); bit += step) {
    const auto mask = static_cast<std::byte>(1U << (bit % 8));
    bytes[bit / 8] ^= mask;
    storage.files["flipped.mcap"] = bytes;
    bytes[bit / 8] ^= mask;
    const auto summary = RecoverRecording(storage, "flipped.mcap", kOut);
    ASSERT_TRUE(summary) << "bit " << bit << ": " << summary.error().Text();
    ASSERT_GE(summary->levels, 3U) << "bit " << bit;
    ASSERT_FALSE(summary->lossless && !summary->messages_lost.empty()) << "bit " << bit;
    ++tried;
    // Where a bit hit the numbers of all messages, or made a record without a CRC, it cannot say that nothing is lost.
    if (!summary->lossless && summary->messages_lost.empty()) ++cautious;
    if (!summary->lossless) ++with_loss;
    const auto again = RecoverRecording(storage, kOut, "again.mcap");
    ASSERT_TRUE(again) << "bit " << bit;
    ASSERT_TRUE(again->lossless) << "bit " << bit;
    ASSERT_EQ(storage.files["again.mcap"], storage.files[kOut]) << "bit " << bit;
  }
  EXPECT_GT(with_loss, 0U);
  EXPECT_LE(20 * cautious, tried);
}

TEST(RecoverRecording, SaysWhatADamagedChunkCost) {
  TestStorage storage;
  const Scan scan = MakeScan(9, 4);
  Record(storage, "a.mcap", scan, Ending::kFinished);
  auto& bytes = storage.files["a.mcap"];
  bytes[bytes.size() / 2] ^= std::byte{1};
  const auto summary = RecoverRecording(storage, "a.mcap", kOut);
  ASSERT_TRUE(summary);
  EXPECT_FALSE(summary->lossless);
  EXPECT_EQ(summary->levels, 8U);
  EXPECT_EQ(summary->messages_lost, (std::map<std::string, std::uint64_t>{{"/axis/track", 1},
                                                                          {"/bus/calls", 1},
                                                                          {"/bus/can", 1},
                                                                          {"/bus/modbus", 1},
                                                                          {"/bus/usb", 1},
                                                                          {"/events", 1},
                                                                          {"/points", 1},
                                                                          {"/ring/levels", 1},
                                                                          {"/safety/lines", 1}}));
  const auto read = ReadWholeRecording(storage, kOut);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->report.levels_lost, 1U);  // the gap is still to be seen
  const auto again = RecoverRecording(storage, kOut, "again.mcap");
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->lossless);
  EXPECT_EQ(storage.files["again.mcap"], storage.files[kOut]);
}

TEST(RecoverRecording, KeepsChannelsItDoesNotKnow) {
  TestStorage storage;
  const Scan scan = MakeScan(1, 3);
  McapPreamble preamble = RecordingPreamble(JsonFromHeader(scan.header), "");
  preamble.schemas.push_back({20, "other.Kind", "jsonschema", "{}"});
  preamble.channels.push_back({20, 20, "/other", "json", {{"a", "b"}}});
  McapWriter writer(std::move(*storage.Create("a.mcap")), McapCompression::kZstd);
  ASSERT_TRUE(writer.WritePreamble(preamble));
  const std::string level = JsonFromLevel(scan.levels[0]);
  const std::vector<McapMessage> messages{{1, 0, 1, 1, level}, {20, 0, 2, 2, "{\"x\":1}"}};
  ASSERT_TRUE(writer.WriteChunk(messages));
  ASSERT_TRUE(writer.Finish());
  ASSERT_TRUE(RecoverRecording(storage, "a.mcap", kOut));
  const auto read = ReadWholeRecording(storage, kOut);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->report.messages.at("/other"), 1U);
}

TEST(RecoverRecording, KeepsASealedRecordingSealed) {
  const TestKeys keys;
  TestStorage storage;
  const Scan scan = MakeScan(5, 4);
  Record(storage, "a.mcap.enc", scan, Ending::kFinished, &keys);
  EXPECT_FALSE(RecoverRecording(storage, "a.mcap.enc", kOut));
  auto& bytes = storage.files["a.mcap.enc"];
  bytes[bytes.size() / 2] ^= std::byte{1};
  const auto summary = RecoverRecording(storage, "a.mcap.enc", kOut, &keys);
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_FALSE(summary->lossless);
  EXPECT_EQ(summary->frames_lost, 1U);
  EXPECT_TRUE(LooksSealed(storage.files[kOut]));
  const auto read = ReadWholeRecording(storage, kOut, &keys);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->scan.levels.size(), 4U);
  EXPECT_TRUE(read->report.finished);
}

TEST(RecoverRecording, TellsThatASealedRecordingWasCutWithinAFrame) {
  const TestKeys keys;
  TestStorage storage;
  Record(storage, "a.mcap.enc", MakeScan(5, 4), Ending::kFinished, &keys);
  auto& bytes = storage.files["a.mcap.enc"];
  bytes.resize(bytes.size() * 2 / 3);
  const auto summary = RecoverRecording(storage, "a.mcap.enc", kOut, &keys);
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_FALSE(summary->lossless);
  EXPECT_GT(summary->skipped_bytes, 0U);
}

TEST(RecoverRecording, RefusesItsOwnInputAsOutputAndWhatIsNoRecording) {
  TestStorage storage;
  storage.files["text"] = {std::byte{'x'}};
  EXPECT_FALSE(RecoverRecording(storage, "text", kOut));
  EXPECT_FALSE(RecoverRecording(storage, "gone", kOut));
  Record(storage, "a.mcap", MakeScan(1, 3), Ending::kFinished);
  EXPECT_EQ(RecoverRecording(storage, "a.mcap", "a.mcap").error().seen, "the new file has the name of the old one");
  EXPECT_EQ(storage.files.size(), 2U);
}

TEST(RecoverRecording, LeavesNothingBehindWhicheverCallFails) {
  for (const StorageFault fault : {StorageFault::kIoError, StorageFault::kShortWrite}) {
    for (std::uint64_t n = 1;; ++n) {
      TestStorage storage;
      const std::string part = Record(storage, "a.mcap", MakeScan(2, 3), Ending::kUnfinished);
      storage.FailCall(n, fault);
      const auto summary = RecoverRecording(storage, part, kOut);
      if (!storage.fault_hit()) break;
      ASSERT_FALSE(summary) << "call " << n;
      ASSERT_EQ(storage.files.size(), 1U) << "call " << n;
    }
  }
}

TEST(RecoverOpenRecordings, GivesEachItsNameWithoutAQuestion) {
  TestStorage storage;
  const Scan scan = MakeScan(4, 3);
  const std::string whole = Record(storage, "scans/whole.mcap", scan, Ending::kUnfinished);
  storage.files["scans/whole.mcap.part-77"] = storage.files[whole];  // two with one name
  const std::string torn = Record(storage, "scans/torn.mcap", scan, Ending::kUnfinished);
  storage.files[torn].resize(storage.files[torn].size() - 40);
  const auto torn_bytes = storage.files[torn];
  Record(storage, "scans/done.mcap", scan, Ending::kFinished);
  storage.files["scans/model.json.part-5"] = {std::byte{'{'}};
  storage.files["elsewhere.mcap.part-5"] = storage.files[whole];
  storage.files["scans/whole.mcap.recover-copy.part-5"] = {};  // a recovery that was not finished
  const auto found = RecoverOpenRecordings(storage, "scans");
  ASSERT_TRUE(found) << found.error().Text();
  ASSERT_EQ(found->size(), 3U);
  for (const OpenRecording& open : *found) {
    ASSERT_TRUE(open.outcome) << open.outcome.error().Text();
    EXPECT_FALSE(storage.Exists(open.part));
    EXPECT_EQ(open.outcome->lossless, open.kept.empty());
    EXPECT_TRUE(ReadWholeRecording(storage, open.recording)->report.clean());
  }
  const std::string pid = torn.substr(torn.rfind('-') + 1);
  EXPECT_EQ(storage.files["scans/torn.mcap.damaged-" + pid], torn_bytes);
  EXPECT_TRUE(storage.Exists("scans/whole.mcap"));
  EXPECT_TRUE(storage.Exists("scans/whole.recovered-1.mcap"));
  EXPECT_TRUE(storage.Exists("scans/model.json.part-5"));
  EXPECT_FALSE(storage.Exists("scans/whole.mcap.recover-copy.part-5"));
  EXPECT_TRUE(storage.Exists("elsewhere.mcap.part-5"));
  EXPECT_TRUE(RecoverOpenRecordings(storage, "scans")->empty());
}

TEST(RecoverOpenRecordings, LeavesOneWhoseKeyIsMissingForAnotherTime) {
  const TestKeys keys;
  TestStorage storage;
  const std::string part = Record(storage, "a.mcap.enc", MakeScan(2, 3), Ending::kUnfinished, &keys);
  const auto without = RecoverOpenRecordings(storage, "");
  ASSERT_EQ(without->size(), 1U);
  EXPECT_FALSE(without->front().outcome);
  EXPECT_TRUE(storage.Exists(part));
  const auto with = RecoverOpenRecordings(storage, "", &keys);
  ASSERT_EQ(with->size(), 1U);
  EXPECT_TRUE(with->front().outcome);
  EXPECT_EQ(storage.files.size(), 1U);
}

TEST(RecoverOpenRecordings, OnARealDiskLeavesThoseThatAreBeingWritten) {
  PosixStorage storage;
  const std::string folder = testing::TempDir() + "annulus_open_recordings";
  ASSERT_TRUE(storage.CreateFolder(folder));
  const auto left = storage.List(folder);
  ASSERT_TRUE(left);
  for (const std::string& name : *left) ASSERT_TRUE(storage.Remove(folder + "/" + name));
  const Scan scan = MakeScan(2, 3);
  std::string part;
  {
    auto writer = RecordingWriter::Create(storage, folder + "/a.mcap", scan.header);
    ASSERT_TRUE(writer);
    part = writer->temporary_path();
    for (const ScanLevel& level : scan.levels) ASSERT_TRUE(writer->AppendLevel(level));
    EXPECT_TRUE(RecoverOpenRecordings(storage, folder)->empty());
  }
  const auto found = RecoverOpenRecordings(storage, folder);
  ASSERT_TRUE(found) << found.error().Text();
  ASSERT_EQ(found->size(), 1U);
  EXPECT_EQ(found->front().recording, folder + "/a.mcap");
  EXPECT_EQ(*storage.List(folder), std::vector<std::string>{"a.mcap"});
}

}  // namespace
}  // namespace annulus
