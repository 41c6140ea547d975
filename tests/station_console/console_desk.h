#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/storage.h"
#include "station/config.h"
#include "station/console/accounts.h"
#include "station/console/booth_link.h"
#include "station/console/console_audit.h"
#include "station/console/console_context.h"
#include "station/console/console_frame.h"
#include "station/console/console_handler.h"
#include "station/console/job_runner.h"
#include "station/console/live_hub.h"
#include "station/console/login_guard.h"
#include "station/console/model_cache.h"
#include "station/console/passwords.h"
#include "station/console/request_gate.h"
#include "station/console/scratch_folder.h"
#include "station/console/sessions.h"
#include "tests/station_console/account_store.h"

namespace annulus::test {

/// A booth that counts what it is asked.
class CountingBooth final : public BoothLink {
 public:
  Status Ask(const BoothOrder&) override { return {}; }
  Status AskAsTechnician(const BoothOrder&) override { return {}; }
  Status Cancel() override {
    ++cancels;
    if (away) return Fail("ask the booth", "it is away", "see whether boothd runs");
    return {};
  }
  [[nodiscard]] std::optional<StatusMessage> status() const override { return std::nullopt; }
  [[nodiscard]] std::optional<BoothDescription> booth() const override { return std::nullopt; }

  int cancels = 0;
  bool away = false;
};

/// Remembers what was dropped.
class CountingModels final : public ModelCache {
 public:
  Result<std::shared_ptr<const OpenModel>> Open(const std::string&) override {
    return Fail("open a model", "there is none", "scan somebody");
  }
  void Change(const OpenModel&, std::shared_ptr<const OpenModel>) override {}
  void Drop(const std::string&) override {}
  void DropAll() override { ++dropped; }

  int dropped = 0;
};

/// Carries a job without steps out at once.
class InstantJobs final : public JobRunner {
 public:
  std::string Start(JobRequest request) override {
    result = request.finish();
    return "J-1";
  }
  [[nodiscard]] std::optional<JobStatus> Get(const std::string&) const override { return std::nullopt; }
  [[nodiscard]] std::vector<JobStatus> All() const override { return {}; }
  Status Cancel(const std::string&) override { return {}; }

  std::optional<Result<nlohmann::ordered_json>> result;
};

class NoScratch final : public ScratchFolder {
 public:
  Result<std::string> NewFolder() override { return Fail("make a folder", "there is none", "use a real one"); }
  void Remove(const std::string&) override {}
  [[nodiscard]] const std::string& path() const override { return path_; }
  [[nodiscard]] std::string problem() const override { return ""; }

 private:
  std::string path_;
};

/// A browser's end of a WebSocket: what it was sent, and how it was closed.
class ListeningPeer final : public WebSocketPeer {
 public:
  void SendText(std::shared_ptr<const std::string> text) override {
    texts.push_back(nlohmann::json::parse(*text));
    encoded.push_back(std::move(text));
  }
  void SendBinary(std::shared_ptr<const std::string>) override {}
  [[nodiscard]] std::size_t queued_bytes() const override { return queued; }
  void Close(std::uint16_t code, std::string) override { closed = code; }

  std::vector<nlohmann::json> texts;
  std::vector<std::shared_ptr<const std::string>> encoded;
  std::size_t queued = 0;
  std::optional<std::uint16_t> closed;
};

inline constexpr const char* kGoodPassword = "tidal crumbs vexed orbit";

/// The whole console but for the server, the store and boothd, which are stand-ins; at https://localhost:8437.
/// Thread-bound.
class ConsoleDesk {
 public:
  ConsoleDesk() {
    AddSessionRoutes(table, context, frame);
    AddAdminRoutes(table, context, frame);
    gate.set_port(8437);
  }

  /// An account with kGoodPassword.
  void AddUser(const std::string& name, StationRole role) {
    static const std::string hash = *HashPassword(kGoodPassword);
    User user;
    user.name = name;
    user.role = role;
    static_cast<void>(store.AddUser(user, hash));
  }

