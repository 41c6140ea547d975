#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "station/console/booth_live.h"
#include "station/console/console_context.h"
#include "station/console/job_runner.h"
#include "station/console/live_hub.h"
#include "station/console/model_cache.h"
#include "station/console/scratch_folder.h"
#include "tests/console_booth/memory_store.h"
#include "tests/station/served_booth.h"

namespace annulus::test {

/// Keeps what would have gone to the browsers, with when it came.
class RecordingHub final : public LiveHub {
 public:
  struct Sent {
    nlohmann::ordered_json message;
    RouteRoles roles;
    std::string user;  ///< Of SendTo.
    std::chrono::nanoseconds time{0};
  };
  void Join(const std::shared_ptr<WebSocketPeer>&, const Caller&) override {}
  void Leave(const std::shared_ptr<WebSocketPeer>&) override {}
  void Send(const nlohmann::ordered_json& message, RouteRoles roles, bool) override { Keep({message, roles, "", {}}); }
  void SendTo(const std::string& user, const nlohmann::ordered_json& message) override {
    Keep({message, {}, user, {}});
  }
  void End(const std::string&) override {}

  /// Waits for a message, among all that have come; null if none comes.
  nlohmann::ordered_json WaitFor(const std::function<bool(const Sent&)>& wanted) {
    std::unique_lock lock(mutex_);
    const Sent* found = nullptr;
    const auto look = [&] {
      for (const Sent& one : sent_) {
        if (!wanted(one)) continue;
        found = &one;
        return true;
      }
      return false;
    };
    return came_.wait_for(lock, 6 * kSoon, look) ? found->message : nlohmann::ordered_json();
  }
  nlohmann::ordered_json WaitForType(const std::string& type) {
    return WaitFor([&](const Sent& one) { return one.message.at("type") == type; });
  }
  [[nodiscard]] std::vector<Sent> all() {
    const std::lock_guard lock(mutex_);
    return sent_;
  }
  void Forget() {
    const std::lock_guard lock(mutex_);
    sent_.clear();
  }

 private:
  void Keep(Sent sent) {
    sent.time = SystemClock().Now();
    const std::lock_guard lock(mutex_);
    sent_.push_back(std::move(sent));
    came_.notify_all();
  }
  std::mutex mutex_;
  std::condition_variable came_;
  std::vector<Sent> sent_;
};

/// An answer, taken apart.
struct Answer {
  int status = 0;
  nlohmann::json json;  ///< null if it is none.
  std::string body;
  std::string field;  ///< Of an error.
  std::string seen;
};

/// The routes as a caller reaches them, without the server and its rules.
class RouteCaller {
 public:
  RouteTable table;
  Caller caller{"anna", StationRole::kOperator, "session", true, "127.0.0.1"};

  Answer Call(const std::string& method, const std::string& target, const nlohmann::json& body) {
    HttpRequest http;
    http.method = method;
    const std::size_t question = target.find('?');
    http.path = target.substr(0, question);
    if (question != std::string::npos) {
      std::string query = target.substr(question + 1) + "&";
      for (std::size_t end = query.find('&'); end != std::string::npos; end = query.find('&')) {
        const std::string pair = query.substr(0, end);
        const std::size_t equals = pair.find('=');
        http.query.emplace_back(pair.substr(0, equals), pair.substr(equals + 1));
        query.erase(0, end + 1);
      }
    }
    if (body.is_string()) http.body = body.get<std::string>();
    const RouteTable::Match match = table.Find(method, http.path);
    if (match.route == nullptr) return {404, nullptr, "", "", "no such route"};
    if (!match.route->roles.Allows(caller.role)) return {403, nullptr, "", "", "not for this role"};
    const nlohmann::json object = body.is_object() ? body : nlohmann::json::object();
    const ApiResult result = match.route->handle(ApiRequest{http, caller, match.parameters, object});
    if (!result) return {result.error().status, nullptr, "", result.error().field, result.error().error.seen};
    return {result->status, nlohmann::json::parse(result->body, nullptr, false), result->body, "", ""};
  }
  Answer Get(const std::string& target) { return Call("GET", target, nullptr); }
  Answer Post(const std::string& target, const nlohmann::json& body = nlohmann::json::object()) {
    return Call("POST", target, body);
  }
};

/// The console's parts around a booth's socket, with a store in memory.
class ConsoleParts {
 public:
  ConsoleParts(const std::string& socket, const std::string& program, Store* store = nullptr)
      : memory_(storage), store_(store != nullptr ? *store : memory_), live_(hub, clock) {
    scratch_ = std::move(*ScratchFolder::Make(folder_ / ""));
    jobs_ = JobRunner::Make(program, [this](const JobStatus& job) { JobChanged(job); });
    models_ = ModelCache::Make([this](const std::string& scan) { return OpenStoredModel(store_, scan); });
    link_ = BoothLink::Make(socket, live_.events());
    live_.Attach(*link_);
    context_.emplace(ConsoleContext{config, "sim", store_, *link_, hub, *jobs_, *models_, *scratch_, storage, clock});
  }
  ~ConsoleParts() {
    link_.reset();
    jobs_.reset();
  }

  PosixStorage storage;
  SystemClock clock;
  Config config = SimulatedConfig();
  RecordingHub hub;

  ConsoleContext& context() { return *context_; }
  BoothLink& link() { return *link_; }
  BoothLive& live() { return live_; }
  MemoryStore& memory() { return memory_; }
  Store& store() { return store_; }
  JobRunner& jobs() { return *jobs_; }
  ModelCache& models() { return *models_; }

  /// A customer with a consent to what is given: ids of both.
  std::pair<std::string, std::string> Somebody(std::vector<std::string> purposes = {"measure"}) {
    const Customer customer = *store_.AddCustomer({"", "Hanako", "", "", 1620, {}, {}, {}});
    const Consent consent = *store_.AddConsent({"", customer.id, std::move(purposes), "2026-11", "en", "anna", {}, {}});
    return {customer.id, consent.id};
  }
  /// The state of a job once it has ended.
  JobStatus WaitForJob(const std::string& id) {
    std::unique_lock lock(jobs_mutex_);
    JobStatus job;
    job_changed_.wait_for(lock, 12 * kSoon, [&] {
      const auto now = jobs_->Get(id);
      if (!now) return false;  // not started yet
      job = *now;
      return job.state != JobState::kWaiting && job.state != JobState::kRunning;
    });
    return job;
  }

 private:
  void JobChanged(const JobStatus&) {
    const std::lock_guard lock(jobs_mutex_);
    job_changed_.notify_all();
  }

  FreshFolder folder_;
  MemoryStore memory_;
  Store& store_;
  BoothLive live_;
  std::mutex jobs_mutex_;
  std::condition_variable job_changed_;
  std::unique_ptr<ScratchFolder> scratch_;
  std::unique_ptr<JobRunner> jobs_;
  std::unique_ptr<ModelCache> models_;
  std::unique_ptr<BoothLink> link_;
  std::optional<ConsoleContext> context_;
};

}  // namespace annulus::test
