#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "station/console/route.h"
#include "station/console/sessions.h"

namespace annulus {

/// Name of the session's cookie.
inline constexpr std::string_view kSessionCookie = "__Host-annulus";

/// What stops the booth; for everybody.
inline constexpr std::string_view kStopPath = "/api/stop";

/// Set-Cookie's value that gives the browser this cookie (Secure, HttpOnly, SameSite=Strict, Path=/, RFC 6265bis).
[[nodiscard]] std::string SessionCookieHeader(std::string_view cookie);

/// Whether the body of a route is bytes of a file, not JSON.
[[nodiscard]] bool TakesBytes(const Route& route);

struct GateOptions {
  std::vector<std::string> host_names;  ///< Names beside localhost, 127.0.0.1 and [::1] under which we are reached.
  bool tls = true;                      ///< Origins begin with https.
  /// Why our certificate cannot be relied on now; "" while it can. May be empty.
  std::function<std::string()> certificate_problem = {};
};

/// Decides whether a request may go on to its route: docs/console_api.md §1, in the order of that table. Deny by
/// default: what no rule lets through is refused. Thread-safe.
class RequestGate {
 public:
  /// Borrows `sessions`.
  RequestGate(GateOptions options, Sessions& sessions) : options_(std::move(options)), sessions_(sessions) {}

  /// The port we listen on. Until it is known every request is refused.
  void set_port(std::uint16_t port) { port_ = port; }

  /// 403 unless there is one Host, and it is ours (DNS rebinding); 503 for all but STOP if it comes from afar while our
  /// certificate cannot be relied on (fault row N7).
  [[nodiscard]] std::optional<ApiError> CheckHost(const HttpRequest& request) const;

  /// A request that was let through.
  struct Passed {
    const Route* route = nullptr;
    std::map<std::string, std::string> path;
    Caller caller;
  };
  /// One that was not. `by_rule`: by one of the rules that the audit is told of.
  struct Refused {
    ApiError error;
    Caller caller;
    const Route* route = nullptr;
    bool by_rule = true;
  };
  /// An API request whose Host was checked: its path and method, content type, Origin, role, place, CSRF token, and,
  /// for orders to the booth, whether its session has control.
  [[nodiscard]] tl::expected<Passed, Refused> Check(const RouteTable& table, const HttpRequest& request);

  /// A WebSocket that is to be opened: Host and Origin must be ours. Anybody may look on; Caller says who it is.
  [[nodiscard]] tl::expected<Caller, Refused> CheckSocket(const HttpRequest& request);

  /// Who sends it.
  [[nodiscard]] Caller CallerOf(const HttpRequest& request, SessionUse use);

 private:
  [[nodiscard]] bool IsOurHost(std::string_view host) const;
  [[nodiscard]] std::optional<ApiError> CheckOrigin(const HttpRequest& request) const;
  [[nodiscard]] std::optional<ApiError> CheckPost(const HttpRequest& request, const Route& route) const;
  [[nodiscard]] std::optional<ApiError> CheckRole(const Route& route, const Caller& caller) const;
  [[nodiscard]] std::optional<ApiError> CheckControl(const Route& route, const Caller& caller);

  GateOptions options_;
  Sessions& sessions_;
  std::atomic<std::uint16_t> port_{0};
};

}  // namespace annulus
