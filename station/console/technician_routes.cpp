#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/console/booth_link.h"
#include "station/console/console_context.h"
#include "station/console/job_folder.h"
#include "station/console/recording_routes.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"
#include "station/console/technician_drift.h"
#include "station/console/technician_interlock.h"
#include "station/console/technician_parameters.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLongestConfig = std::size_t{256} << 10;

ApiResult Doctor(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  JobRequest job;
  job.kind = "doctor";
  job.owner = JobOwner(request.caller);
  job.subject = context.config.station_id;
  // 1: a problem was found, which is an answer too.
  job.steps = {{"look at host, buses and devices", {"doctor", "--config", context.config_path, "--json", "-"}, 1}};
  // Shared by the two callbacks, which the runner may copy.
  const auto report = std::make_shared<Json>();
  job.after_step = [report](std::size_t, const std::string& printed) -> Status {
    *report = Json::parse(printed, nullptr, false);
    return report->is_object() ? Status{} : Fail("read the doctor's report", "it is no JSON", "try again");
  };
  job.finish = [report]() -> Result<Json> { return *report; };
  return JobAnswer(context.jobs, context.jobs.Start(std::move(job)));
}

ApiResult Answer(const Result<Json>& json) {
  if (!json) return Refuse(503, json);
  return JsonAnswer(*json);
}

ApiResult UpdateDrift(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  const auto job = StartDriftUpdate(context, JobOwner(request.caller));
  if (!job) return Refuse(503, job);
  if (!*job) return Refuse(409, {"look for drift", "all scans were looked at already", "scan somebody first"});
  return JobAnswer(context.jobs, **job);
}

ApiResult Parameters(ConsoleContext& context) {
  std::string text;
  if (context.config_path != "sim") {
    auto read = ReadTextFile(context.storage, context.config_path);
    if (!read) return Refuse(503, read);
    text = std::move(*read);
  }
  return JsonAnswer(ParametersJson(context.config, context.config_path, text));
}

ApiResult CheckParameters(const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"text"}); !known) return tl::unexpected(known.error());
  const auto text = TextField(request.body, "text", kLongestConfig);
  if (!text) return tl::unexpected(text.error());
  return JsonAnswer(CheckedParameters(*text));
}

ApiResult InterlockLines(const ConsoleContext& context) {
  const auto status = context.booth.status();
  if (!status) {
    const std::string why = context.booth.why();
    return Refuse(503, {"look at the interlock", why.empty() ? "the booth is away" : why, "start boothd"});
  }
  return JsonAnswer(InterlockJson(status->scanner));
}

}  // namespace

void AddTechnicianRoutes(RouteTable& table, ConsoleContext& context) {
  const auto add = [&table](const char* method, const char* pattern, const char* audit,
                            std::function<ApiResult(const ApiRequest&)> handle) {
    table.Add({method, pattern, kTechnicians, false, audit, "", std::move(handle)});
  };
  add("POST", "/api/technician/doctor", "doctor",
      [&context](const ApiRequest& request) { return Doctor(context, request); });
  add("GET", "/api/technician/sensors", "", [&context](const ApiRequest&) { return Answer(SensorsAnswer(context)); });
  add("GET", "/api/technician/drift", "", [&context](const ApiRequest&) { return Answer(DriftAnswer(context)); });
  add("POST", "/api/technician/drift/update", "drift_update",
      [&context](const ApiRequest& request) { return UpdateDrift(context, request); });
  add("GET", "/api/technician/parameters", "", [&context](const ApiRequest&) { return Parameters(context); });
  add("POST", "/api/technician/parameters/check", "", CheckParameters);
  add("GET", "/api/technician/interlock", "", [&context](const ApiRequest&) { return InterlockLines(context); });
  AddRecordingRoutes(table, context);
}

}  // namespace annulus
