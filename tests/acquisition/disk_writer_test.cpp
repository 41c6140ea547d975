#include "acquisition/disk_writer.h"

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "tests/support/gated_storage.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using test::GatedStorage;
using test::TestStorage;

constexpr char kPath[] = "f";

std::vector<std::byte> Block(std::size_t size) { return std::vector<std::byte>(size, std::byte{'x'}); }

DiskWriter Make(Storage& storage, DiskWriterOptions options) {
  return DiskWriter(std::move(*storage.Create(kPath)), std::move(options));
}

DiskWriterOptions Threaded() {
  DiskWriterOptions options;
  options.mode = DiskWriterMode::kThread;
  return options;
}

TEST(DiskWriter, InlineSyncsAfterEightBlocksOrAHundredMillisecondsOfTheTimesItIsTold) {
  GatedStorage storage;
  DiskWriter writer = Make(storage, {});
  std::vector<std::uint64_t> syncs;
  for (int i = 0; i < 16; ++i) {  // 5 ms apart: the number of blocks decides
    ASSERT_TRUE(writer.Append(Block(10)));
    ASSERT_TRUE(writer.Tick(milliseconds(5 * i)));
    syncs.push_back(storage.syncs());
  }
  EXPECT_EQ(syncs, (std::vector<std::uint64_t>{0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 2}));
  ASSERT_TRUE(writer.Append(Block(10)));
  ASSERT_TRUE(writer.Tick(milliseconds(75 + 99)));
  EXPECT_EQ(storage.syncs(), 2U);
  ASSERT_TRUE(writer.Tick(milliseconds(75 + 100)));
  EXPECT_EQ(storage.syncs(), 3U);
  EXPECT_EQ(writer.state().synced, 17U);
  ASSERT_TRUE(writer.Tick(milliseconds(10'000)));  // nothing new
  EXPECT_EQ(storage.syncs(), 3U);
}

TEST(DiskWriter, InAThreadWritesEveryBlockWithOneCallAndInOrder) {
  GatedStorage storage;
  DiskWriter writer = Make(storage, Threaded());
  std::vector<std::byte> all;
  for (unsigned i = 1; i <= 300; ++i) {
    const std::vector<std::byte> block(i, static_cast<std::byte>(i & 255U));
    all.insert(all.end(), block.begin(), block.end());
    ASSERT_TRUE(writer.Append(block));
  }
  ASSERT_TRUE(writer.Sync());
  EXPECT_EQ(writer.state().synced, 300U);
  EXPECT_EQ(storage.appends(), 300U);
  ASSERT_TRUE(writer.Close());
  EXPECT_EQ(storage.inner().files[kPath], all);
}

TEST(DiskWriter, InAThreadSyncsByItself) {
  GatedStorage storage;
  DiskWriter writer = Make(storage, Threaded());
  ASSERT_TRUE(writer.Append(Block(10)));
  storage.WaitForSyncs(1);
  ASSERT_TRUE(writer.Append(Block(10)));
  storage.WaitForSyncs(2);
  EXPECT_EQ(writer.state().written, 2U);
}

TEST(DiskWriter, InAThreadSyncsOnTimeAlsoWhileBlocksWait) {
  GatedStorage storage;
  DiskWriterOptions options = Threaded();
  options.sync_every = std::chrono::nanoseconds(0);  // every block at once
  DiskWriter writer = Make(storage, options);
  storage.HoldSyncs();
  ASSERT_TRUE(writer.Append(Block(10)));
  storage.WaitUntilHeld();
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(writer.Append(Block(10)));
  storage.Release();
  ASSERT_TRUE(writer.Sync());
  EXPECT_GE(storage.syncs(), 51U);
  EXPECT_EQ(writer.state().synced, 51U);
}

TEST(DiskWriter, SettlesWithoutWaiting) {
  GatedStorage storage;
  DiskWriter writer = Make(storage, Threaded());
  storage.HoldSyncs();
  ASSERT_TRUE(writer.Append(Block(10)));
  storage.WaitUntilHeld();
  for (int i = 0; i < 100; ++i) {
    const auto settled = writer.Settle();
    ASSERT_TRUE(settled);
    EXPECT_FALSE(*settled);
  }
  storage.Release();
  Result<bool> settled = false;
  while (settled && !*settled) settled = writer.Settle();
  EXPECT_TRUE(settled);
  EXPECT_EQ(writer.state().synced, 1U);
}

TEST(DiskWriter, SettlesThoughMoreIsAppendedAllTheTime) {
  GatedStorage storage;
  DiskWriterOptions options = Threaded();
  options.sync_every_blocks = 0;  // only the syncs that were asked for
  DiskWriter writer = Make(storage, options);
  storage.HoldSyncs();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.Append(Block(10)));
  Result<bool> settled = false;
  while (writer.state().written < 3) settled = writer.Settle();
  settled = writer.Settle();  // asks for the sync that is held
  storage.WaitUntilHeld();
  ASSERT_TRUE(writer.Append(Block(10)));  // as a scan does that watches its axis
  storage.Release();
  while (settled && !*settled) {
    settled = writer.Settle();
    if (writer.state().appended < 1'000) {
      ASSERT_TRUE(writer.Append(Block(10)));
    }
  }
  ASSERT_TRUE(settled);
  EXPECT_TRUE(*settled) << "block 4 came after the first question";
}

TEST(DiskWriter, RefusesWhatItsQueueHasNoRoomForAndWritesTheRest) {
  GatedStorage storage;
  DiskWriterOptions options = Threaded();
  options.queue_bytes = 1'000;
  DiskWriter writer = Make(storage, options);
  storage.HoldSyncs();
  ASSERT_TRUE(writer.Append(Block(100)));
  storage.WaitUntilHeld();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(writer.Append(Block(100))) << i;
  const Status refused = writer.Append(Block(100));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().seen, "the disk is too slow: 1000 bytes wait for it");
  EXPECT_NE(writer.Note(), "");
  storage.Release();
  EXPECT_EQ(writer.Append(Block(1)).error().seen, refused.error().seen);  // final
  EXPECT_FALSE(writer.Close());
  EXPECT_EQ(storage.inner().files[kPath].size(), 1'100U);
}

TEST(DiskWriter, GivesUpWaitingForADiskThatHangs) {
  GatedStorage storage;
  DiskWriterOptions options = Threaded();
  options.wait = milliseconds(5);
  DiskWriter writer = Make(storage, options);
  storage.HoldSyncs();
  ASSERT_TRUE(writer.Append(Block(10)));
  const Status status = writer.Sync();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().seen, "the disk has not taken it within 5 ms");
  storage.Release();
}

}  // namespace
}  // namespace annulus
