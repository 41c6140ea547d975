#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>

#include "acquisition/recording.h"
#include "tests/acquisition/scan_fixture.h"
#include "tests/support/dice.h"

namespace annulus {
namespace {

using test::Dice;

constexpr std::uint32_t kMostLevels = 120;
constexpr std::size_t kSensors = 6;

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

/// The process that records one scan after another, as fast as it can, until it is killed. Never returns.
class Recorder {
 public:
  Recorder(const ScratchFolder& folder, const Scan& scan, std::uint64_t seed, int pipe)
      : folder_(folder), scan_(scan), seed_(seed), pipe_(pipe) {}

  [[noreturn]] void Run() {
    for (std::uint32_t recording = 0;; ++recording) {
      if (!Record(recording)) ::_exit(1);
    }
  }

 private:
  bool Record(std::uint32_t recording) {
    auto writer = RecordingWriter::Create(storage_, PathOf(folder_, recording), scan_.header);
    if (!writer || !Say({Said::What::kCreated, recording, 0})) return false;
    const std::uint32_t levels = LevelsOf(seed_, recording);
    for (std::uint32_t level = 0; level < levels; ++level) {
      if (!writer->AppendLevel(scan_.levels[level])) return false;
      if (!Say({Said::What::kLevel, recording, level})) return false;
    }
    return writer->Finish() && Say({Said::What::kFinished, recording, levels});
  }

  bool Say(const Said& said) const { return ::write(pipe_, &said, sizeof said) == sizeof said; }

  const ScratchFolder& folder_;
  const Scan& scan_;
  std::uint64_t seed_;
  int pipe_;
  PosixStorage storage_;
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
  std::uint64_t unasked = 0;  ///< Levels beyond the one being written.
  std::uint64_t false_levels = 0;
  std::uint64_t finished = 0;
  std::uint64_t killed_between = 0;  ///< Kills before a level or after the end of a recording.
};

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

/// Lets a process record, kills it after a random number of words, and hears what else it had said.
std::map<std::uint32_t, Acknowledged> RecordAndKill(const ScratchFolder& folder, const Scan& scan, std::uint64_t seed,
                                                    pid_t& child) {
  std::map<std::uint32_t, Acknowledged> heard;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return heard;
  child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    Recorder(folder, scan, seed, ends[1]).Run();
  }
  ::close(ends[1]);
  Dice dice(seed);
  const std::uint64_t words = dice.Below(200);
  const std::uint64_t spin = dice.Below(300'000);
  Said said;
  auto note = [&] {
    Acknowledged& of = heard[said.recording];
    if (said.what == Said::What::kLevel) of.levels = said.level + 1;
    of.finished = of.finished || said.what == Said::What::kFinished;
  };
  for (std::uint64_t word = 0; word < words && Hear(ends[0], said); ++word) note();
  Spin(spin);
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status)) << "the recording process ended by itself";
  while (Hear(ends[0], said)) note();
  ::close(ends[0]);
  return heard;
}

/// Compares one recording with what was said of it.
void Check(const std::string& path, const std::string& temporary, const Scan& scan, const Acknowledged& said,
           KillTally& tally) {
  PosixStorage storage;
  tally.acknowledged += said.levels;
  const bool has_name = storage.Exists(path);
  EXPECT_TRUE(has_name || !said.finished) << path;
  const auto read = ReadWholeRecording(storage, has_name ? path : temporary);
  if (!read) {
    EXPECT_EQ(read.error().seen, "it holds no readable level");
    tally.lost += said.levels;
    return;
  }
  EXPECT_TRUE(!has_name || read->report.clean()) << path;
  tally.finished += has_name ? 1 : 0;
  const std::vector<ScanLevel>& levels = read->scan.levels;
  for (std::size_t i = 0; i < levels.size(); ++i)
    tally.false_levels += test::SameLevel(levels[i], scan.levels[i]) ? 0 : 1;
  tally.lost += said.levels > levels.size() ? said.levels - levels.size() : 0;
  tally.unasked += levels.size() > said.levels + 1 ? 1 : 0;
}

KillTally KillMany(std::uint64_t kills) {
  const Scan scan = test::MakeScan(kMostLevels, kSensors);
  KillTally tally;
  for (std::uint64_t seed = 1; seed <= kills; ++seed) {
    const ScratchFolder folder;
    pid_t child = 0;
    const auto heard = RecordAndKill(folder, scan, seed * 1000, child);
    ++tally.kills;
    if (heard.empty() || heard.rbegin()->second.levels == 0 || heard.rbegin()->second.finished) ++tally.killed_between;
    for (const auto& [recording, said] : heard) {
      const std::string path = PathOf(folder, recording);
      Check(path, path + ".part-" + std::to_string(child), scan, said, tally);
    }
  }
  return tally;
}

/// P1, H1. 100 kills; ANNULUS_LONG: 500; ANNULUS_SOAK: 20,000.
TEST(Kill, H1_LosesNoAcknowledgedLevel) {
  const std::uint64_t kills =
      std::getenv("ANNULUS_SOAK") != nullptr ? 20'000 : (std::getenv("ANNULUS_LONG") != nullptr ? 500 : 100);
  const KillTally tally = KillMany(kills);
  std::cout << "kill -9: " << tally.kills << " kills (" << tally.killed_between << " outside the levels), "
            << tally.acknowledged << " levels acknowledged, lost " << tally.lost << ", false " << tally.false_levels
            << ", more than the one being written " << tally.unasked << ", finished recordings " << tally.finished
            << "\n";
  EXPECT_EQ(tally.lost, 0U);
  EXPECT_EQ(tally.false_levels, 0U);
  EXPECT_EQ(tally.unasked, 0U);
  EXPECT_GT(tally.acknowledged, 10 * kills);
}

}  // namespace
}  // namespace annulus
