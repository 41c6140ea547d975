// The rows D1 to D5 of the fault matrix: what a failing disk does to a recording.
#include <gtest/gtest.h>

#include <atomic>

#include "acquisition/recording.h"
#include "scan_fixture.h"
#include "tests/support/gated_storage.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using test::GatedStorage;
using test::MakeScan;
using test::SameLevel;
using test::StorageFault;
using test::TestStorage;

constexpr char kPath[] = "scan.mcap";

RecordingOptions Threaded() {
  RecordingOptions options;
  options.disk = DiskWriterMode::kThread;
  return options;
}

/// Appends levels until one is refused; the number of those that were not.
std::size_t AppendUntilRefused(RecordingWriter& writer, const Scan& scan, Status& status) {
  for (std::size_t i = 0; i < scan.levels.size(); ++i) {
    status = writer.AppendLevel(scan.levels[i]);
    if (!status) return i;
  }
  return scan.levels.size();
}

void ExpectLevelsBefore(TestStorage& storage, const std::string& path, const Scan& scan, std::size_t count) {
  const auto read = ReadWholeRecording(storage, path);
  if (count == 0 && !read) return;
  ASSERT_TRUE(read) << read.error().Text();
  ASSERT_GE(read->scan.levels.size(), count);
  for (std::size_t i = 0; i < read->scan.levels.size(); ++i) {
    ASSERT_TRUE(SameLevel(read->scan.levels[i], scan.levels[i]));
  }
}

TEST(RecordingFaults, D1_AFullDiskAtAnyByteKeepsAllLevelsBeforeAndSaysSo) {
  const Scan scan = MakeScan(12, 4);
  std::size_t refused_while_scanning = 0;
  for (std::uint64_t quota = 0;; quota += 97) {
    TestStorage storage;
    storage.quota_bytes = quota;
    auto writer = RecordingWriter::Create(storage, kPath, scan.header);
    if (!writer) {
      EXPECT_EQ(writer.error().advice, "free space on this disk or choose another");
      EXPECT_TRUE(storage.files.empty());
      continue;
    }
    Status status;
    const std::size_t kept = AppendUntilRefused(*writer, scan, status);
    if (status) status = writer->Finish();
    if (status) break;
    ++refused_while_scanning;
    EXPECT_EQ(status.error().seen, "No space left on device");
    EXPECT_FALSE(storage.Exists(kPath));
    ExpectLevelsBefore(storage, writer->temporary_path(), scan, kept);
  }
  EXPECT_GT(refused_while_scanning, 50U);
}

TEST(RecordingFaults, D1_RoomIsReservedBeforeTheFirstLevelOrTheScanIsRefused) {
  const Scan scan = MakeScan(2, 180);
  TestStorage storage;
  RecordingOptions options;
  options.reserve_bytes = RecordingReserve(360, 180);
  storage.quota_bytes = options.reserve_bytes - 1;
  const auto writer = RecordingWriter::Create(storage, kPath, scan.header, options);
  ASSERT_FALSE(writer);
  EXPECT_EQ(writer.error().seen, "No space left on device");
  EXPECT_TRUE(storage.files.empty());
}

TEST(RecordingFaults, D2_AFailedWriteIsFinalAndNotTriedAgain) {
  const Scan scan = MakeScan(10, 3);
  for (const StorageFault fault : {StorageFault::kIoError, StorageFault::kShortWrite}) {
    for (const DiskWriterMode mode : {DiskWriterMode::kInline, DiskWriterMode::kThread}) {
      for (std::uint64_t n = 1; n <= 12; ++n) {
        TestStorage storage;
        RecordingOptions options;
        options.disk = mode;
        options.sync_every_levels = 0;
        auto writer = RecordingWriter::Create(storage, kPath, scan.header, options);
        ASSERT_TRUE(writer);
        storage.FailCall(n, fault);
        Status status;
        AppendUntilRefused(*writer, scan, status);
        if (status) status = writer->Finish();
        ASSERT_FALSE(status) << "call " << n;
        const std::size_t written = writer->written_levels();
        const std::uint64_t calls = storage.calls();
        for (const ScanLevel& level : scan.levels)
          ASSERT_EQ(writer->AppendLevel(level).error().seen, status.error().seen);
        ASSERT_FALSE(writer->AppendAxis(nanoseconds(1), 2.0));
        ASSERT_FALSE(writer->Settle());
        ASSERT_FALSE(writer->Finish());
        ASSERT_EQ(storage.calls(), calls);
        ASSERT_FALSE(storage.Exists(kPath));
        ExpectLevelsBefore(storage, writer->temporary_path(), scan, written);
      }
    }
  }
}

TEST(RecordingFaults, D3_AFailedSyncIsNeverTakenForASuccessLater) {
  const Scan scan = MakeScan(30, 3);
  for (const DiskWriterMode mode : {DiskWriterMode::kInline, DiskWriterMode::kThread}) {
    GatedStorage storage;
    RecordingOptions options;
    options.disk = mode;
    auto writer = RecordingWriter::Create(storage, kPath, scan.header, options);
    ASSERT_TRUE(writer);
    ASSERT_EQ(storage.sync_calls(), 1U);
    storage.FailNextSync();  // the one after it would succeed
    Status status;
    AppendUntilRefused(*writer, scan, status);
    Result<bool> settled = false;
    while (settled && !*settled) settled = writer->Settle();
    ASSERT_FALSE(settled);
    EXPECT_EQ(settled.error().seen, "Input/output error");
    EXPECT_FALSE(writer->Finish());
    EXPECT_FALSE(writer->Settle());
    EXPECT_EQ(storage.sync_calls(), 2U);
    EXPECT_EQ(writer->durable_levels(), 0U);
    EXPECT_FALSE(storage.Exists(kPath));
  }
}

