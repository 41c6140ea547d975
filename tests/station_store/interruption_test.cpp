/// Killed at any write, at any moment; the disk full or failing at any call.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>

#include "tests/crash/forwarding_storage.h"
#include "tests/station_store/store_model.h"

namespace annulus {
namespace {

using test::StoreExercise;
using test::StoreOnDisk;

/// What becomes of the call of a storage that is hit.
enum class Hit {
  kFails,  ///< As on a full or broken disk: it does nothing and fails; so do all later ones that write.
  kKills,  ///< The process ends there, before the call.
};

/// A real disk whose n-th writing call is hit.
class HitStorage final : public test::ForwardingStorage {
 public:
  HitStorage(Storage& below, std::uint64_t at, Hit hit) : ForwardingStorage(below), at_(at), hit_(hit) {}
  [[nodiscard]] bool was_hit() const { return calls_ >= at_; }

  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override {
    RETURN_IF_ERROR(Call());
    auto file = below_.Create(path);
    if (!file) return file;
    return std::make_unique<File>(*this, std::move(*file));
  }
  Status Rename(const std::string& from, const std::string& to) override {
    RETURN_IF_ERROR(Call());
    return below_.Rename(from, to);
  }
  Status Remove(const std::string& path) override {
    RETURN_IF_ERROR(Call());
    return below_.Remove(path);
  }
  Status SyncFolder(const std::string& path) override {
    RETURN_IF_ERROR(Call());
    return below_.SyncFolder(path);
  }
  Status CreateFolder(const std::string& path) override {
    RETURN_IF_ERROR(Call());
    return below_.CreateFolder(path);
  }
  [[nodiscard]] bool InUse(const std::string& path) const override { return below_.InUse(path); }

 private:
  class File final : public test::ForwardingFile {
   public:
    File(HitStorage& storage, std::unique_ptr<AppendFile> below)
        : ForwardingFile(std::move(below)), storage_(storage) {}
    Status Append(std::span<const std::byte> bytes) override {
      if (const Status status = storage_.Call(); !status) {
        static_cast<void>(below_->Append(bytes.first(bytes.size() / 2)));  // a full disk takes some of it
        return status;
      }
      return below_->Append(bytes);
    }
    Status Sync() override {
      RETURN_IF_ERROR(storage_.Call());
      return below_->Sync();
    }

   private:
    HitStorage& storage_;
  };

  Status Call() {
    if (++calls_ < at_) return {};
    if (hit_ == Hit::kKills) ::_exit(0);
    return Fail("write", "No space left on device", "free space on this disk or choose another");
  }

