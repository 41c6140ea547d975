#include <nlohmann/json.hpp>
#include <utility>

#include "station/command_line.h"
#include "station/console/accounts.h"
#include "station/console/booth_link.h"
#include "station/console/console_audit.h"
#include "station/console/console_context.h"
#include "station/console/console_frame.h"
#include "station/console/live_hub.h"
#include "station/console/model_cache.h"
#include "station/console/request_gate.h"
#include "station/console/request_keys.h"
#include "station/console/sessions.h"
#include "station/devices.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLongestName = 64;
constexpr std::size_t kLongestSecret = 256;

/// What all of these routes work with; lives as long as the table.
struct Desk {
  ConsoleContext& context;
  ConsoleFrame& frame;
};

/// What the page needs first, and after every login.
Result<Json> SessionJson(const Desk& desk, const Caller& caller, std::string_view cookie, std::int64_t idle_s) {
  const Config& config = desk.context.config;
  const bool store_ready = desk.context.store.state() == StoreState::kReady;
  const auto empty = desk.frame.accounts.Empty();
  if (!empty && store_ready) return Fail(empty);  // a damaged one is told: the page still shows the booth, and stops it
  return Json{{"user", caller.user},
              {"role", StationRoleName(caller.role)},
              {"csrf", desk.frame.sessions.CsrfToken(cookie)},
              {"local", caller.loopback},
              {"setup_needed", empty.value_or(false)},
              {"station_id", config.station_id},
              {"version", ProgramVersion()},
              {"simulated", AllSimulated(config)},
              {"language", config.language},
              {"units", config.units},
              {"idle_s", idle_s},
              {"store", {{"state", store_ready ? "ready" : "read_only"}, {"problem", desk.context.store.problem()}}},
              {"booth_connected", desk.context.booth.status().has_value()},
              {"certificate_problem", desk.frame.certificate_problem()},
              {"stop_is_not_estop", true}};
}

ApiResult GetSession(const Desk& desk, const ApiRequest& request) {
  // Without a cookie of ours there is a new one, of nobody: the CSRF token for the login belongs to it.
  const auto given = request.http.Cookie(kSessionCookie);
  const bool keep = given && Sessions::IsCookie(*given);
  const std::string cookie = keep ? std::string(*given) : Sessions::NewCookie();
  const auto session = desk.frame.sessions.Find(cookie, request.caller.loopback, SessionUse::kLook);
  auto json = SessionJson(desk, request.caller, cookie, session ? desk.frame.sessions.Left(*session).count() : 0);
  if (!json) return Refuse(503, json.error());
  HttpResponse response = JsonAnswer(*json);
  if (!keep) response.headers.emplace_back("Set-Cookie", SessionCookieHeader(cookie));
  return response;
}

ApiResult Setup(const Desk& desk, const ApiRequest& request) {
  if (auto known = OnlyKeys(request.body, {"user", "password"}); !known) return tl::unexpected(known.error());
  const auto user = TextField(request.body, "user", kLongestName);
  if (!user) return tl::unexpected(user.error());
  const auto password = TextField(request.body, "password", kLongestSecret);
  if (!password) return tl::unexpected(password.error());
  const auto empty = desk.frame.accounts.Empty();
  if (!empty) return Refuse(503, empty.error());
  if (!*empty) return Refuse(409, {"make the first user", "there are users", "log in as one of them"});
  const Status made = desk.frame.accounts.MakeFirst(*user, *password);
  if (!made) return Refuse(400, made.error());
  return JsonAnswer(Json::object());
}

tl::expected<LoginAttempt, ApiError> ReadAttempt(const ApiRequest& request) {
  if (auto known = OnlyKeys(request.body, {"user", "password", "pin", "totp"}); !known) {
    return tl::unexpected(known.error());
  }
  LoginAttempt attempt;
  attempt.loopback = request.caller.loopback;
  attempt.peer = request.caller.peer;
  attempt.is_pin = request.body.contains("pin");
  if (attempt.is_pin && request.body.contains("password")) {
    return BadField("pin", "there is a password too", "give one of them");
  }
  auto user = TextField(request.body, "user", kLongestName);
  if (!user) return tl::unexpected(user.error());
  auto secret = TextField(request.body, attempt.is_pin ? "pin" : "password", kLongestSecret);
  if (!secret) return tl::unexpected(secret.error());
  auto totp = OptionalText(request.body, "totp", 16);
  if (!totp) return tl::unexpected(totp.error());
  attempt.user = std::move(*user);
  attempt.secret = std::move(*secret);
  attempt.totp = totp->value_or("");
  return attempt;
}

ApiResult RefuseLogin(const Desk& desk, const Caller& caller, const LoginRefusal& refusal) {
  desk.frame.audit.Refused(caller, "login", refusal.why);
  if (refusal.wait.count() == 0) {
    return Refuse(401, {"log in", "name, password or second factor are not right", "try again, or ask an admin"});
  }
  const std::string wait = std::to_string(refusal.wait.count());
  HttpResponse response = JsonAnswer(
      {{"error", {{"attempted", "log in"}, {"seen", "too many tries"}, {"advice", "wait " + wait + " seconds"}}}}, 429);
  response.headers.emplace_back("Retry-After", wait);
  return response;
}

