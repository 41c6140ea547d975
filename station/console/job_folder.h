#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "station/console/console_context.h"
#include "station/console/job_runner.h"
#include "station/console/route.h"
#include "station/store/store_types.h"

namespace annulus {

/// A folder in which a job's command finds its inputs and leaves its results. Removed unless a job has taken it over.
/// Borrows the context.
class JobFolder {
 public:
  static Result<JobFolder> Make(ConsoleContext& context);
  JobFolder(JobFolder&& other) noexcept;
  JobFolder& operator=(JobFolder&&) = delete;
  ~JobFolder();

  [[nodiscard]] const std::string& path() const { return path_; }
  /// A file of it.
  [[nodiscard]] std::string File(std::string_view name) const;
  Status PutText(std::string_view name, const std::string& text);
  Status PutArtefact(std::string_view name, const std::string& artefact_id);
  /// The recording of a scan, opened.
  Status PutRecording(std::string_view name, const std::string& scan_id);
  /// The newest model of a scan. Fails if it has not been fitted.
  Status PutModel(std::string_view name, const std::string& scan_id);

  /// Gives the folder to the job and starts it: the runner removes it.
  std::string Start(JobRequest request);

 private:
  JobFolder(ConsoleContext& context, std::string path) : context_(&context), path_(std::move(path)) {}

  ConsoleContext* context_;
  std::string path_;  ///< Empty once it was given away.
};

/// A folder with the newest model of a scan in it, as model.json. 404 without the scan, 409 without a model.
[[nodiscard]] tl::expected<JobFolder, ApiError> FolderWithModel(ConsoleContext& context, const std::string& scan_id);

/// Takes a file that a job has made into the store, for a scan. `what`: kind, name, derived, recipe.
[[nodiscard]] Result<Artefact> KeepResult(ConsoleContext& context, const std::string& scan_id, const std::string& file,
                                          Artefact what);

/// docs/console_api.md §6: {id, kind, subject, state, stage, share, eta_s, error, result}.
[[nodiscard]] nlohmann::ordered_json JobJson(const JobStatus& job);

/// docs/console_api.md §6 of a job that was just started.
[[nodiscard]] ApiResult JobAnswer(const JobRunner& jobs, const std::string& id);

/// The job of an id if it is the caller's own and of this kind ("": any); 404 otherwise.
[[nodiscard]] tl::expected<JobStatus, ApiError> OwnJob(const ConsoleContext& context, const Caller& caller,
                                                       const std::string& id, std::string_view kind);

/// Who may see a caller's jobs.
[[nodiscard]] inline std::string JobOwner(const Caller& caller) { return caller.user; }

}  // namespace annulus
