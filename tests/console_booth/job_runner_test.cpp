#include "station/console/job_runner.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <condition_variable>
#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>

#include "station/console/scratch_folder.h"
#include "tests/station/served_booth.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using test::FreshFolder;
using test::kSoon;
using testing::HasSubstr;

/// What stands for our program: it does what its third argument says. The first two are `--progress json`.
constexpr const char* kProgram = R"(#!/bin/sh
shift 2
case "$1" in
  print) printf '%s' "$2" ;;
  where) pwd ;;
  nice) nice ;;
  progress)
    for stage in read fit; do
      for k in 1 2 3 4; do echo "{\"stage\":\"$stage\",\"done\":$k,\"total\":4,\"eta_s\":2.5}" >&2; done
    done ;;
  fail) echo "a warning" >&2; echo "annulus: fit it: line 3: it is bad: mend it" >&2; exit 1 ;;
  mute) exit 3 ;;
  wait) exec tail -f /dev/null ;;
  deaf) trap '' INT; echo '{"stage":"deaf","done":0,"total":1}' >&2; tail -f /dev/null; exit 0 ;;
  die) kill -KILL $$ ;;
  memory) x=aaaaaaaaaaaaaaaa; while :; do x="$x$x"; done ;;
esac
)";

class JobRunnerTest : public testing::Test {
 protected:
  JobRunnerTest() { Make({}); }
  void Make(const JobLimits& limits) {
    runner_.reset();
    const std::string program = folder_ / "program";
    std::ofstream(program) << kProgram;
    ::chmod(program.c_str(), 0700);
    runner_ = JobRunner::Make(
        program, [this](const JobStatus& job) { Changed(job); }, limits);
  }
  ~JobRunnerTest() override { runner_.reset(); }

  static JobRequest Request(std::vector<std::vector<std::string>> steps) {
    JobRequest request;
    request.kind = "test";
    request.owner = "anna";
    for (auto& arguments : steps) request.steps.push_back({arguments.front(), std::move(arguments)});
    return request;
  }
  JobStatus WaitUntil(const std::string& id, const std::function<bool(const JobStatus&)>& wanted) {
    std::unique_lock lock(mutex_);
    JobStatus now;
    EXPECT_TRUE(changed_.wait_for(lock, 3 * kSoon,
                                  [&] {
                                    now = *runner_->Get(id);
                                    return wanted(now);
                                  }))
        << "it is " << JobStateName(now.state);
    return now;
  }
  JobStatus WaitEnd(const std::string& id) {
    return WaitUntil(
        id, [](const JobStatus& job) { return job.state != JobState::kWaiting && job.state != JobState::kRunning; });
  }
  std::vector<JobStatus> Heard() {
    const std::lock_guard lock(mutex_);
    return heard_;
  }

  FreshFolder folder_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<JobStatus> heard_;
  std::unique_ptr<JobRunner> runner_;

 private:
  void Changed(const JobStatus& job) {
    const std::lock_guard lock(mutex_);
    heard_.push_back(job);
    changed_.notify_all();
  }
};

TEST_F(JobRunnerTest, HandsOnWhatStepsPrintAndTheResult) {
  std::vector<std::string> printed;
  JobRequest request = Request({{"print", "{\"a\": 1}"}, {"print", "second"}});
  request.after_step = [&](std::size_t step, const std::string& text) -> Status {
    printed.push_back(std::to_string(step) + text);
    return {};
  };
  request.finish = []() -> Result<nlohmann::ordered_json> { return nlohmann::ordered_json{{"scan_id", "S-1"}}; };
  const JobStatus job = WaitEnd(runner_->Start(std::move(request)));
  EXPECT_EQ(job.state, JobState::kDone);
  EXPECT_EQ(job.result_json, R"({"scan_id":"S-1"})");
  EXPECT_EQ(job.share, 1.0);
  EXPECT_THAT(printed, testing::ElementsAre("0{\"a\": 1}", "1second"));
}

TEST_F(JobRunnerTest, TellsProgressThatNeverFalls) {
  const JobStatus job = WaitEnd(runner_->Start(Request({{"progress"}, {"progress"}})));
  EXPECT_EQ(job.state, JobState::kDone);
  double share = 0.0;
  for (const JobStatus& one : Heard()) {
    EXPECT_GE(one.share, share);
    share = one.share;
  }
  EXPECT_EQ(share, 1.0);
}

