#include "station/console/request_gate.h"

#include <algorithm>
#include <array>
#include <utility>

namespace annulus {
namespace {

constexpr std::string_view kImport = "/api/scans/import";

/// What the page asks by itself while nobody touches it: no use of the session.
constexpr std::array<std::string_view, 4> kBackground{"/api/session", "/api/booth", "/api/jobs", "/api/store"};

/// Orders by which the booth moves or stops waiting; one session at a time may give them.
constexpr std::array<std::string_view, 7> kOrders{"/api/booth/home",        "/api/booth/arm", "/api/booth/start",
                                                  "/api/booth/acknowledge", "/api/booth/jog", "/api/calibration/begin",
                                                  "/api/calibration/take"};

template <std::size_t n>
bool IsAmong(const std::array<std::string_view, n>& list, std::string_view text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

SessionUse UseOf(const HttpRequest& request) {
  const bool background =
      request.method == "GET" && (IsAmong(kBackground, request.path) || request.path.starts_with("/api/jobs/"));
  return background ? SessionUse::kLook : SessionUse::kUse;
}

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

/// "application/json; charset=utf-8" is of "application/json".
bool IsOfType(std::string_view content_type, std::string_view type) {
  const std::string lower = Lower(content_type);
  if (!lower.starts_with(type)) return false;
  std::string rest = lower.substr(type.size());
  std::erase(rest, ' ');
  return rest.empty() || rest == ";charset=utf-8";
}

ApiError Denied(int status, std::string seen, std::string advice) {
  return {status, {"let the request in", std::move(seen), std::move(advice)}, ""};
}

const char* const kUseThePage = "open the console's page and use that";

}  // namespace

std::string SessionCookieHeader(std::string_view cookie) {
  return std::string(kSessionCookie) + "=" + std::string(cookie) + "; Path=/; Secure; HttpOnly; SameSite=Strict";
}

bool TakesBytes(const Route& route) { return route.pattern == kImport; }

bool RequestGate::IsOurHost(std::string_view host) const {
  const std::uint16_t port = port_;
  if (port == 0) return false;
  const std::string lower = Lower(host);
  const std::string with_port = ":" + std::to_string(port);
  const std::uint16_t usual = options_.tls ? 443 : 80;
  const auto is = [&](const std::string& name) {
    return lower == name + with_port || (port == usual && lower == name);
  };
  if (is("localhost") || is("127.0.0.1") || is("[::1]")) return true;
  return std::any_of(options_.host_names.begin(), options_.host_names.end(),
                     [&](const std::string& name) { return is(Lower(name)); });
}

std::optional<ApiError> RequestGate::CheckHost(const HttpRequest& request) const {
  if (request.HeaderCount("host") != 1 || !IsOurHost(*request.Header("host"))) {
    return Denied(403, "its Host is none of ours",
                  "use https://localhost and the port, or add the name to [console] host_names");
  }
  if (request.loopback || request.path == kStopPath || !options_.certificate_problem) return std::nullopt;
  const std::string problem = options_.certificate_problem();
  if (problem.empty()) return std::nullopt;
  return Denied(503, problem, "use the booth's own screen, and set the booth's clock");
}

std::optional<ApiError> RequestGate::CheckOrigin(const HttpRequest& request) const {
  const std::string ours = (options_.tls ? "https://" : "http://") + std::string(request.Header("host").value_or(""));
  if (request.HeaderCount("origin") != 1 || Lower(*request.Header("origin")) != Lower(ours)) {
    return Denied(403, "its Origin is not ours", kUseThePage);
  }
  const std::size_t sites = request.HeaderCount("sec-fetch-site");
  if (sites > 1 || (sites == 1 && *request.Header("sec-fetch-site") != "same-origin")) {
    return Denied(403, "it comes from another site's page", kUseThePage);
  }
  return std::nullopt;
}

std::optional<ApiError> RequestGate::CheckPost(const HttpRequest& request, const Route& route) const {
  const std::string_view type = TakesBytes(route) ? "application/octet-stream" : "application/json";
  if (request.HeaderCount("content-type") != 1 || !IsOfType(*request.Header("content-type"), type)) {
    return Denied(415, "its Content-Type is not " + std::string(type), "send it with that type");
  }
  return CheckOrigin(request);
}

std::optional<ApiError> RequestGate::CheckRole(const Route& route, const Caller& caller) const {
  if (!route.roles.Allows(caller.role)) {
    if (caller.role == StationRole::kNone) return Denied(401, "nobody is logged in", "log in");
    return Denied(403, "an account of role " + std::string(StationRoleName(caller.role)) + " may not do this",
                  "log in with an account that may");
  }
  if (route.local_only && !caller.loopback) {
    return Denied(403, "it does not come from the booth's own screen", "do it at the booth");
  }
  return std::nullopt;
}

std::optional<ApiError> RequestGate::CheckControl(const Route& route, const Caller& caller) {
  if (route.method != "POST" || !IsAmong(kOrders, route.pattern)) return std::nullopt;
  const auto holder = sessions_.TakeControl(caller.session_id);
  if (!holder) return std::nullopt;
  return Denied(409, "another session of user '" + *holder + "' works with the booth",
                "let it finish or log out; a minute without an order is enough");
}

Caller RequestGate::CallerOf(const HttpRequest& request, SessionUse use) {
  Caller caller;
  caller.loopback = request.loopback;
  caller.peer = request.peer;
  const auto cookie = request.Cookie(kSessionCookie);
  if (!cookie) return caller;
  const auto session = sessions_.Find(*cookie, request.loopback, use);
  if (!session) return caller;
  caller.user = session->user;
  caller.role = session->role;
  caller.session_id = session->id;
  return caller;
}

tl::expected<RequestGate::Passed, RequestGate::Refused> RequestGate::Check(const RouteTable& table,
                                                                           const HttpRequest& request) {
  // Whether it is use of the session is known once it has passed; until then it is not.
  const Caller caller = CallerOf(request, SessionUse::kLook);
  RouteTable::Match match = table.Find(request.method, request.path);
  const auto refuse = [&](std::optional<ApiError> error, bool by_rule = true) {
    return tl::unexpected<Refused>(Refused{std::move(*error), caller, match.route, by_rule});
  };
  if (match.other_method) return refuse(Denied(405, "this cannot be done with " + request.method, kUseThePage));
  if (match.route == nullptr) return refuse(Denied(404, "there is no such thing", kUseThePage), false);
  const Route& route = *match.route;
  const bool post = route.method == "POST";
  if (post) {
    if (auto error = CheckPost(request, route)) return refuse(std::move(error));
  } else if (const auto site = request.Header("sec-fetch-site"); site && *site != "same-origin" && *site != "none") {
    return refuse(Denied(403, "it comes from another site's page", kUseThePage));
  }
  if (auto error = CheckRole(route, caller)) return refuse(std::move(error));
  if (post && route.pattern != kStopPath) {
    const std::string_view cookie = request.Cookie(kSessionCookie).value_or("");
    const std::string_view token = request.Header("x-csrf-token").value_or("");
    if (request.HeaderCount("x-csrf-token") != 1 || !sessions_.IsCsrfToken(cookie, token)) {
      return refuse(Denied(403, "its X-CSRF-Token is not this session's", "load the page again"));
    }
  }
  if (auto error = CheckControl(route, caller)) return refuse(std::move(error), false);
  if (UseOf(request) == SessionUse::kUse) sessions_.Use(caller.session_id);
  return Passed{match.route, std::move(match.parameters), caller};
}

tl::expected<Caller, RequestGate::Refused> RequestGate::CheckSocket(const HttpRequest& request) {
  const Caller caller = CallerOf(request, SessionUse::kLook);
  if (auto error = CheckHost(request)) return tl::unexpected(Refused{std::move(*error), caller, nullptr, true});
  if (auto error = CheckOrigin(request)) return tl::unexpected(Refused{std::move(*error), caller, nullptr, true});
  if (request.path != "/api/live") {
    return tl::unexpected(Refused{Denied(404, "there is no such thing", kUseThePage), caller, nullptr, false});
  }
  return caller;
}

}  // namespace annulus
