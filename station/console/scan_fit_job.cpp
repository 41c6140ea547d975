#include "station/console/scan_fit_job.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "modeling/exchange/landmarks_json.h"
#include "modeling/table/table.h"
#include "station/console/job_runner.h"
#include "station/console/model_cache.h"
#include "station/console/scan_json.h"
#include "station/console/scan_measurements.h"
#include "station/console/scratch_folder.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

std::span<const std::byte> AsBytes(const std::string& text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

Artefact ArtefactOf(const ScanRow& scan, const char* kind, const char* name, std::string recipe) {
  Artefact artefact;
  artefact.scan_id = scan.id;
  artefact.customer_id = scan.customer_id;
  artefact.kind = kind;
  artefact.name = name;
  artefact.recipe = std::move(recipe);
  return artefact;
}

/// What the process has made goes into the store, and what follows from it.
Result<Json> KeepFit(ConsoleContext& context, const std::string& scan_id, const std::string& folder,
                     const std::string& recipe) {
  const auto scan = context.store.GetScan(scan_id);
  if (!scan) return Fail(scan);
  const auto model = context.storage.ReadAll(folder + "/model.json", kMaxInputBytes);
  if (!model) return Fail(model);
  const auto report = context.storage.ReadAll(folder + "/report.json", kMaxInputBytes);
  if (!report) return Fail(report);
  const auto kept = context.store.PutArtefact(ArtefactOf(*scan, "model", "model.json", recipe), *model);
  if (!kept) return Fail(kept);
  const auto reported = context.store.PutArtefact(ArtefactOf(*scan, "document", "fit-report.json", recipe), *report);
  if (!reported) return Fail(reported);
  context.models.Drop(scan_id);
  RETURN_IF_ERROR(KeepMeasurements(context, scan_id));
  return Json{{"scan_id", scan_id}, {"model", ArtefactJson(*kept)}};
}

}  // namespace

Status KeepMeasurements(ConsoleContext& context, const std::string& scan_id) {
  const auto open = context.models.Open(scan_id);
  return open ? KeepMeasurements(context, **open) : Status(Fail(open));
}

Status KeepMeasurements(ConsoleContext& context, const OpenModel& model) {
  const auto scan = context.store.GetScan(model.scan_id);
  if (!scan) return Fail(scan);
  Artefact landmarks = ArtefactOf(*scan, "landmarks", "landmarks.json", "landmarks");
  landmarks.derived = std::none_of(model.landmarks.found.begin(), model.landmarks.found.end(),
                                   [](const Landmark& one) { return one.source == LandmarkSource::kGiven; });
  const auto put = context.store.PutArtefact(landmarks, AsBytes(LandmarksToJson(model.loaded.body, model.landmarks)));
  if (!put) return Fail(put);
  const auto table = MeasureTable(model.loaded.body, model.landmarks);
  // A part of a body on which there is nothing to measure is still a model.
  if (!table) return model.landmarks.found.empty() ? Status{} : Status(Fail(table));
  const auto measured = context.store.PutArtefact(ArtefactOf(*scan, "measurements", "measurements.json", "measure"),
                                                  AsBytes(KeptMeasurements(*table).dump()));
  return measured ? Status{} : Status(Fail(measured));
}

Result<std::string> StartFitJob(ConsoleContext& context, const std::string& scan_id, const std::string& owner,
                                const FitJobOptions& options) {
  const auto recording = context.store.ReadRecording(scan_id);
  if (!recording) return Fail(recording);
  const auto folder = context.scratch.NewFolder();
  if (!folder) return Fail(folder);
  if (const Status written = WriteFileAtomically(context.storage, *folder + "/scan.mcap", *recording); !written) {
    context.scratch.Remove(*folder);
    return Fail(written);
  }
  JobRequest request;
  request.kind = "fit";
  request.owner = owner;
  request.subject = scan_id;
  request.folder = *folder;
  const std::string recipe = "fit --method " + options.method + (options.covariance ? "" : " --no-covariance");
  JobStep step{"fit", {"fit", "scan.mcap", "--out", "model.json", "--report", "report.json", "--method"}};
  step.arguments.push_back(options.method);
  if (!options.covariance) step.arguments.emplace_back("--no-covariance");
  request.steps.push_back(std::move(step));
  request.finish = [&context, scan_id, folder = *folder, recipe] { return KeepFit(context, scan_id, folder, recipe); };
  return context.jobs.Start(std::move(request));
}

}  // namespace annulus