TEST(RecordingFaults, D4_ASlowSyncDelaysNobodyLosesNothingAndRaisesAnAlarm) {
  const Scan scan = MakeScan(240, 8);  // ten seconds at 24 levels/s
  GatedStorage storage;
  std::atomic<std::int64_t> now_ms{1'000};
  RecordingOptions options = Threaded();
  options.disk_clock = [&]() -> nanoseconds { return milliseconds(now_ms.load()); };
  auto writer = RecordingWriter::Create(storage, kPath, scan.header, options);
  ASSERT_TRUE(writer);
  storage.HoldSyncs();
  ASSERT_TRUE(writer->AppendLevel(scan.levels[0]));
  storage.WaitUntilHeld();
  now_ms += 200;
  EXPECT_EQ(writer->disk_note(), "");
  now_ms += 1;
  EXPECT_EQ(writer->disk_note(), "the disk has not answered for 201 ms; 1 blocks are not safe yet");
  // The disk stands still, and all of these calls return: nothing here waits for it.
  for (std::size_t i = 1; i < scan.levels.size(); ++i) ASSERT_TRUE(writer->AppendLevel(scan.levels[i])) << i;
  now_ms += 1'799;
  EXPECT_EQ(writer->disk_note(), "the disk has not answered for 2000 ms; 240 blocks are not safe yet");
  EXPECT_EQ(writer->written_levels(), 1U);
  EXPECT_EQ(writer->durable_levels(), 0U);
  const auto early = writer->Settle();
  ASSERT_TRUE(early);
  EXPECT_FALSE(*early);
  storage.Release();
  Result<bool> settled = false;
  while (settled && !*settled) settled = writer->Settle();
  ASSERT_TRUE(settled) << settled.error().Text();
  EXPECT_EQ(writer->durable_levels(), 240U);
  EXPECT_EQ(writer->disk_note(), "");
  EXPECT_EQ(writer->disk_state().longest_call, milliseconds(2'000));
  ASSERT_TRUE(writer->Finish());
  const auto read = ReadWholeRecording(storage, kPath);
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->report.clean());
  EXPECT_TRUE(test::SameScan(read->scan, scan));
}

/// A disk that can only be read.
class ReadOnlyStorage final : public Storage {
 public:
  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override { return Refuse("create " + path); }
  Result<std::vector<std::byte>> ReadAll(const std::string& path, std::uint64_t max_bytes) override {
    return inner_.ReadAll(path, max_bytes);
  }
  Status Rename(const std::string& from, const std::string&) override { return Refuse("rename " + from); }
  Status Remove(const std::string& path) override { return Refuse("remove " + path); }
  [[nodiscard]] bool Exists(const std::string& path) const override { return inner_.Exists(path); }
  Status CreateFolder(const std::string& path) override { return Refuse("create folder " + path); }
  Result<std::uint64_t> FreeBytes(const std::string& path) override { return inner_.FreeBytes(path); }

 private:
  static tl::unexpected<Error> Refuse(const std::string& attempted) {
    return Fail(attempted, "Read-only file system", "this disk is read-only: choose another");
  }
  TestStorage inner_;
};

TEST(RecordingFaults, D5_ADiskThatCanOnlyBeReadRefusesTheScanBeforeItsFirstLevel) {
  ReadOnlyStorage storage;
  const auto writer = RecordingWriter::Create(storage, kPath, MakeScan(1, 3).header);
  ASSERT_FALSE(writer);
  EXPECT_EQ(writer.error().seen, "Read-only file system");
  EXPECT_EQ(writer.error().advice, "this disk is read-only: choose another");
}

TEST(RecordingFaults, SettlesThoughMoreComesAllTheTime) {
  test::GatedStorage storage;
  const Scan scan = MakeScan(2, 8);
  RecordingOptions options;
  options.disk = DiskWriterMode::kThread;
  auto writer = RecordingWriter::Create(storage, "scan.mcap", scan.header, options);
  ASSERT_TRUE(writer);
  for (const ScanLevel& level : scan.levels) ASSERT_TRUE(writer->AppendLevel(level));
  auto time = scan.levels.back().time;
  auto settled = writer->Settle();
  int asked = 0;
  for (; settled && !*settled && asked < 10'000'000; ++asked) {
    // Positions of the axis go on while the disk is waited for, each a block of its own.
    time += std::chrono::milliseconds(150);
    ASSERT_TRUE(writer->AppendAxis(time, 1000.0));
    settled = writer->Settle();
  }
  ASSERT_TRUE(settled) << settled.error().Text();
  EXPECT_TRUE(*settled) << "not in " << asked << " looks";
  EXPECT_EQ(writer->durable_levels(), scan.levels.size());
  ASSERT_TRUE(writer->Finish());
}

}  // namespace
}  // namespace annulus