TEST_F(JobRunnerTest, KeepsTheProgramsOwnError) {
  const JobStatus job = WaitEnd(runner_->Start(Request({{"fail"}, {"print", "never"}})));
  EXPECT_EQ(job.state, JobState::kFailed);
  ASSERT_TRUE(job.error);
  EXPECT_EQ(job.error->attempted, "fit it");
  EXPECT_EQ(job.error->seen, "line 3: it is bad");
  EXPECT_EQ(job.error->advice, "mend it");
  const JobStatus mute = WaitEnd(runner_->Start(Request({{"mute"}})));
  ASSERT_TRUE(mute.error);
  EXPECT_THAT(mute.error->seen, HasSubstr("code 3"));
}

TEST_F(JobRunnerTest, SaysThatAProcessWasKilled) {
  const JobStatus job = WaitEnd(runner_->Start(Request({{"die"}})));
  EXPECT_EQ(job.state, JobState::kFailed);
  ASSERT_TRUE(job.error);
  EXPECT_THAT(job.error->seen, HasSubstr("signal 9"));
}

TEST_F(JobRunnerTest, FailsAProcessThatTakesAllMemoryAndGoesOn) {
  JobLimits limits;
  limits.memory_bytes = std::uint64_t{64} << 20;
  Make(limits);
  const JobStatus job = WaitEnd(runner_->Start(Request({{"memory"}})));
  EXPECT_EQ(job.state, JobState::kFailed);
  EXPECT_EQ(WaitEnd(runner_->Start(Request({{"print", "x"}}))).state, JobState::kDone);
}

TEST_F(JobRunnerTest, CancelsWhatRunsAndWhatWaits) {
  const std::string first = runner_->Start(Request({{"wait"}}));
  const std::string second = runner_->Start(Request({{"wait"}}));
  const std::string third = runner_->Start(Request({{"wait"}}));
  WaitUntil(second, [](const JobStatus& job) { return job.state == JobState::kRunning; });
  EXPECT_EQ(runner_->Get(third)->state, JobState::kWaiting) << "two run at once";
  ASSERT_TRUE(runner_->Cancel(third));
  EXPECT_EQ(WaitEnd(third).state, JobState::kCancelled);
  ASSERT_TRUE(runner_->Cancel(first));
  ASSERT_TRUE(runner_->Cancel(second));
  EXPECT_EQ(WaitEnd(first).state, JobState::kCancelled);
  EXPECT_EQ(WaitEnd(second).state, JobState::kCancelled);
  EXPECT_TRUE(runner_->Cancel(first)) << "once more does no harm";
  EXPECT_FALSE(runner_->Cancel("J-99"));
}

TEST_F(JobRunnerTest, RunsOneOfALaneAtATimeAndLetsOthersPass) {
  const auto in_lane = [](std::vector<std::vector<std::string>> steps) {
    JobRequest request = Request(std::move(steps));
    request.lane = "history";
    return request;
  };
  const std::string first = runner_->Start(in_lane({{"wait"}}));
  WaitUntil(first, [](const JobStatus& job) { return job.state == JobState::kRunning; });
  const std::string second = runner_->Start(in_lane({{"print", "a"}}));
  EXPECT_EQ(WaitEnd(runner_->Start(Request({{"print", "b"}}))).state, JobState::kDone) << "of no lane";
  EXPECT_EQ(runner_->Get(second)->state, JobState::kWaiting);
  ASSERT_TRUE(runner_->Cancel(first));
  EXPECT_EQ(WaitEnd(second).state, JobState::kDone);
}

TEST_F(JobRunnerTest, PlansAJobWhenItsTurnHasCome) {
  std::string printed;
  JobRequest request = Request({});
  request.plan = []() -> Result<std::vector<JobStep>> {
    return std::vector<JobStep>{{"print", {"print", "as planned"}}};
  };
  request.after_step = [&](std::size_t, const std::string& text) -> Status {
    printed = text;
    return {};
  };
  EXPECT_EQ(WaitEnd(runner_->Start(std::move(request))).state, JobState::kDone);
  EXPECT_EQ(printed, "as planned");
  JobRequest refused = Request({{"print", "a"}});
  refused.plan = []() -> Result<std::vector<JobStep>> { return Fail("plan", "there is no room", "make some"); };
  const JobStatus failed = WaitEnd(runner_->Start(std::move(refused)));
  EXPECT_EQ(failed.state, JobState::kFailed);
  EXPECT_EQ(failed.error->seen, "there is no room");
}

