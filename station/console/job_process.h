#pragma once

#include <chrono>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/console/job_runner.h"

namespace annulus {

/// What a process says of its progress, a line of `--progress json`.
struct ProcessProgress {
  std::string stage;
  double done = 0.0;
  double total = 0.0;
  std::optional<double> eta_s;
};

/// One run of a program.
struct ProcessOrder {
  std::string program;
  std::vector<std::string> arguments;  ///< Without the program's name.
  std::string folder;                  ///< Where it works; "": where we do.
  JobLimits limits;
  int answer_code = 0;                   ///< JobStep::answer_code.
  std::chrono::nanoseconds deadline{0};  ///< Of the system's clock; then it is killed.
};

/// Runs a program until it ends, and returns what it wrote to stdout (at most 64 MiB). A stop request is SIGINT, and
/// SIGKILL when limits.cancel_patience is over. Fails with the program's own error (`annulus: attempted: seen: advice`,
/// the last line of its stderr) if it exits with another code than 0
/// (and, if it printed something, answer_code); if a signal or the deadline ends it; if it cannot
/// be started.
Result<std::string> RunProcess(const ProcessOrder& order, const std::stop_token& stop,
                               const std::function<void(const ProcessProgress&)>& progress);

}  // namespace annulus