  ManualClock clock;
  AccountStore store;
  Config config;
  PosixStorage storage;
  LoginGuard guard{clock};
  Sessions sessions{clock};
  Accounts accounts{store, guard, clock};
  ConsoleAudit audit{store, clock};
  std::unique_ptr<LiveHub> live = LiveHub::Make();
  CountingBooth booth;
  CountingModels models;
  InstantJobs jobs;
  NoScratch scratch;
  ConsoleContext context{config, "sim", store, booth, *live, jobs, models, scratch, storage, clock};
  ConsoleFrame frame{accounts, sessions, audit, [] { return std::string(); }};
  RouteTable table;
  RequestGate gate{GateOptions{{"booth.example"}, true}, sessions};
  StaticFiles files = *StaticFiles::Read("");
  std::vector<Scanner::JogDirection> jogs;
  ConsoleHandler handler{ConsoleParts{table, gate, sessions, files, *live, audit, [this](Scanner::JogDirection way) {
                                        jogs.push_back(way);
                                        return Status();
                                      }}};
};

/// A browser: keeps the cookie and the CSRF token, and sends what the page would send.
class Browser {
 public:
  explicit Browser(ConsoleDesk& desk, bool loopback = true) : desk_(desk), loopback_(loopback) {}

  [[nodiscard]] HttpRequest GetRequest(const std::string& path) const {
    HttpRequest request;
    request.method = "GET";
    request.path = path;
    request.loopback = loopback_;
    request.tls = true;
    request.peer = loopback_ ? "127.0.0.1" : "192.0.2.9";
    request.headers = {{"host", "localhost:8437"}, {"sec-fetch-site", "same-origin"}};
    if (!cookie.empty()) request.headers.emplace_back("cookie", "__Host-annulus=" + cookie);
    return request;
  }
  [[nodiscard]] HttpRequest PostRequest(const std::string& path, const std::string& body) const {
    HttpRequest request = GetRequest(path);
    request.method = "POST";
    request.headers.emplace_back("origin", "https://localhost:8437");
    request.headers.emplace_back("content-type", "application/json");
    request.headers.emplace_back("x-csrf-token", csrf);
    request.body = body;
    return request;
  }
  HttpResponse Send(const HttpRequest& request) {
    HttpResponse response = desk_.handler.Handle(request);
    for (const auto& [name, value] : response.headers) {
      if (name == "Set-Cookie") cookie = value.substr(value.find('=') + 1, value.find(';') - value.find('=') - 1);
    }
    const auto json = nlohmann::json::parse(response.body, nullptr, false);
    if (json.is_object() && json.contains("csrf")) csrf = json["csrf"].get<std::string>();
    return response;
  }
  HttpResponse Get(const std::string& path) { return Send(GetRequest(path)); }
  HttpResponse Post(const std::string& path, const nlohmann::json& body = nlohmann::json::object()) {
    return Send(PostRequest(path, body.dump()));
  }
  /// As the page does it: asks for the session, then logs in.
  HttpResponse LogIn(const std::string& user, const std::string& password = kGoodPassword) {
    Get("/api/session");
    return Post("/api/login", {{"user", user}, {"password", password}});
  }
  /// A session without the work of a login.
  void BecomeUser(const std::string& user, StationRole role) {
    const auto opened = desk_.sessions.Open(user, role, loopback_);
    cookie = opened.cookie;
    csrf = desk_.sessions.CsrfToken(cookie);
    session_id = opened.session.id;
  }

  std::string cookie;
  std::string csrf;
  std::string session_id;

 private:
  ConsoleDesk& desk_;
  bool loopback_;
};

/// A header's value; "" if it is not there.
inline std::string HeaderOf(const HttpResponse& response, const std::string& name) {
  for (const auto& [key, value] : response.headers) {
    if (key == name) return value;
  }
  return "";
}

}  // namespace annulus::test
