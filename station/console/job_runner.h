#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace annulus {

/// One step of a job: our own program with these arguments, its progress read from stderr, its JSON from stdout.
struct JobStep {
  std::string stage;                   ///< For people: "fit the surface".
  std::vector<std::string> arguments;  ///< Of `annulus`, without the program's name.
  /// With this exit code what it printed is an answer all the same ("a problem was found"); 0: there is no such code.
  int answer_code = 0;
};

/// Long work in processes of its own (of lower priority, with limits of memory and time), so that whatever becomes of
/// one, the console goes on. At most two run at once, and one of each lane; the rest wait in order.
struct JobRequest {
  std::string kind;     ///< "fit", "picture", "rank" …
  std::string owner;    ///< Session or user that may see and cancel it.
  std::string subject;  ///< Id of what it is about.
  std::string folder;   ///< Where it works; removed at its end.
  std::string lane;     ///< Of jobs that change the same thing, so that one sees what the other made; "": of none.
  std::vector<JobStep> steps;
  /// Called in the runner's thread before the first step: what there is to do by now, in place of `steps`. May be
  /// empty.
  std::function<Result<std::vector<JobStep>>()> plan;
  /// Called in the runner's thread after each step that succeeded, with what it printed on stdout; an Error ends the
  /// job. May be empty.
  std::function<Status(std::size_t step, const std::string& printed)> after_step;
  /// Called in the runner's thread once all steps are done: takes the results into the store; what it returns is the
  /// job's result.
  std::function<Result<nlohmann::ordered_json>()> finish;
  std::chrono::seconds limit{600};
};

enum class JobState { kWaiting, kRunning, kDone, kFailed, kCancelled };

struct JobStatus {
  std::string id;  ///< "J-12".
  std::string kind;
  std::string owner;
  std::string subject;
  JobState state = JobState::kWaiting;
  std::string stage;
  double share = 0.0;  ///< Of all steps, 0 … 1.
  std::optional<double> eta_s;
  std::optional<Error> error;  ///< Of a job that failed.
  std::string result_json;     ///< Of one that is done.
};

/// What one process of a job may take. Beyond its memory it fails like any program that gets none.
struct JobLimits {
  std::uint64_t memory_bytes = std::uint64_t{6} << 30;  ///< Address space (RLIMIT_AS); 0: as much as there is.
  std::uint64_t file_bytes = std::uint64_t{2} << 30;    ///< Of one file.
  int nice = 10;
  std::chrono::milliseconds cancel_patience{2000};  ///< From SIGINT to SIGKILL.
};

/// The last step of a job takes the console's own thread; what it throws is the job's failure.
///
///     waiting --a process is free--> running --all steps and finish--> done
///        |                              |-- a step fails, limit, killed, finish fails --> failed
///        '--cancel--> cancelled <-------'-- cancel
///
/// Processes get SIGKILL when the console dies. The last hundred jobs that ended are remembered. Thread-safe.
class JobRunner {
 public:
  /// `program`: what is run (/proc/self/exe). `changed` is told of every change, of progress at most ten times a
  /// second, from the runner's threads.
  static std::unique_ptr<JobRunner> Make(std::string program, std::function<void(const JobStatus&)> changed,
                                         JobLimits limits = {});
  /// Stops all jobs, killing what does not end within a second.
  virtual ~JobRunner() = default;

  virtual std::string Start(JobRequest request) = 0;
  [[nodiscard]] virtual std::optional<JobStatus> Get(const std::string& id) const = 0;
  [[nodiscard]] virtual std::vector<JobStatus> All() const = 0;
  /// Success also if it has ended already.
  virtual Status Cancel(const std::string& id) = 0;
};

/// "waiting", "running", "done", "failed", "cancelled".
[[nodiscard]] std::string_view JobStateName(JobState state);

}  // namespace annulus
