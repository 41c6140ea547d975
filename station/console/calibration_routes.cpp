#include <algorithm>
#include <charconv>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "station/console/calibration_records.h"
#include "station/console/calibration_run.h"
#include "station/console/console_context.h"
#include "station/console/job_folder.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"
#include "station/target_text.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLongestTargets = 500;
constexpr std::string_view kBetweenTargets = " + ";
constexpr std::string_view kVerifies = "verify:";

/// What a form can begin with: usual sets of targets, whose numbers are to be those of their certificates.
Json UsualTargets() {
  return {{{"spec",
            "cylinder:radius_mm=150,u_mm=0.02 + cylinder:radius_mm=70,u_mm=0.02 + "
            "verify:cylinder:radius_mm=110,u_mm=0.02"},
           {"name", "cylinders of 150 and 70 mm radius, and one of 110 mm to verify with"}},
          {{"spec", "cylinder:radius_mm=150,u_mm=0.02 + cylinder:radius_mm=70,u_mm=0.02"},
           {"name", "cylinders of 150 and 70 mm radius"}},
          {{"spec", "cylinder:radius_mm=150,u_mm=0.02"}, {"name", "one cylinder of 150 mm radius"}}};
}

ApiResult Look(ConsoleContext& context, CalibrationRun& run) {
  const auto history = CalibrationHistoryJson(context.store);
  if (!history) return Refuse(503, history);
  return JsonAnswer({{"current", CalibrationInForceJson(context)},
                     {"history", *history},
                     {"run", run.Report()},
                     {"targets", UsualTargets()}});
}

/// `board`: a serial number, as a number or as it was typed; empty: the whole ring.
tl::expected<std::optional<std::uint32_t>, ApiError> BoardIn(const nlohmann::json& body) {
  const auto found = body.find("board");
  if (found == body.end() || found->is_null() || *found == "") return std::optional<std::uint32_t>();
  const std::string text = found->is_string() ? found->get<std::string>() : found->dump();
  std::uint32_t serial = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), serial);
  if (read.ec == std::errc() && read.ptr == text.data() + text.size() && serial > 0) return std::optional(serial);
  return BadField("board", "it is no serial number", "give the serial number of the board that was replaced");
}

/// `target`: one, or several with " + " between them, as ParseTarget takes them; never a file's name. One that begins
/// with "verify:" takes no part in the solve: the result is held against it.
tl::expected<CalibrationOrder, ApiError> TargetsIn(const nlohmann::json& body) {
  const auto text = TextField(body, "target", kLongestTargets);
  if (!text) return tl::unexpected(text.error());
  CalibrationOrder order;
  std::vector<bool> verifies;
  for (std::size_t begin = 0; begin <= text->size();) {
    const std::size_t end = std::min(text->find(kBetweenTargets, begin), text->size());
    std::string one = text->substr(begin, end - begin);
    verifies.push_back(one.starts_with(kVerifies));
    if (verifies.back()) one.erase(0, kVerifies.size());
    auto target = ParseTarget(one);
    if (!target) return BadField("target", target.error());
    order.plan.targets.push_back(std::move(*target));
    order.targets.push_back(std::move(one));
    begin = end + kBetweenTargets.size();
  }
  if (verifies.front()) return BadField("target", "the first one is to verify with", "begin with one to solve with");
  order.plan.placements = UsualPlacements(order.plan.targets, verifies);
  return order;
}

ApiResult Begin(CalibrationRun& run, const ApiRequest& request) {
  const auto& body = request.body;
  if (const auto known = OnlyKeys(body, {"target", "board", "ambient_c"}); !known) {
    return tl::unexpected(known.error());
  }
  auto order = TargetsIn(body);
  if (!order) return tl::unexpected(order.error());
  const auto ambient = NumberOr(body, "ambient_c", 20.0, -10.0, 50.0);
  if (!ambient) return tl::unexpected(ambient.error());
  const auto board = BoardIn(body);
  if (!board) return tl::unexpected(board.error());
  order->plan.technician = request.caller.user;
  order->plan.ambient_c = *ambient;
  order->board = *board;
  if (const Status begun = run.Begin(std::move(*order)); !begun) return Refuse(409, begun);
  return JsonAnswer(run.Report());
}

