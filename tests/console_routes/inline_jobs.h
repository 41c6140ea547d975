#pragma once

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "station/command_line.h"
#include "station/console/job_runner.h"
#include "station/console/scratch_folder.h"

namespace annulus::test {

/// Runs the steps of a job in this process, before Start returns. Thread-bound.
class InlineJobs final : public JobRunner {
 public:
  explicit InlineJobs(ScratchFolder& scratch) : scratch_(scratch) {}

  std::string Start(JobRequest request) override {
    JobStatus job;
    job.id = "J-" + std::to_string(jobs_.size() + 1);
    job.kind = request.kind;
    job.owner = request.owner;
    job.subject = request.subject;
    if (const Status run = Run(request, job); run) {
      job.state = JobState::kDone;
      job.share = 1.0;
    } else {
      job.state = JobState::kFailed;
      job.error = run.error();
    }
    if (!request.folder.empty()) scratch_.Remove(request.folder);
    jobs_[job.id] = job;
    return job.id;
  }
  [[nodiscard]] std::optional<JobStatus> Get(const std::string& id) const override {
    const auto found = jobs_.find(id);
    return found == jobs_.end() ? std::nullopt : std::optional(found->second);
  }
  [[nodiscard]] std::vector<JobStatus> All() const override { return {}; }
  Status Cancel(const std::string&) override { return {}; }

 private:
  static Status Run(JobRequest& request, JobStatus& job) {
    if (request.plan) {
      auto planned = request.plan();
      if (!planned) return Fail(planned);
      request.steps = std::move(*planned);
    }
    for (std::size_t step = 0; step < request.steps.size(); ++step) {
      std::vector<const char*> arguments{"annulus"};
      for (const std::string& argument : request.steps[step].arguments) arguments.push_back(argument.c_str());
      testing::internal::CaptureStdout();
      testing::internal::CaptureStderr();
      const int code = RunCommandLine(static_cast<int>(arguments.size()), arguments.data(), {});
      const std::string errors = testing::internal::GetCapturedStderr();
      const std::string printed = testing::internal::GetCapturedStdout();
      const bool is_answer = code == request.steps[step].answer_code && !printed.empty();
      if (code != 0 && !is_answer) return Fail("run " + request.steps[step].stage, errors, "look at it");
      if (request.after_step) RETURN_IF_ERROR(request.after_step(step, printed));
    }
    if (!request.finish) return {};
    const auto result = request.finish();
    if (!result) return Fail(result);
    job.result_json = result->dump();
    return {};
  }

  ScratchFolder& scratch_;
  std::map<std::string, JobStatus> jobs_;
};

}  // namespace annulus::test
