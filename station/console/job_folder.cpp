#include "station/console/job_folder.h"

#include <nlohmann/json.hpp>
#include <span>
#include <utility>
#include <vector>

#include "station/console/route_errors.h"
#include "station/console/scan_json.h"
#include "station/console/scratch_folder.h"
#include "station/store/store.h"

namespace annulus {

using Json = nlohmann::ordered_json;

Json JobJson(const JobStatus& job) {
  Json json{{"id", job.id},
            {"kind", job.kind},
            {"subject", job.subject},
            {"state", JobStateName(job.state)},
            {"stage", job.stage},
            {"share", job.share},
            {"eta_s", job.eta_s ? Json(*job.eta_s) : Json()},
            {"error", nullptr},
            {"result", nullptr}};
  if (job.error) json["error"] = ErrorJson(*job.error);
  if (!job.result_json.empty()) json["result"] = Json::parse(job.result_json);
  return json;
}

Result<JobFolder> JobFolder::Make(ConsoleContext& context) {
  auto path = context.scratch.NewFolder();
  if (!path) return Fail(path);
  return JobFolder(context, std::move(*path));
}

JobFolder::JobFolder(JobFolder&& other) noexcept
    : context_(other.context_), path_(std::exchange(other.path_, std::string())) {}

JobFolder::~JobFolder() {
  if (!path_.empty()) context_->scratch.Remove(path_);
}

std::string JobFolder::File(std::string_view name) const { return path_ + "/" + std::string(name); }

Status JobFolder::PutText(std::string_view name, const std::string& text) {
  return WriteFileAtomically(context_->storage, File(name), text);
}

Status JobFolder::PutArtefact(std::string_view name, const std::string& artefact_id) {
  const auto bytes = context_->store.ReadArtefact(artefact_id);
  if (!bytes) return Fail(bytes);
  return WriteFileAtomically(context_->storage, File(name), std::span<const std::byte>(*bytes));
}

Status JobFolder::PutRecording(std::string_view name, const std::string& scan_id) {
  const auto bytes = context_->store.ReadRecording(scan_id);
  if (!bytes) return Fail(bytes);
  return WriteFileAtomically(context_->storage, File(name), std::span<const std::byte>(*bytes));
}

Status JobFolder::PutModel(std::string_view name, const std::string& scan_id) {
  const auto model = NewestArtefact(context_->store, scan_id, "model");
  if (!model) return Fail(model);
  return PutArtefact(name, model->id);
}

std::string JobFolder::Start(JobRequest request) {
  request.folder = std::exchange(path_, std::string());
  return context_->jobs.Start(std::move(request));
}

Result<Artefact> KeepResult(ConsoleContext& context, const std::string& scan_id, const std::string& file,
                            Artefact what) {
  const auto scan = context.store.GetScan(scan_id);
  if (!scan) return Fail(scan);
  const auto bytes = context.storage.ReadAll(file, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  what.scan_id = scan_id;
  what.customer_id = scan->customer_id;
  return context.store.PutArtefact(std::move(what), std::span<const std::byte>(*bytes));
}

ApiResult JobAnswer(const JobRunner& jobs, const std::string& id) {
  const auto job = jobs.Get(id);
  if (job) return JsonAnswer(JobJson(*job));
  return Refuse(500, {"start a job", "the runner does not know it", "try again"});
}

tl::expected<JobStatus, ApiError> OwnJob(const ConsoleContext& context, const Caller& caller, const std::string& id,
                                         std::string_view kind) {
  auto job = context.jobs.Get(id);
  if (job && job->owner == JobOwner(caller) && (kind.empty() || job->kind == kind)) return std::move(*job);
  return Refuse(404, {"look at job " + id, "there is no such job of yours", "look at the list of jobs"});
}

tl::expected<JobFolder, ApiError> FolderWithModel(ConsoleContext& context, const std::string& scan_id) {
  if (const auto scan = context.store.GetScan(scan_id); !scan) return Refuse(404, scan);
  auto folder = JobFolder::Make(context);
  if (!folder) return Refuse(503, folder.error());
  if (const auto model = NewestArtefact(context.store, scan_id, "model"); !model) return Refuse(409, model);
  if (const Status put = folder->PutModel("model.json", scan_id); !put) return Refuse(503, put.error());
  return std::move(*folder);
}

}  // namespace annulus
