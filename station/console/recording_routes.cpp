#include "station/console/recording_routes.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/console/job_folder.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"
#include "station/console/scan_json.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostRecordings = 500;
constexpr int kRecoveredWithLoss = 3;  ///< Exit code of `annulus recover`.

const char* StateOf(const ScanRow& scan) {
  if (scan.recording.empty()) return "none";
  return scan.recording_missing ? "missing" : "kept";
}

Json RecordingJson(const ScanRow& scan) {
  const Json summary = Json::parse(scan.summary_json, nullptr, false);
  const auto of_summary = [&summary](const char* key) {
    return summary.is_object() ? summary.value(key, Json()) : Json();
  };
  return {{"scan_id", scan.id},
          {"profile", scan.profile},
          {"taken_ms", scan.taken.count()},
          {"bytes", of_summary("recording_bytes")},
          {"levels", of_summary("levels")},
          {"verdict", scan.verdict},
          {"state", StateOf(scan)}};
}

ApiResult List(ConsoleContext& context) {
  const auto scans = context.store.LatestScans(kMostRecordings);
  if (!scans) return Refuse(503, scans);
  Json recordings = Json::array();
  for (const ScanRow& scan : *scans) recordings.push_back(RecordingJson(scan));
  return JsonAnswer({{"recordings", std::move(recordings)}});
}

/// A folder with the recording of the request's scan in it, as "scan.mcap".
tl::expected<JobFolder, ApiError> FolderWithRecording(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  const std::string& id = request.path.at("scan");
  const auto scan = context.store.GetScan(id);
  if (!scan) return Refuse(404, scan);
  if (scan->recording.empty() || scan->recording_missing) {
    return Refuse(409, {"open the recording of " + id, "it is not there",
                        "bring it back from a backup; what was derived of it is kept"});
  }
  auto folder = JobFolder::Make(context);
  if (!folder) return Refuse(503, folder);
  if (const Status put = folder->PutRecording("scan.mcap", id); !put) return Refuse(503, put);
  return std::move(*folder);
}

JobRequest NewJob(const ApiRequest& request, std::string kind) {
  JobRequest job;
  job.kind = std::move(kind);
  job.owner = JobOwner(request.caller);
  job.subject = request.path.at("scan");
  return job;
}

ApiResult Inspect(ConsoleContext& context, const ApiRequest& request) {
  auto folder = FolderWithRecording(context, request);
  if (!folder) return tl::unexpected(folder.error());
  JobRequest job = NewJob(request, "inspect");
  job.steps = {{"look at the recording", {"inspect", folder->File("scan.mcap"), "--json", "-"}}};
  // Shared by the two callbacks, which the runner may copy.
  const auto report = std::make_shared<Json>();
  job.after_step = [report](std::size_t, const std::string& printed) -> Status {
    *report = Json::parse(printed, nullptr, false);
    if (!report->is_object()) return Fail("inspect the recording", "what was found is no JSON", "try again");
    // Who was scanned is no business of the technician's.
    for (const char* key : {"file", "subject_id", "consent_reference", "consent", "subject"}) report->erase(key);
    return {};
  };
  job.finish = [report]() -> Result<Json> { return *report; };
  return JobAnswer(context.jobs, folder->Start(std::move(job)));
}

ApiResult Recover(ConsoleContext& context, const ApiRequest& request) {
  auto folder = FolderWithRecording(context, request);
  if (!folder) return tl::unexpected(folder.error());
  JobRequest job = NewJob(request, "recover");
  job.steps = {{"save what is sound",
                {"recover", folder->File("scan.mcap"), "--out", folder->File("recovered.mcap"), "--json", "-"},
                kRecoveredWithLoss}};
  const auto report = std::make_shared<Json>();
  job.after_step = [report](std::size_t, const std::string& printed) -> Status {
    *report = Json::parse(printed, nullptr, false);
    return report->is_object() ? Status{} : Fail("recover the recording", "what was found is no JSON", "try again");
  };
  job.finish = [&context, report, file = folder->File("recovered.mcap"),
                scan = request.path.at("scan")]() -> Result<Json> {
    Artefact what;
    what.kind = "recovered";
    what.name = "recovered.mcap";
    what.recipe = "recover";
    const auto kept = KeepResult(context, scan, file, std::move(what));
    if (!kept) return Fail(kept);
    (*report)["recovered"] = ArtefactJson(*kept);
    return *report;
  };
  return JobAnswer(context.jobs, folder->Start(std::move(job)));
}

}  // namespace

void AddRecordingRoutes(RouteTable& table, ConsoleContext& context) {
  table.Add({"GET", "/api/technician/recordings", kTechnicians, false, "", "",
             [&context](const ApiRequest&) { return List(context); }});
  table.Add({"POST", "/api/technician/recordings/{scan}/inspect", kTechnicians, false, "recording_inspect", "scan",
             [&context](const ApiRequest& request) { return Inspect(context, request); }});
  table.Add({"POST", "/api/technician/recordings/{scan}/recover", kTechnicians, false, "recording_recover", "scan",
             [&context](const ApiRequest& request) { return Recover(context, request); }});
}

}  // namespace annulus
