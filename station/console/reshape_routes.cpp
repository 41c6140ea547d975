#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "base/sha256.h"
#include "station/console/clay_preview.h"
#include "station/console/console_context.h"
#include "station/console/job_folder.h"
#include "station/console/mesh_bytes.h"
#include "station/console/model_cache.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"
#include "station/console/scan_json.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostGirths = 50;

/// The scan, if its customer lets the body be reshaped.
tl::expected<ScanRow, ApiError> ReshapableScan(ConsoleContext& context, const ApiRequest& request) {
  auto scan = context.store.GetScan(request.path.at("scan"));
  if (!scan) return Refuse(404, scan);
  const auto consents = context.store.Consents(scan->customer_id);
  if (!consents) return Refuse(503, consents);
  const bool allowed = std::any_of(consents->begin(), consents->end(), [](const Consent& consent) {
    return !consent.withdrawn &&
           std::find(consent.purposes.begin(), consent.purposes.end(), "reshape") != consent.purposes.end();
  });
  if (!allowed) {
    return Refuse(403, {"reshape " + scan->id, "the customer has not agreed to that",
                        "ask for the consent to reshape, then try again"});
  }
  return std::move(*scan);
}

/// `girths_mm`: heights, mm; none without it.
tl::expected<std::vector<double>, ApiError> GirthsIn(const nlohmann::json& body) {
  if (!body.contains("girths_mm")) return std::vector<double>{};
  const nlohmann::json& list = body.at("girths_mm");
  const bool good = list.is_array() && list.size() <= kMostGirths &&
                    std::all_of(list.begin(), list.end(), [](const auto& one) { return one.is_number(); });
  if (!good) return BadField("girths_mm", "it is no list of at most 50 numbers", "give heights in mm");
  return list.get<std::vector<double>>();
}

/// `script`: an object, as the file of the command.
tl::expected<std::string, ApiError> ScriptIn(const nlohmann::json& body) {
  if (!body.contains("script") || !body.at("script").is_object()) {
    return BadField("script", "it is missing, or no object", "give the operations, docs/formats.md");
  }
  return body.at("script").dump();
}

ApiResult Preview(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"script", "girths_mm"}); !known) return tl::unexpected(known.error());
  if (const auto scan = ReshapableScan(context, request); !scan) return tl::unexpected(scan.error());
  const auto text = ScriptIn(request.body);
  if (!text) return tl::unexpected(text.error());
  const auto girths = GirthsIn(request.body);
  if (!girths) return tl::unexpected(girths.error());
  const auto script = ClayScriptFromJson(*text, "script");
  if (!script) return Refuse(400, script);
  const auto model = context.models.Open(request.path.at("scan"));
  if (!model) return Refuse(404, model);
  const auto body = (*model)->clay->Get((*model)->loaded.model->main());
  if (!body) return Refuse(409, body);
  auto preview = PreviewClay(**body, *script, *girths);
  if (!preview) return Refuse(409, preview);
  // Only ASCII may stand in a header.
  const std::string notes = preview->notes.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
  return HttpResponse{200, kMeshType, {{"X-Annulus-Notes", notes}}, std::move(preview->mesh)};
}

/// What the command line of a tool takes; its result is reshaped.json, its report on stdout.
std::vector<std::string> ArgumentsOf(const std::string& tool, const JobFolder& folder,
                                     const std::vector<double>& girths) {
  const std::string model = folder.File("model.json");
  const std::string script = folder.File("script.json");
  const std::string out = folder.File("reshaped.json");
  if (tool == "elastic") return {"elastic", model, "--ops", script, "--out", out, "--json", "-"};
  std::vector<std::string> arguments{"clay", "--in", model, "--ops", script, "--out-model", out, "--json", "-"};
  for (const double z : girths) arguments.push_back(fmt::format("--girth={}", z));
  return arguments;
}

ApiResult Reshape(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"tool", "script", "girths_mm"}); !known) {
    return tl::unexpected(known.error());
  }
  const auto scan = ReshapableScan(context, request);
  if (!scan) return tl::unexpected(scan.error());
  const auto tool = WordOr(request.body, "tool", "clay", {"clay", "elastic"});
  if (!tool) return tl::unexpected(tool.error());
  const auto script = ScriptIn(request.body);
  if (!script) return tl::unexpected(script.error());
  const auto girths = GirthsIn(request.body);
  if (!girths) return tl::unexpected(girths.error());
  auto folder = FolderWithModel(context, scan->id);
  if (!folder) return tl::unexpected(folder.error());
  if (const Status put = folder->PutText("script.json", *script); !put) return Refuse(503, put.error());
  JobRequest job;
  job.kind = "reshape";
  job.owner = JobOwner(request.caller);
  job.subject = scan->id;
  job.steps = {{"reshape the body", ArgumentsOf(*tool, *folder, *girths)}};
  const auto report = std::make_shared<Json>();
  job.after_step = [report](std::size_t, const std::string& printed) -> Status {
    *report = Json::parse(printed, nullptr, false);
    return report->is_object() ? Status{} : Fail("read the report", "it is no JSON", "try again");
  };
  const std::string asked = *tool + *script;
  const std::string tag = Sha256Hex(std::as_bytes(std::span(asked))).substr(0, 12);
  job.finish = [&context, report, file = folder->File("reshaped.json"), tag, id = scan->id]() -> Result<Json> {
    Artefact what;
    what.kind = "reshaped";
    what.name = "reshaped-" + tag + ".json";
    what.derived = false;  // it rests on what a person chose
    const auto kept = KeepResult(context, id, file, std::move(what));
    if (!kept) return Fail(kept);
    return Json{{"model", ArtefactJson(*kept)}, {"report", *report}};
  };
  return JobAnswer(context.jobs, folder->Start(std::move(job)));
}

}  // namespace

void AddReshapeRoutes(RouteTable& table, ConsoleContext& context) {
  // Reads only, while a tool is dragged: not in the audit.
  table.Add({"POST", "/api/scans/{scan}/clay/preview", kOperators, false, "", "",
             [&context](const ApiRequest& request) { return Preview(context, request); }});
  table.Add({"POST", "/api/scans/{scan}/reshape", kOperators, false, "reshape", "scan",
             [&context](const ApiRequest& request) { return Reshape(context, request); }});
}

}  // namespace annulus
