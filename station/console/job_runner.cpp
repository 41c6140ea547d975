#include "station/console/job_runner.h"

#include <algorithm>
#include <array>
#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>
#include <utility>

#include "base/clock.h"
#include "base/log.h"
#include "station/console/job_process.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr std::size_t kProcesses = 2;
constexpr std::size_t kRemembered = 100;
constexpr milliseconds kTellEvery{100};

/// How far a step is whose stages come one after the other, each from 0 to its total, and nobody knows how many: every
/// further stage takes half of what is left.
class StepShare {
 public:
  double At(const ProcessProgress& progress) {
    const double of_stage = progress.total > 0.0 ? std::clamp(progress.done / progress.total, 0.0, 1.0) : 0.0;
    if (progress.stage != stage_) {
      if (!stage_.empty()) begin_ += (1.0 - begin_) / 2.0;
      stage_ = progress.stage;
    }
    share_ = std::max(share_, begin_ + (1.0 - begin_) / 2.0 * of_stage);
    return share_;
  }

 private:
  std::string stage_;
  double begin_ = 0.0;
  double share_ = 0.0;
};

struct Job {
  JobRequest request;
  JobStatus status;
  std::stop_source stop;
  nanoseconds told{0};
};

bool HasEnded(JobState state) { return state != JobState::kWaiting && state != JobState::kRunning; }

class Runner final : public JobRunner {
 public:
  Runner(std::string program, std::function<void(const JobStatus&)> changed, JobLimits limits)
      : program_(std::move(program)), changed_(std::move(changed)), limits_(limits) {
    for (std::jthread& worker : workers_) {
      worker = std::jthread([this](const std::stop_token& stop) { Work(stop); });
    }
  }
  ~Runner() override {
    {
      const std::lock_guard lock(mutex_);
      limits_.cancel_patience = std::min(limits_.cancel_patience, milliseconds(1000));
      for (auto& [number, job] : jobs_) job->stop.request_stop();
    }
    for (std::jthread& worker : workers_) worker.request_stop();
    for (std::jthread& worker : workers_) worker.join();
    for (const std::shared_ptr<Job>& job : waiting_) RemoveFolder(*job);
  }

  std::string Start(JobRequest request) override {
    auto job = std::make_shared<Job>();
    {
      const std::lock_guard lock(mutex_);
      const std::uint64_t number = ++last_number_;
      job->status.id = "J-" + std::to_string(number);
      job->status.kind = request.kind;
      job->status.owner = request.owner;
      job->status.subject = request.subject;
      job->request = std::move(request);
      jobs_.emplace(number, job);
      waiting_.push_back(job);
      Forget();
    }
    const std::string id = job->status.id;
    Change(*job, [](JobStatus&) {});
    wake_.notify_one();
    return id;
  }
  [[nodiscard]] std::optional<JobStatus> Get(const std::string& id) const override {
    const std::lock_guard lock(mutex_);
    const auto job = Find(id);
    return job ? std::optional(job->status) : std::nullopt;
  }
  [[nodiscard]] std::vector<JobStatus> All() const override {
    const std::lock_guard lock(mutex_);
    std::vector<JobStatus> all;
    for (const auto& [number, job] : jobs_) all.push_back(job->status);
    return all;
  }
  Status Cancel(const std::string& id) override {
    std::shared_ptr<Job> waited;
    {
      const std::lock_guard lock(mutex_);
      const auto job = Find(id);
      if (!job) return Fail("cancel the job " + id, "there is none", "look at the list of jobs");
      job->stop.request_stop();
      const auto place = std::find(waiting_.begin(), waiting_.end(), job);
      if (place == waiting_.end()) return {};
      waiting_.erase(place);
      waited = job;
    }
    End(*waited, JobState::kCancelled, {}, "");
    return {};
  }

 private:
  [[nodiscard]] std::shared_ptr<Job> Find(const std::string& id) const {
    for (const auto& [number, job] : jobs_) {
      if (job->status.id == id) return job;
    }
    return nullptr;
  }
  /// Old jobs that ended, beyond those that are remembered. With the lock held.
  void Forget() {
    std::size_t ended = 0;
    for (const auto& [number, job] : jobs_) ended += HasEnded(job->status.state) ? 1 : 0;
    for (auto job = jobs_.begin(); job != jobs_.end() && ended > kRemembered;) {
      const bool old = HasEnded(job->second->status.state);
      ended -= old ? 1 : 0;
      job = old ? jobs_.erase(job) : std::next(job);
    }
  }

  template <class Apply>
  void Change(Job& job, Apply apply) {
    JobStatus now;
    {
      const std::lock_guard lock(mutex_);
      apply(job.status);
      job.told = clock_.Now();
      now = job.status;
    }
    if (changed_) changed_(now);
  }

  void Work(const std::stop_token& stop) {
    while (true) {
      std::shared_ptr<Job> job;
      {
        std::unique_lock lock(mutex_);
        if (!wake_.wait(lock, stop, [this] { return Next() != waiting_.end(); }) || stop.stop_requested()) return;
        const auto next = Next();
        job = *next;
        waiting_.erase(next);
        lanes_.insert(job->request.lane);
      }
      Carry(*job);
      const std::lock_guard lock(mutex_);
      lanes_.erase(job->request.lane);
      wake_.notify_all();
    }
  }

