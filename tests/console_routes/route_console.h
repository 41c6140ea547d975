#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/clock.h"
#include "modeling/exchange/model_json.h"
#include "modeling/landmarks/landmarks.h"
#include "station/config.h"
#include "station/console/booth_link.h"
#include "station/console/console_context.h"
#include "station/console/live_hub.h"
#include "station/console/model_cache.h"
#include "tests/console_routes/inline_jobs.h"
#include "tests/console_routes/memory_store.h"
#include "tests/support/folders.h"

namespace annulus::test {

/// Models that are put into it.
class GivenModels final : public ModelCache {
 public:
  std::map<std::string, std::shared_ptr<const OpenModel>> models;
  Result<std::shared_ptr<const OpenModel>> Open(const std::string& scan_id) override {
    const auto found = models.find(scan_id);
    if (found != models.end()) return found->second;
    return Fail("open the model of " + scan_id, "it has none", "fit it");
  }
  void Change(const OpenModel&, std::shared_ptr<const OpenModel> to) override { models[to->scan_id] = to; }
  void Drop(const std::string& scan_id) override { models.erase(scan_id); }
  void DropAll() override { models.clear(); }
};

/// A booth that says what it is told to, and takes no orders.
class StillBooth final : public BoothLink {
 public:
  std::optional<StatusMessage> said;
  Status Ask(const BoothOrder&) override { return Refused(); }
  Status AskAsTechnician(const BoothOrder&) override { return Refused(); }
  Status Cancel() override { return {}; }
  [[nodiscard]] std::optional<StatusMessage> status() const override { return said; }
  [[nodiscard]] std::optional<BoothDescription> booth() const override { return std::nullopt; }

 private:
  static Status Refused() { return Fail("ask the booth", "there is none", "start it"); }
};

/// Nobody looks on.
class NoLive final : public LiveHub {
 public:
  void Join(const std::shared_ptr<WebSocketPeer>&, const Caller&) override {}
  void Leave(const std::shared_ptr<WebSocketPeer>&) override {}
  void Send(const nlohmann::ordered_json&, RouteRoles, bool) override {}
  void SendTo(const std::string&, const nlohmann::ordered_json&) override {}
  void End(const std::string&) override {}
};

/// What a route answered.
struct RouteAnswer {
  int status = 0;
  nlohmann::json json;    ///< Of a JSON answer; the error's parts of one that was refused.
  std::string field;      ///< That was wrong.
  HttpResponse response;  ///< As it is.

  [[nodiscard]] std::string Header(const std::string& name) const {
    for (const HttpField& header : response.headers) {
      if (header.first == name) return header.second;
    }
    return "";
  }
};

/// The routes under test on stand-ins of everything around them.
class RouteConsole {
 public:
  explicit RouteConsole(Config station = SimulatedConfig())
      : config(std::move(station)),
        scratch(ScratchFolder::Make(BinaryFolder()).value()),
        jobs(*scratch),
        context{config, "sim", store, booth, live, jobs, models, *scratch, storage, clock} {
    AddGlassesRoutes(table, context);
    AddReshapeRoutes(table, context);
    AddTechnicianRoutes(table, context);
    AddCalibrationRoutes(table, context);
    AddReplayRoutes(table, context);
  }

  /// `target`: a path, with a query if need be.
  RouteAnswer Ask(const std::string& method, const std::string& target, const nlohmann::json& body = Empty()) {
    const std::size_t mark = std::min(target.find('?'), target.size());
    HttpRequest http;
    http.method = method;
    http.path = target.substr(0, mark);
    if (mark < target.size()) {
      const std::string query = target.substr(mark + 1);
      const std::size_t equals = query.find('=');
      http.query.emplace_back(query.substr(0, equals), query.substr(equals + 1));
    }
    const RouteTable::Match match = table.Find(method, http.path);
    if (match.route == nullptr) return {404, {}, "", {}};
    const Caller caller{"somebody", StationRole::kOperator, "session", true, "127.0.0.1"};
    const ApiResult result = match.route->handle({http, caller, match.parameters, body});
    RouteAnswer answer;
    if (!result) {
      const ApiError& error = result.error();
      answer.status = error.status;
      answer.field = error.field;
      answer.json = {{"attempted", error.error.attempted}, {"seen", error.error.seen}, {"advice", error.error.advice}};
      return answer;
    }
    answer.status = result->status;
    answer.response = *result;
    if (result->content_type == "application/json") answer.json = nlohmann::json::parse(result->body);
    return answer;
  }

  /// A scan of this model, in the store and in memory.
  std::string AddModel(const SurfaceModel& surface) {
    const std::string scan = store.AddRecorded("head", {});
    const std::string text = ModelToJson(surface);
    Artefact row;
    row.scan_id = scan;
    row.customer_id = "K-1";
    row.kind = "model";
    row.name = "model.json";
    const Artefact kept = store.PutArtefact(row, std::as_bytes(std::span(text))).value();
    auto owned = std::make_unique<const SurfaceModel>(ModelFromJson(text, "model.json").value());
    MeasuredSurface body = MeasuredSurface::FromModel(*owned).value();
    models.models[scan] =
        std::make_shared<OpenModel>(OpenModel{scan, kept.id, {std::move(owned), std::move(body)}, {}});
    return scan;
  }

  static nlohmann::json Empty() { return nlohmann::json::object(); }

  Config config;
  MemoryStore store;
  StillBooth booth;
  NoLive live;
  GivenModels models;
  PosixStorage storage;
  SystemClock clock;
  std::unique_ptr<ScratchFolder> scratch;
  InlineJobs jobs;
  ConsoleContext context;
  RouteTable table;
};

}  // namespace annulus::test