  std::uint64_t at_;
  Hit hit_;
  std::uint64_t calls_ = 0;
};

TEST(StoreInterruption, LosesNothingAcknowledgedWhenTheDiskIsFullFromAnyCallOn) {
  int refused = 0;
  for (std::uint64_t at = 1; at < 220; at += at < 30 ? 3 : 13) {
    StoreOnDisk disk;
    disk.Open();
    StoreExercise exercise(at, disk.disk.path() + "/spool");
    for (int step = 0; step < 12; ++step) exercise.Step(*disk);
    HitStorage full(disk.posix, at, Hit::kFails);
    disk.storage = &full;
    if (auto opened = disk.TryOpen()) {
      for (int step = 0; step < 12; ++step) {
        if (!exercise.Step(**opened)) ++refused;
      }
      EXPECT_EQ(exercise.Difference(**opened), "") << "while full, from call " << at;
    }
    disk.storage = &disk.posix;
    disk.Open();
    EXPECT_EQ(disk->state(), StoreState::kReady);
    EXPECT_EQ(exercise.Difference(*disk), "") << "from call " << at;
  }
  EXPECT_GT(refused, 20);
}

/// A child that works on the store and says after every step what is done; the parent follows.
class Worker {
 public:
  /// `hit`: kills itself at that call of the storage; 0: works until it is killed.
  Worker(StoreOnDisk& disk, std::uint64_t seed, std::uint64_t hit) {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    child_ = ::fork();
    EXPECT_GE(child_, 0);
    if (child_ == 0) {
      ::close(ends[0]);
      Work(disk, seed, hit, ends[1]);
    }
    ::close(ends[1]);
    answers_ = ends[0];
  }
  ~Worker() {
    ::close(answers_);
    if (child_ <= 0) return;
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void Kill() const {
    if (child_ > 0) ::kill(child_, SIGKILL);
  }
  /// Reads what was done until `steps` were, or to the end.
  int Follow(StoreExercise& exercise, int steps) {
    int followed = 0;
    char c = 0;
    while (followed < steps && ::read(answers_, &c, 1) == 1) {
      if (c != '\n') {
        line_ += c;
        continue;
      }
      exercise.Follow(line_);
      line_.clear();
      ++followed;
    }
    return followed;
  }

 private:
  [[noreturn]] static void Work(StoreOnDisk& disk, std::uint64_t seed, std::uint64_t hit, int out) {
    HitStorage storage(disk.posix, hit == 0 ? ~std::uint64_t{0} : hit, Hit::kKills);
    auto store = Store::Open(disk.options, storage, disk.clock);
    if (!store) ::_exit(1);
    StoreExercise exercise(seed, disk.disk.path() + "/spool");
    for (int step = 0; step < 1000; ++step) {
      exercise.Step(**store);
      if (exercise.done().empty()) continue;
      const std::string line = exercise.done() + "\n";
      if (::write(out, line.data(), line.size()) < 0) ::_exit(1);
    }
    ::_exit(0);
  }

  pid_t child_ = -1;
  int answers_ = -1;
  std::string line_;
};

/// The store opens within 3 s (usable again after a kill), and holds all that was acknowledged; what was erased is
/// gone, and no file is without a row. An operation whose answer did not get out may have been done: an artefact may
/// have been replaced or removed, a customer renamed or erased by it, so one difference is put up with if it is of the
/// very next operation.
void CheckAfterKill(StoreOnDisk& disk, StoreExercise& exercise, std::uint64_t seed, int acknowledged,
                    const std::string& where) {
  const auto start = std::chrono::steady_clock::now();
  disk.Open();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(3)) << where;
  EXPECT_EQ(disk->state(), StoreState::kReady) << where;
  std::string difference = exercise.Difference(*disk);
  if (!difference.empty()) {
    // The same dice on a store of its own tell what the next operation was.
    StoreOnDisk twin;
    twin.Open();
    StoreExercise replay(seed, twin.disk.path() + "/spool");
    for (int done = 0; done <= acknowledged;) {
      replay.Step(*twin);
      if (!replay.done().empty()) ++done;
    }
    exercise.Follow(replay.done());
    difference = exercise.Difference(*disk);
  }
  EXPECT_EQ(difference, "") << where;
  std::size_t named = 0;
  const auto scans = disk->LatestScans(100'000);
  ASSERT_TRUE(scans) << where;
  for (const ScanRow& scan : *scans) named += 1 + disk->ArtefactsOf(scan.id)->size();
  EXPECT_EQ(test::FilesBelow(disk.options.folder + "/files").size(), named) << where;
  EXPECT_EQ(test::FilesBelow(disk.options.folder + "/keys").size(), disk->FindCustomers("", 100'000)->size()) << where;
}

TEST(StoreInterruption, LosesNothingAcknowledgedWhenKilledAtAnyCallOfTheDisk) {
  const bool all = std::getenv("ANNULUS_LONG") != nullptr;
  for (std::uint64_t hit = 1; hit < 400; hit += all ? 1 : 1 + hit / 5) {
    StoreOnDisk disk;
    StoreExercise exercise(hit, disk.disk.path() + "/spool");
    disk.Open();
    disk.Close();
    int acknowledged = 0;
    {
      Worker worker(disk, hit, hit);
      acknowledged = worker.Follow(exercise, 100'000);
    }
    CheckAfterKill(disk, exercise, hit, acknowledged, "killed at call " + std::to_string(hit));
  }
}

TEST(StoreInterruption, LosesNothingAcknowledgedWhenKilledAtAnyMoment) {
  const int rounds = std::getenv("ANNULUS_LONG") != nullptr ? 100 : 10;
  for (int round = 0; round < rounds; ++round) {
    const auto seed = static_cast<std::uint64_t>(1000 + round);
    StoreOnDisk disk;
    StoreExercise exercise(seed, disk.disk.path() + "/spool");
    int acknowledged = 0;
    {
      Worker worker(disk, seed, 0);
      acknowledged = worker.Follow(exercise, 5 + 4 * round % 60);
      worker.Kill();  // somewhere within what follows
      acknowledged += worker.Follow(exercise, 100'000);
    }
    CheckAfterKill(disk, exercise, seed, acknowledged, "round " + std::to_string(round));
  }
}

}  // namespace
}  // namespace annulus