TEST_F(JobRunnerTest, KillsWhatDoesNotListen) {
  JobLimits limits;
  limits.cancel_patience = milliseconds(100);
  Make(limits);
  const std::string id = runner_->Start(Request({{"deaf"}}));
  WaitUntil(id, [](const JobStatus& job) { return job.state == JobState::kRunning && job.stage == "deaf"; });
  ASSERT_TRUE(runner_->Cancel(id));
  EXPECT_EQ(WaitEnd(id).state, JobState::kCancelled);
}

TEST_F(JobRunnerTest, EndsWhatTakesTooLong) {
  JobRequest request = Request({{"wait"}});
  request.limit = std::chrono::seconds(0);
  const JobStatus job = WaitEnd(runner_->Start(std::move(request)));
  EXPECT_EQ(job.state, JobState::kFailed);
  ASSERT_TRUE(job.error);
  EXPECT_THAT(job.error->seen, HasSubstr("longer than it may"));
}

TEST_F(JobRunnerTest, WorksInItsFolderAndRemovesItHoweverItEnds) {
  for (const std::string what : {"where", "fail", "wait"}) {
    const std::string work = folder_ / ("work-" + what);
    std::filesystem::create_directories(work);
    std::ofstream(work + "/opened") << "a customer's";
    JobRequest request = Request({{what}});
    request.folder = work;
    std::string seen;
    request.after_step = [&](std::size_t, const std::string& text) -> Status {
      seen = text;
      return {};
    };
    const std::string id = runner_->Start(std::move(request));
    if (what == "wait") {
      WaitUntil(id, [](const JobStatus& job) { return job.state == JobState::kRunning; });
      ASSERT_TRUE(runner_->Cancel(id));
    }
    WaitEnd(id);
    EXPECT_FALSE(std::filesystem::exists(work)) << what;
    if (what == "where") {
      EXPECT_EQ(seen, work + "\n");
    }
  }
}

TEST_F(JobRunnerTest, RunsBehindEverythingElse) {
  std::string printed;
  JobRequest request = Request({{"nice"}});
  request.after_step = [&](std::size_t, const std::string& text) -> Status {
    printed = text;
    return {};
  };
  WaitEnd(runner_->Start(std::move(request)));
  EXPECT_EQ(printed, "10\n");
}

TEST_F(JobRunnerTest, TakesOurOwnMistakesForTheJobs) {
  JobRequest request = Request({{"print", "x"}});
  request.finish = []() -> Result<nlohmann::ordered_json> { throw std::logic_error("we were wrong"); };
  const JobStatus job = WaitEnd(runner_->Start(std::move(request)));
  EXPECT_EQ(job.state, JobState::kFailed);
  EXPECT_THAT(job.error->seen, HasSubstr("we were wrong"));
}

TEST_F(JobRunnerTest, EndsSoonWithJobsThatRunAndWait) {
  for (int k = 0; k < 4; ++k) runner_->Start(Request({{k % 2 == 0 ? "deaf" : "wait"}}));
  const auto begin = std::chrono::steady_clock::now();
  runner_.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, milliseconds(4000));
}

TEST(ScratchFolder, IsItsOwnersAloneAndGoesWithTheConsole) {
  std::string path;
  {
    auto scratch = ScratchFolder::Make("");
    ASSERT_TRUE(scratch) << scratch.error().Text();
    path = (*scratch)->path();
    const auto folder = (*scratch)->NewFolder();
    ASSERT_TRUE(folder);
    struct stat found {};
    ASSERT_EQ(::stat(folder->c_str(), &found), 0);
    EXPECT_EQ(found.st_mode & 0777U, 0700U);
    std::ofstream(*folder + "/scan.mcap") << "opened";
    const auto other = (*scratch)->NewFolder();
    EXPECT_NE(*folder, *other);
    (*scratch)->Remove(*other);
    EXPECT_FALSE(std::filesystem::exists(*other));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(ScratchFolder, RemovesWhatAConsoleThatWasKilledHasLeft) {
  FreshFolder parent;
  const std::string uid = std::to_string(::geteuid());
  // No process has so large a number.
  const std::string left = parent / ("annulus-scratch-" + uid + "-99999999-abcdef");
  const std::string alive = parent / ("annulus-scratch-" + uid + "-" + std::to_string(::getpid()) + "-abcdef");
  std::filesystem::create_directories(left + "/1");
  std::filesystem::create_directories(alive);
  const auto scratch = ScratchFolder::Make(parent / "");
  ASSERT_TRUE(scratch);
  EXPECT_FALSE(std::filesystem::exists(left));
  EXPECT_TRUE(std::filesystem::exists(alive)) << "another console of ours works there";
}

}  // namespace
}  // namespace annulus