ApiResult LogIn(const Desk& desk, const ApiRequest& request) {
  auto attempt = ReadAttempt(request);
  if (!attempt) return tl::unexpected(attempt.error());
  const auto user = desk.frame.accounts.LogIn(*attempt);
  if (!user) return RefuseLogin(desk, request.caller, user.error());
  if (!request.caller.session_id.empty()) {  // whoever was logged in here is no longer
    desk.frame.sessions.Close(request.caller.session_id);
    EndSession(desk.context.live, request.caller.session_id, "somebody else has logged in");
  }
  const Sessions::Opened opened = desk.frame.sessions.Open(user->name, user->role, request.caller.loopback);
  Caller caller = request.caller;
  caller.user = user->name;
  caller.role = user->role;
  caller.session_id = opened.session.id;
  desk.frame.audit.Done(caller, "login", user->name, "ok");
  auto json = SessionJson(desk, caller, opened.cookie, desk.frame.sessions.Left(opened.session).count());
  if (!json) return Refuse(503, json.error());
  HttpResponse response = JsonAnswer(*json);
  response.headers.emplace_back("Set-Cookie", SessionCookieHeader(opened.cookie));
  return response;
}

/// Nothing of a customer stays in memory or on the screens of this session.
void EndVisit(const Desk& desk, const Caller& caller) {
  desk.context.models.DropAll();
  desk.context.live.SendToSession(caller.session_id, {{"type", "screen_wiped"}});
}

ApiResult LogOut(const Desk& desk, const ApiRequest& request) {
  if (auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  EndVisit(desk, request.caller);
  desk.frame.sessions.Close(request.caller.session_id);
  EndSession(desk.context.live, request.caller.session_id, "logged out");
  HttpResponse response = JsonAnswer(Json::object());
  response.headers.emplace_back("Set-Cookie", SessionCookieHeader("") + "; Max-Age=0");
  return response;
}

ApiResult ChangePassword(const Desk& desk, const ApiRequest& request) {
  if (auto known = OnlyKeys(request.body, {"old", "new"}); !known) return tl::unexpected(known.error());
  const auto old = TextField(request.body, "old", kLongestSecret);
  if (!old) return tl::unexpected(old.error());
  const auto fresh = TextField(request.body, "new", kLongestSecret);
  if (!fresh) return tl::unexpected(fresh.error());
  const auto right =
      desk.frame.accounts.IsPassword(request.caller.user, *old, request.caller.peer, request.caller.loopback);
  if (!right && right.error().wait.count() > 0) return RefuseLogin(desk, request.caller, right.error());
  if (!right) return BadField("old", "it is not your password", "type the one you log in with");
  const Status set = desk.frame.accounts.SetPassword(request.caller.user, *fresh);
  if (!set) return tl::unexpected(ApiError{400, set.error(), "new"});
  for (const std::string& ended : desk.frame.sessions.CloseOf(request.caller.user, request.caller.session_id)) {
    EndSession(desk.context.live, ended, "the password was changed");
  }
  return JsonAnswer(Json::object());
}

ApiResult Stop(const Desk& desk) {
  const Status cancelled = desk.context.booth.Cancel();
  if (!cancelled) return Refuse(503, cancelled.error());
  return JsonAnswer(Json::object());
}

}  // namespace

void AddSessionRoutes(RouteTable& table, ConsoleContext& context, ConsoleFrame& frame) {
  const Desk desk{context, frame};
  constexpr RouteRoles kNobody{true, false, false, false};
  table.Add({"GET", "/api/session", kEverybody, false, "", "",
             [desk](const ApiRequest& request) { return GetSession(desk, request); }});
  table.Add({"POST", "/api/setup", kNobody, true, "setup", "user",
             [desk](const ApiRequest& request) { return Setup(desk, request); }});
  // The login writes its own audit: what was typed as a user's name may be anything, also a password.
  table.Add({"POST", "/api/login", kEverybody, false, "", "",
             [desk](const ApiRequest& request) { return LogIn(desk, request); }});
  table.Add({"POST", "/api/logout", kLoggedIn, false, "logout", "",
             [desk](const ApiRequest& request) { return LogOut(desk, request); }});
  table.Add({"POST", "/api/password", kLoggedIn, false, "password", "",
             [desk](const ApiRequest& request) { return ChangePassword(desk, request); }});
  table.Add({"POST", std::string(kStopPath), kEverybody, false, "stop", "",
             [desk](const ApiRequest&) { return Stop(desk); }});
  table.Add(
      {"POST", "/api/visit/end", kOperators, false, "visit end", "", [desk](const ApiRequest& request) -> ApiResult {
         if (auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
         EndVisit(desk, request.caller);
         return JsonAnswer(Json::object());
       }});
}

}  // namespace annulus
