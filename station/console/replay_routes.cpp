#include <charconv>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "modeling/exchange/base64.h"
#include "sim/fault_plan.h"
#include "station/console/console_context.h"
#include "station/console/job_folder.h"
#include "station/console/replay_session.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kDiffers = 1;  ///< Exit code of `annulus replay`.
constexpr int kMostLevels = 1'000'000;
constexpr int kMostKnots = 400;

/// The developer's routes. Borrows the context. Thread-safe.
class ReplayRoutes {
 public:
  explicit ReplayRoutes(ConsoleContext& context) : context_(context), sessions_(context.clock) {}

  ApiResult Open(const ApiRequest& request);
  ApiResult Map(const ApiRequest& request);
  ApiResult Level(const ApiRequest& request);
  ApiResult Run(const ApiRequest& request);
  ApiResult Fit(const ApiRequest& request);
  ApiResult Compare(const ApiRequest& request);
  ApiResult Close(const ApiRequest& request);

 private:
  using Session = std::shared_ptr<ReplaySession>;
  tl::expected<Session, ApiError> SessionIn(const ApiRequest& request) {
    const std::string& id = request.path.at("replay");
    if (auto session = sessions_.Find(request.caller.user, id)) return session;
    return Refuse(404, {"look at replay " + id, "it is not open", "open the recording again"});
  }
  /// A folder with the session's recording in it, as "scan.mcap".
  tl::expected<JobFolder, ApiError> FolderWith(const ReplaySession& session) {
    auto folder = JobFolder::Make(context_);
    if (!folder) return Refuse(503, folder);
    const Status put = WriteFileAtomically(context_.storage, folder->File("scan.mcap"), session.bytes());
    if (!put) return Refuse(503, put);
    return std::move(*folder);
  }
  static JobRequest NewJob(const ApiRequest& request, std::string kind) {
    JobRequest job;
    job.kind = std::move(kind);
    job.owner = JobOwner(request.caller);
    job.subject = request.path.at("replay");
    return job;
  }

  ConsoleContext& context_;
  ReplaySessions sessions_;
};

ApiResult ReplayRoutes::Open(const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"scan"}); !known) return tl::unexpected(known.error());
  const auto scan = TextField(request.body, "scan", 64);
  if (!scan) return tl::unexpected(scan.error());
  if (const auto row = context_.store.GetScan(*scan); !row) return Refuse(404, row);
  auto bytes = context_.store.ReadRecording(*scan);
  if (!bytes) return Refuse(409, bytes);
  auto session = ReplaySession::Open(std::move(*bytes), *scan);
  if (!session) return Refuse(409, session);
  Json answer{{"replay_id", sessions_.Add(request.caller.user, *session)}, {"scan", *scan}};
  answer.update((*session)->Summary());
  return JsonAnswer(answer);
}

ApiResult ReplayRoutes::Map(const ApiRequest& request) {
  const auto session = SessionIn(request);
  if (!session) return tl::unexpected(session.error());
  return HttpResponse{200, "application/octet-stream", {}, (*session)->MapBytes()};
}

ApiResult ReplayRoutes::Level(const ApiRequest& request) {
  const auto session = SessionIn(request);
  if (!session) return tl::unexpected(session.error());
  const std::string& text = request.path.at("n");
  std::size_t n = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), n);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size()) {
    return BadField("n", "it is no whole number", "count levels from 0");
  }
  const auto level = (*session)->Level(n);
  if (!level) return Refuse(404, level);
  return JsonAnswer(*level);
}

ApiResult ReplayRoutes::Run(const ApiRequest& request) {
  const auto& body = request.body;
  if (const auto known = OnlyKeys(body, {"faults", "from", "to"}); !known) return tl::unexpected(known.error());
  const auto session = SessionIn(request);
  if (!session) return tl::unexpected(session.error());
  const auto from = WholeNumberOr(body, "from", 0, 0, kMostLevels);
  if (!from) return tl::unexpected(from.error());
  const auto to = WholeNumberOr(body, "to", kMostLevels, 0, kMostLevels);
  if (!to) return tl::unexpected(to.error());
  if (*to < *from) return BadField("to", "it is before from", "give the smaller number as from");
  std::string plan;
  if (body.contains("faults") && !body.at("faults").is_null()) {
    plan = body.at("faults").dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    if (const auto parsed = sim::ParseFaultPlan(plan, "faults"); !parsed) return BadField("faults", parsed.error());
  }
  auto folder = FolderWith(**session);
  if (!folder) return tl::unexpected(folder.error());
  std::vector<std::string> arguments{"replay", folder->File("scan.mcap"), "--from", std::to_string(*from),
                                     "--to",   std::to_string(*to),       "--json", "-"};
  if (!plan.empty()) {
    if (const Status put = folder->PutText("faults.json", plan); !put) return Refuse(503, put);
    arguments.insert(arguments.end(), {"--faults", folder->File("faults.json")});
  }
  JobRequest job = NewJob(request, "replay");
  job.steps = {{"replay the recording", arguments, kDiffers}};
  // Shared by the two callbacks, which the runner may copy.
  const auto outcome = std::make_shared<Json>();
  job.after_step = [outcome](std::size_t, const std::string& printed) -> Status {
    *outcome = Json::parse(printed, nullptr, false);
    if (!outcome->is_object()) return Fail("replay the recording", "what came of it is no JSON", "try again");
    outcome->erase("recording");  // a file of the job's, gone by now
    return {};
  };
  job.finish = [outcome]() -> Result<Json> { return *outcome; };
  return JobAnswer(context_.jobs, folder->Start(std::move(job)));
}