ApiResult Take(CalibrationRun& run, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"step"}); !known) return tl::unexpected(known.error());
  if (!request.body.contains("step")) return BadField("step", "it is missing", "say which step, 0 first");
  const auto step = WholeNumberOr(request.body, "step", 0, 0, 1000);
  if (!step) return tl::unexpected(step.error());
  if (const Status taken = run.Take(static_cast<std::size_t>(*step)); !taken) return Refuse(409, taken);
  return JsonAnswer(run.Report());
}

ApiResult Solve(ConsoleContext& context, CalibrationRun& run, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  const auto job = run.Solve(JobOwner(request.caller));
  if (!job) return Refuse(409, job);
  return JobAnswer(context.jobs, *job);
}

ApiResult Abandon(CalibrationRun& run, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  run.Abandon();
  return JsonAnswer(Json::object());
}

ApiResult Accept(CalibrationRun& run, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"confirm"}); !known) return tl::unexpected(known.error());
  const auto confirmed = FlagField(request.body, "confirm");
  if (!confirmed) return tl::unexpected(confirmed.error());
  if (!*confirmed) return BadField("confirm", "it is false", "say true, or abandon the calibration");
  const auto name = run.Accept();
  if (!name) return Refuse(409, name);
  return JsonAnswer({{"name", *name}, {"in_force", true}});
}

/// The report of a stored calibration, or of the run ("run"): its PDF unless ?file= asks for another part.
ApiResult ReportOf(ConsoleContext& context, CalibrationRun& run, const ApiRequest& request) {
  const std::string& name = request.path.at("name");
  const std::string file(request.http.Query("file").value_or("report.pdf"));
  std::string type;
  if (file == "report.pdf") type = "application/pdf";
  if (file == "report.html") type = "text/html; charset=utf-8";
  if (file == "CAL.json" || file == "data.json") type = "application/json";
  if (type.empty())
    return BadField("file", "there is no such part", "ask for report.pdf, report.html, CAL.json, data.json");
  const auto bytes = name == "run" ? run.ReportFile(file) : StoredCalibrationFile(context.store, name, file);
  if (!bytes) return Refuse(404, bytes);
  HttpResponse answer{200, type, {}, {}};
  // Its own styles would be refused beside the console's pages: it is for saving.
  const std::string disposition = file == "report.html" ? "attachment" : "inline";
  answer.headers.emplace_back("Content-Disposition", disposition + "; filename=\"" + file + "\"");
  answer.body.assign(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  return answer;
}

}  // namespace

void AddCalibrationRoutes(RouteTable& table, ConsoleContext& context) {
  // Shared: the handlers live as long as the table, which outlives this call.
  const auto run = std::make_shared<CalibrationRun>(context);
  const auto add = [&table](const char* method, const char* pattern, bool local, const char* audit,
                            std::function<ApiResult(const ApiRequest&)> handle) {
    table.Add({method, pattern, kTechnicians, local, audit, "", std::move(handle)});
  };
  add("GET", "/api/calibration", false, "", [&context, run](const ApiRequest&) { return Look(context, *run); });
  add("POST", "/api/calibration/begin", true, "calibration_begin",
      [run](const ApiRequest& request) { return Begin(*run, request); });
  add("POST", "/api/calibration/take", true, "calibration_take",
      [run](const ApiRequest& request) { return Take(*run, request); });
  add("POST", "/api/calibration/solve", false, "calibration_solve",
      [&context, run](const ApiRequest& request) { return Solve(context, *run, request); });
  add("POST", "/api/calibration/abandon", false, "calibration_abandon",
      [run](const ApiRequest& request) { return Abandon(*run, request); });
  add("POST", "/api/calibration/accept", false, "calibration_accept",
      [run](const ApiRequest& request) { return Accept(*run, request); });
  add("GET", "/api/calibration/report/{name}", false, "",
      [&context, run](const ApiRequest& request) { return ReportOf(context, *run, request); });
}

}  // namespace annulus
