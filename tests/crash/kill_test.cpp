#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <thread>

#include "acquisition/recording.h"
#include "forwarding_storage.h"
#include "planted_defects.h"
#include "tests/acquisition/scan_fixture.h"
#include "tests/support/dice.h"

namespace annulus {
namespace {

using test::Dice;

constexpr std::uint32_t kMostLevels = 120;
constexpr std::size_t kSensors = 6;
/// Levels that a recording process is ahead of the disk at most, so that there is something to acknowledge.
constexpr std::uint32_t kMostUnsaid = 3;

/// What the recording process says through the pipe; one write each, which a pipe never tears.
struct Said {
  enum class What : std::uint32_t { kCreated, kLevel, kFinished };
  What what = What::kCreated;
  std::uint32_t recording = 0;
  std::uint32_t level = 0;
};

/// A folder that is gone afterwards.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "annulus-kill-XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() { std::filesystem::remove_all(path_); }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string PathOf(const ScratchFolder& folder, std::uint32_t recording) {
  return folder.path() + "/scan-" + std::to_string(recording) + ".mcap";
}

/// How many levels recording number `recording` gets.
std::uint32_t LevelsOf(std::uint64_t seed, std::uint32_t recording) {
  return static_cast<std::uint32_t>(1 + Dice(seed + recording).Below(kMostLevels));
}

/// A Storage put around the recording process's disk.
using StorageAround = std::unique_ptr<Storage> (*)(Storage& below);

/// How the process records.
struct RecorderPlan {
  DiskWriterMode mode = DiskWriterMode::kInline;
  StorageAround around = nullptr;
  std::uint64_t seed = 0;
};

/// The process that records one scan after another, as fast as it can, until it is killed. Never returns.
class Recorder {
 public:
  Recorder(const ScratchFolder& folder, const Scan& scan, const RecorderPlan& plan)
      : folder_(folder), scan_(scan), plan_(plan), storage_(plan.around(posix_)) {}

  [[noreturn]] void Run(int pipe) {
    pipe_ = pipe;
    for (std::uint32_t recording = 0;; ++recording) {
      if (!Record(recording)) ::_exit(1);
    }
  }

 private:
  bool Record(std::uint32_t recording) {
    RecordingOptions options;
    options.disk = plan_.mode;
    auto writer = RecordingWriter::Create(*storage_, PathOf(folder_, recording), scan_.header, options);
    if (!writer || !Say({Said::What::kCreated, recording, 0})) return false;
    const std::uint32_t levels = LevelsOf(plan_.seed, recording);
    std::uint32_t said = 0;
    for (std::uint32_t level = 0; level < levels; ++level) {
      if (!writer->AppendLevel(scan_.levels[level])) return false;
      while (level + 1 - said >= kMostUnsaid || said < writer->written_levels()) {
        if (said < writer->written_levels() && !Say({Said::What::kLevel, recording, said++})) return false;
        std::this_thread::yield();
      }
    }
    return writer->Finish() && Say({Said::What::kFinished, recording, levels});
  }

  bool Say(const Said& said) const { return ::write(pipe_, &said, sizeof said) == sizeof said; }

  const ScratchFolder& folder_;
  const Scan& scan_;
  RecorderPlan plan_;
  int pipe_ = -1;
  PosixStorage posix_;
  std::unique_ptr<Storage> storage_;
};

/// What a killed process had said of one recording.
struct Acknowledged {
  std::uint32_t levels = 0;
  bool finished = false;
};

/// What was found over all kills.
struct KillTally {
  std::uint64_t kills = 0;
  std::uint64_t acknowledged = 0;
  std::uint64_t lost = 0;
  std::uint64_t unasked = 0;  ///< Recordings with levels beyond the one being written.
  std::uint64_t false_levels = 0;
  std::uint64_t unreadable = 0;  ///< Recordings without their name, not whole under it, or without a header.
  std::uint64_t finished = 0;
  std::uint64_t killed_between = 0;  ///< Kills before a level or after the end of a recording.

