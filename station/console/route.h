#pragma once

#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/http/http_message.h"
#include "station/store/store_types.h"

namespace annulus {

/// Who sends a request, as the session says.
struct Caller {
  std::string user;  ///< "" if nobody is logged in.
  StationRole role = StationRole::kNone;
  std::string session_id;  ///< "" without a session.
  bool loopback = false;   ///< On the booth's own screen.
  std::string peer;
};

/// Which roles may use a route. Stop is for everybody; there is no role that may do everything.
struct RouteRoles {
  bool none = false;  ///< Also who is not logged in.
  bool operator_ = false;
  bool technician = false;
  bool admin = false;
  [[nodiscard]] bool Allows(StationRole role) const;
};
inline constexpr RouteRoles kEverybody{true, true, true, true};
inline constexpr RouteRoles kLoggedIn{false, true, true, true};
inline constexpr RouteRoles kOperators{false, true, false, false};
inline constexpr RouteRoles kOperatorsTechnicians{false, true, true, false};
inline constexpr RouteRoles kTechnicians{false, false, true, false};
inline constexpr RouteRoles kAdmins{false, false, false, true};
inline constexpr RouteRoles kTechniciansAdmins{false, false, true, true};

/// What a route is given: checked and taken apart.
struct ApiRequest {
  const HttpRequest& http;
  const Caller& caller;
  const std::map<std::string, std::string>& path;  ///< What stands for {name} in the pattern.
  const nlohmann::json& body;                      ///< An object; empty if the request has no body.
};

/// Why a request was not carried out: an HTTP status and the three parts of every message; `field` names what of the
/// body was wrong.
struct ApiError {
  int status = 400;
  Error error;
  std::string field;
};
using ApiResult = tl::expected<HttpResponse, ApiError>;

/// 400, naming the field.
[[nodiscard]] tl::unexpected<ApiError> BadField(std::string field, std::string seen, std::string advice);
/// Any status.
[[nodiscard]] tl::unexpected<ApiError> Refuse(int status, Error error);
/// 200 with a JSON body.
[[nodiscard]] HttpResponse JsonAnswer(const nlohmann::ordered_json& json, int status = 200);

/// One thing that the console can be asked. GET never changes anything; everything else is POST, with the CSRF token.
struct Route {
  std::string method;   ///< "GET" or "POST".
  std::string pattern;  ///< "/api/customers/{id}".
  RouteRoles roles;
  bool local_only = false;      ///< Refused from afar whatever the role (start, jog, PIN login).
  std::string audit_action;     ///< What the audit calls it; "" for what only reads.
  std::string audit_parameter;  ///< Path parameter or body key whose value is the audit's subject (an id), or "".
  std::function<ApiResult(const ApiRequest&)> handle;
};

/// All of them, in the order in which they were added; the test of routes and roles is made from it.
class RouteTable {
 public:
  void Add(Route route);
  [[nodiscard]] const std::vector<Route>& routes() const { return routes_; }

  struct Match {
    const Route* route = nullptr;  ///< Null: no such path.
    std::map<std::string, std::string> parameters;
    bool other_method = false;  ///< The path is there, not for this method (405).
  };
  [[nodiscard]] Match Find(const std::string& method, const std::string& path) const;

 private:
  std::vector<Route> routes_;
};

// Taking a body apart. Each fails with 400 and the field's name.
/// Text of at most `max_bytes` of valid UTF-8 without control characters (line ends are allowed in notes).
[[nodiscard]] tl::expected<std::string, ApiError> TextField(const nlohmann::json& body, const char* name,
                                                            std::size_t max_bytes);
[[nodiscard]] tl::expected<std::optional<std::string>, ApiError> OptionalText(const nlohmann::json& body,
                                                                              const char* name, std::size_t max_bytes);
/// A finite number within [low, high].
[[nodiscard]] tl::expected<double, ApiError> NumberField(const nlohmann::json& body, const char* name, double low,
                                                         double high);
[[nodiscard]] tl::expected<std::optional<double>, ApiError> OptionalNumber(const nlohmann::json& body, const char* name,
                                                                           double low, double high);
[[nodiscard]] tl::expected<bool, ApiError> FlagField(const nlohmann::json& body, const char* name);

}  // namespace annulus