/// `options` of a fit as arguments of `annulus fit`.
tl::expected<std::vector<std::string>, ApiError> FitArguments(const nlohmann::json& body) {
  const nlohmann::json options = body.contains("options") ? body.at("options") : nlohmann::json::object();
  if (!options.is_object()) return BadField("options", "it is no object", "give {method, theta_knots, z_knots}");
  if (const auto known = OnlyKeys(options, {"method", "theta_knots", "z_knots"}); !known) {
    return tl::unexpected(known.error());
  }
  const auto method = WordOr(options, "method", "adaptive", {"adaptive", "uniform", "paper"});
  if (!method) return tl::unexpected(method.error());
  std::vector<std::string> arguments{"--method", *method};
  for (const auto& [key, option] : {std::pair{"theta_knots", "--theta-knots"}, std::pair{"z_knots", "--z-knots"}}) {
    const auto knots = WholeNumberOr(options, key, 0, 0, kMostKnots);
    if (!knots) return tl::unexpected(knots.error());
    if (*knots == 0) continue;
    if (*method != "uniform") return BadField(key, "the method " + *method + " finds its own", "leave it out");
    arguments.insert(arguments.end(), {option, std::to_string(*knots)});
  }
  return arguments;
}

ApiResult ReplayRoutes::Fit(const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"options"}); !known) return tl::unexpected(known.error());
  const auto session = SessionIn(request);
  if (!session) return tl::unexpected(session.error());
  const auto options = FitArguments(request.body);
  if (!options) return tl::unexpected(options.error());
  auto folder = FolderWith(**session);
  if (!folder) return tl::unexpected(folder.error());
  const std::string model = folder->File("model.json");
  const std::string picture = folder->File("residuals.png");
  std::vector<std::string> arguments{
      "fit", folder->File("scan.mcap"), "--out", model, "--report", "-", "--report-image", picture, "--no-covariance"};
  arguments.insert(arguments.end(), options->begin(), options->end());
  JobRequest job = NewJob(request, "replay_fit");
  job.steps = {{"fit the surface", arguments}};
  const auto report = std::make_shared<Json>();
  job.after_step = [report](std::size_t, const std::string& printed) -> Status {
    *report = Json::parse(printed, nullptr, false);
    return report->is_object() ? Status{} : Fail("read the fit's report", "it is no JSON", "try again");
  };
  job.finish = [this, report, model, picture, replay = *session]() -> Result<Json> {
    auto text = ReadTextFile(context_.storage, model);
    if (!text) return Fail(text);
    const auto bytes = context_.storage.ReadAll(picture, kMaxInputBytes);
    if (!bytes) return Fail(bytes);
    Json result{{"model_id", replay->AddModel(std::move(*text))}};
    result.update(*report);
    result["residuals_png"] = EncodeBase64(std::span<const std::byte>(*bytes));
    return result;
  };
  return JobAnswer(context_.jobs, folder->Start(std::move(job)));
}

ApiResult ReplayRoutes::Compare(const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"a", "b"}); !known) return tl::unexpected(known.error());
  const auto session = SessionIn(request);
  if (!session) return tl::unexpected(session.error());
  const auto a = TextField(request.body, "a", 16);
  if (!a) return tl::unexpected(a.error());
  const auto b = TextField(request.body, "b", 16);
  if (!b) return tl::unexpected(b.error());
  const auto compared = (*session)->CompareModels(*a, *b);
  if (!compared) return Refuse(404, compared);
  return JsonAnswer(*compared);
}

ApiResult ReplayRoutes::Close(const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  sessions_.Close(request.caller.user, request.path.at("replay"));
  return JsonAnswer(Json::object());
}

}  // namespace

void AddReplayRoutes(RouteTable& table, ConsoleContext& context) {
  // Shared: the handlers live as long as the table, which outlives this call.
  const auto routes = std::make_shared<ReplayRoutes>(context);
  const auto add = [&table, routes](const char* method, const char* pattern, const char* audit, const char* subject,
                                    ApiResult (ReplayRoutes::*handle)(const ApiRequest&)) {
    table.Add({method, pattern, kTechnicians, false, audit, subject,
               [routes, handle](const ApiRequest& request) { return (*routes.*handle)(request); }});
  };
  add("POST", "/api/replay/open", "replay_open", "scan", &ReplayRoutes::Open);
  add("GET", "/api/replay/{replay}/map", "", "", &ReplayRoutes::Map);
  add("GET", "/api/replay/{replay}/level/{n}", "", "", &ReplayRoutes::Level);
  add("POST", "/api/replay/{replay}/run", "replay_run", "replay", &ReplayRoutes::Run);
  add("POST", "/api/replay/{replay}/fit", "replay_fit", "replay", &ReplayRoutes::Fit);
  add("POST", "/api/replay/{replay}/compare", "", "", &ReplayRoutes::Compare);
  add("POST", "/api/replay/{replay}/close", "", "", &ReplayRoutes::Close);
}

}  // namespace annulus