  [[nodiscard]] bool ok() const { return lost + unasked + false_levels + unreadable == 0; }
};

std::ostream& operator<<(std::ostream& out, const KillTally& tally) {
  return out << tally.kills << " kills (" << tally.killed_between << " outside the levels), " << tally.acknowledged
             << " levels acknowledged, lost " << tally.lost << ", false " << tally.false_levels
             << ", more than the one being written " << tally.unasked << ", unreadable " << tally.unreadable
             << ", finished recordings " << tally.finished;
}

/// Reads one Said, waiting for it; false at the pipe's end.
bool Hear(int pipe, Said& said) {
  std::size_t got = 0;
  while (got < sizeof said) {
    const ssize_t n = ::read(pipe, reinterpret_cast<char*>(&said) + got, sizeof said - got);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    got += static_cast<std::size_t>(n);
  }
  return true;
}

/// Uses up to `steps` of this thread's time, so that the kill falls anywhere within a call.
void Spin(std::uint64_t steps) {
  volatile std::uint64_t counter = 0;
  for (std::uint64_t i = 0; i < steps; ++i) counter = counter + i;
}

/// Everything that a killed process had said, by recording.
using Heard = std::map<std::uint32_t, Acknowledged>;

/// Hears a process for a random number of words, kills it after a random time, and hears what else it had said.
Heard HearAndKill(pid_t child, int pipe, std::uint64_t seed) {
  Heard heard;
  Dice dice(seed);
  const std::uint64_t words = dice.Below(200);
  const std::uint64_t spin = dice.Below(300'000);
  Said said;
  auto note = [&] {
    Acknowledged& of = heard[said.recording];
    if (said.what == Said::What::kLevel) of.levels = said.level + 1;
    of.finished = of.finished || said.what == Said::What::kFinished;
  };
  for (std::uint64_t word = 0; word < words && Hear(pipe, said); ++word) note();
  Spin(spin);
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status)) << "the recording process ended by itself";
  while (Hear(pipe, said)) note();
  return heard;
}

/// Compares one recording with what was said of it.
void Check(const std::string& path, const std::string& temporary, const Scan& scan, const Acknowledged& said,
           KillTally& tally) {
  PosixStorage storage;
  tally.acknowledged += said.levels;
  const bool has_name = storage.Exists(path);
  tally.finished += has_name ? 1 : 0;
  const auto read = ReadWholeRecording(storage, has_name ? path : temporary);
  const bool empty = !read && read.error().seen == "it holds no readable level";
  const bool whole = read && read->report.clean();
  if ((has_name && !whole) || (said.finished && !has_name) || (!read && !empty)) ++tally.unreadable;
  const std::vector<ScanLevel> levels = read ? read->scan.levels : std::vector<ScanLevel>();
  for (std::size_t i = 0; i < levels.size(); ++i) {
    tally.false_levels += test::SameLevel(levels[i], scan.levels[i]) ? 0 : 1;
  }
  tally.lost += said.levels > levels.size() ? said.levels - levels.size() : 0;
  tally.unasked += levels.size() > said.levels + 1 ? 1 : 0;
}

void RecordKillAndCheck(const Scan& scan, const RecorderPlan& plan, KillTally& tally) {
  const ScratchFolder folder;
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // should the test itself be killed
    ::close(ends[0]);
    Recorder(folder, scan, plan).Run(ends[1]);
  }
  ::close(ends[1]);
  const Heard heard = HearAndKill(child, ends[0], plan.seed);
  ::close(ends[0]);
  ++tally.kills;
  if (heard.empty() || heard.rbegin()->second.levels == 0 || heard.rbegin()->second.finished) ++tally.killed_between;
  for (const auto& [recording, said] : heard) {
    const std::string path = PathOf(folder, recording);
    Check(path, path + ".part-" + std::to_string(child), scan, said, tally);
  }
}

KillTally KillMany(std::uint64_t kills, DiskWriterMode mode, StorageAround around) {
  const Scan scan = test::MakeScan(kMostLevels, kSensors);
  KillTally tally;
  for (std::uint64_t i = 1; i <= kills; ++i) RecordKillAndCheck(scan, {mode, around, 1000 * i}, tally);
  return tally;
}

std::unique_ptr<Storage> NothingAround(Storage& below) { return std::make_unique<test::ForwardingStorage>(below); }

/// In each mode 50 kills; ANNULUS_LONG: 250; ANNULUS_SOAK: 10,000.
std::uint64_t Kills() {
  if (std::getenv("ANNULUS_SOAK") != nullptr) return 10'000;
  return std::getenv("ANNULUS_LONG") != nullptr ? 250 : 50;
}

/// P1.
TEST(Kill, H1_LosesNoAcknowledgedLevelAndLeavesAtMostTheOneBeingWrittenMore) {
  const KillTally tally = KillMany(Kills(), DiskWriterMode::kInline, NothingAround);
  std::cout << "kill -9: " << tally << "\n";
  EXPECT_TRUE(tally.ok());
  EXPECT_GT(tally.acknowledged, 10 * tally.kills);
}

/// Levels are acknowledged when the writer's thread has written them; those that wait for it may be there or not.
TEST(Kill, H1_LosesNoLevelThatTheWritersThreadHadWritten) {
  const KillTally tally = KillMany(Kills(), DiskWriterMode::kThread, NothingAround);
  std::cout << "kill -9, thread: " << tally << "\n";
  EXPECT_EQ(tally.lost + tally.false_levels + tally.unreadable, 0U);
  EXPECT_GT(tally.acknowledged, 10 * tally.kills);
}

TEST(Kill, HarnessCatchesABufferOfTheProgramWithEarlyAcknowledgement) {
  const KillTally tally = KillMany(5, DiskWriterMode::kInline, test::BufferingStorage);
  std::cout << "kill -9, planted buffer: " << tally << "\n";
  EXPECT_GT(tally.lost, 0U);
}

}  // namespace
}  // namespace annulus