  /// The first job whose lane is free. With the lock held.
  std::deque<std::shared_ptr<Job>>::iterator Next() {
    return std::find_if(waiting_.begin(), waiting_.end(), [this](const std::shared_ptr<Job>& job) {
      return job->request.lane.empty() || !lanes_.contains(job->request.lane);
    });
  }

  void Carry(Job& job) {
    const nanoseconds deadline = clock_.Now() + job.request.limit;
    Change(job, [&](JobStatus& status) { status.state = JobState::kRunning; });
    Status outcome = Plan(job);
    Change(job, [&](JobStatus& status) {
      if (!job.request.steps.empty()) status.stage = job.request.steps.front().stage;
    });
    for (std::size_t step = 0; outcome && step < job.request.steps.size(); ++step) outcome = Step(job, step, deadline);
    std::string result = "null";
    if (outcome && !job.stop.stop_requested()) outcome = Finish(job, result);
    if (job.stop.stop_requested()) {
      End(job, JobState::kCancelled, {}, "");
    } else if (!outcome) {
      End(job, JobState::kFailed, outcome.error(), "");
    } else {
      End(job, JobState::kDone, {}, result);
    }
  }

  static Status Plan(Job& job) {
    if (!job.request.plan) return {};
    return Guarded([&]() -> Status {
      auto steps = job.request.plan();
      if (!steps) return Fail(steps);
      job.request.steps = std::move(*steps);
      return {};
    });
  }

  Status Step(Job& job, std::size_t step, nanoseconds deadline) {
    const JobStep& one = job.request.steps[step];
    const auto begin = static_cast<double>(step);
    const auto steps = static_cast<double>(job.request.steps.size());
    Change(job, [&](JobStatus& status) {
      status.stage = one.stage;
      status.share = std::max(status.share, begin / steps);
      status.eta_s.reset();
    });
    ProcessOrder order{program_, {"--progress", "json"}, job.request.folder, Limits(), one.answer_code, deadline};
    order.arguments.insert(order.arguments.end(), one.arguments.begin(), one.arguments.end());
    StepShare share;
    const auto printed = RunProcess(order, job.stop.get_token(), [&](const ProcessProgress& progress) {
      Progress(job, progress, (begin + share.At(progress)) / steps);
    });
    if (!printed) return Fail(printed);
    return job.request.after_step ? Guarded([&] { return job.request.after_step(step, *printed); }) : Status{};
  }

  void Progress(Job& job, const ProcessProgress& progress, double share) {
    {
      const std::lock_guard lock(mutex_);
      job.status.share = std::max(job.status.share, share);
      job.status.eta_s = progress.eta_s;
      if (!progress.stage.empty()) job.status.stage = progress.stage;
      if (clock_.Now() - job.told < kTellEvery) return;
    }
    Change(job, [](JobStatus&) {});
  }

  Status Finish(Job& job, std::string& result) {
    if (!job.request.finish) return {};
    return Guarded([&]() -> Status {
      const auto finished = job.request.finish();
      if (!finished) return Fail(finished);
      result = finished->dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
      return {};
    });
  }

  /// Our own mistakes end the job, not the console.
  static Status Guarded(const std::function<Status()>& work) {
    try {
      return work();
    } catch (const std::exception& mistake) {
      return Fail("finish a job", mistake.what(), "report it: it is a mistake of the program");
    }
  }

  void End(Job& job, JobState state, std::optional<Error> error, std::string result) {
    RemoveFolder(job);
    if (error) Log(LogLevel::kWarning, "job " + job.status.id + " (" + job.request.kind + "): " + error->Text());
    Change(job, [&](JobStatus& status) {
      status.state = state;
      status.error = std::move(error);
      status.result_json = std::move(result);
      status.eta_s.reset();
      if (state == JobState::kDone) status.share = 1.0;
      // What was captured may hold what a customer said.
      job.request.plan = nullptr;
      job.request.after_step = nullptr;
      job.request.finish = nullptr;
    });
  }

  static void RemoveFolder(const Job& job) {
    if (job.request.folder.empty()) return;
    std::error_code failed;
    std::filesystem::remove_all(job.request.folder, failed);
    if (failed) Log(LogLevel::kError, "a job's folder could not be removed: " + failed.message());
  }

  [[nodiscard]] JobLimits Limits() const {
    const std::lock_guard lock(mutex_);
    return limits_;
  }

  const std::string program_;
  const std::function<void(const JobStatus&)> changed_;
  SystemClock clock_;
  mutable std::mutex mutex_;  ///< Of what follows, and of the status of every job.
  JobLimits limits_;
  std::condition_variable_any wake_;
  std::map<std::uint64_t, std::shared_ptr<Job>>
      jobs_;  ///< By number. Shared: a worker keeps its own while it is listed.
  std::deque<std::shared_ptr<Job>> waiting_;
  std::set<std::string> lanes_;  ///< Of the jobs that run.
  std::uint64_t last_number_ = 0;
  std::array<std::jthread, kProcesses> workers_;  ///< Last: they end first.
};

}  // namespace

std::string_view JobStateName(JobState state) {
  static constexpr std::array<std::string_view, 5> kNames{"waiting", "running", "done", "failed", "cancelled"};
  return kNames.at(static_cast<std::size_t>(state));
}

std::unique_ptr<JobRunner> JobRunner::Make(std::string program, std::function<void(const JobStatus&)> changed,
                                           JobLimits limits) {
  return std::make_unique<Runner>(std::move(program), std::move(changed), limits);
}

}  // namespace annulus
