#include "station/console/scan_import.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "acquisition/sealed_file.h"
#include "base/log.h"
#include "station/console/job_folder.h"
#include "station/console/route_errors.h"
#include "station/console/scan_fit_job.h"
#include "station/console/scan_json.h"
#include "station/console/scan_judgement.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

struct ImportTarget {
  std::string customer_id;
  std::string consent_id;
  std::string user;
};

/// A recording, opened, into the store; the job's result.
Result<Json> TakeIn(ConsoleContext& context, const ImportTarget& target, const std::string& file) {
  const auto bytes = context.storage.ReadAll(file, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  const auto judged = JudgeRecording(*bytes, "the imported scan", nullptr, "");
  if (!judged) return Fail(judged);
  ScanRow row;
  row.customer_id = target.customer_id;
  row.consent_id = target.consent_id;
  row.profile = judged->header.profile;
  row.verdict = judged->verdict;
  row.summary_json = judged->summary_json;
  // A table says nothing of its time; it counts from when it came.
  const std::int64_t start_ns = judged->header.wall_start_ns;
  row.taken = std::chrono::duration_cast<StoreTime>(start_ns > 0 ? std::chrono::nanoseconds(start_ns)
                                                                 : context.clock.WallNow());
  const auto added = context.store.AddScan(std::move(row), file, nullptr);
  if (!added) return Fail(added);
  if (!judged->parked) {
    const auto fit = StartFitJob(context, added->id, target.user);
    if (!fit) Log(LogLevel::kError, "fit of " + added->id + ": " + fit.error().Text());
  }
  return Json{{"scan", ScanToJson(context.store, *added, StationRole::kOperator)}};
}

tl::expected<ImportTarget, ApiError> ReadTarget(ConsoleContext& context, const ApiRequest& request) {
  ImportTarget target{std::string(request.http.Query("customer_id").value_or("")),
                      std::string(request.http.Query("consent_id").value_or("")), request.caller.user};
  const auto customer = context.store.GetCustomer(target.customer_id);
  if (!customer) return BadField("customer_id", customer.error().seen, "choose a customer");
  const auto consents = context.store.Consents(target.customer_id);
  if (!consents) return StoreAway(consents.error());
  const bool good = std::any_of(consents->begin(), consents->end(),
                                [&](const Consent& one) { return one.id == target.consent_id && !one.withdrawn; });
  if (!good) return BadField("consent_id", "it is not this customer's, or was withdrawn", "ask for a consent");
  return target;
}

/// No seal is opened for a page: a recording of this station comes by its folder, with whom it was taken for.
tl::unexpected<ApiError> RefuseSealed(std::span<const std::byte> bytes) {
  const auto key = SealedKeyId(bytes, "the recording");
  return BadField("body", key ? "the recording is sealed with the key '" + *key + "'" : key.error().seen,
                  "open it where its key is: annulus export SCAN --key-file F --out OPEN.mcap");
}

}  // namespace

ApiResult ImportScan(ConsoleContext& context, const ApiRequest& request) {
  const std::string& body = request.http.body;
  if (body.empty()) return BadField("body", "it is empty", "send a recording or a range table");
  const auto bytes = std::as_bytes(std::span(body));
  if (LooksSealed(bytes)) return RefuseSealed(bytes);
  auto target = ReadTarget(context, request);
  if (!target) return tl::unexpected(std::move(target.error()));
  auto folder = JobFolder::Make(context);
  if (!folder) return StoreAway(folder.error());
  const bool recording = LooksLikeRecording(bytes);
  const bool gzip = body.size() > 2 && body[0] == '\x1f' && body[1] == '\x8b';
  const std::string table = gzip ? "points.csv.gz" : "points.csv";
  if (const Status put = folder->PutText(recording ? "scan.mcap" : table, body); !put) return StoreAway(put.error());
  JobRequest job;
  job.kind = "import";
  job.owner = JobOwner(request.caller);
  job.subject = target->customer_id;
  // A recording of somebody else's is looked at in a process of its own before the console opens it.
  job.steps.push_back(recording ? JobStep{"look at the recording", {"inspect", "scan.mcap", "--json", "-"}}
                                : JobStep{"read the table", {"import", table, "--out", "scan.mcap"}});
  job.finish = [&context, target = *target, file = folder->File("scan.mcap")] { return TakeIn(context, target, file); };
  return JobAnswer(context.jobs, folder->Start(std::move(job)));
}

}  // namespace annulus
