#include "station/console/route.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace annulus {
namespace {

/// Texts that may be longer than this are for people to write several lines in.
constexpr std::size_t kOneLineBytes = 512;

std::vector<std::string_view> Segments(std::string_view path) {
  std::vector<std::string_view> segments;
  while (!path.empty()) {
    path.remove_prefix(1);  // the '/' that every segment begins with
    const std::size_t end = std::min(path.find('/'), path.size());
    segments.push_back(path.substr(0, end));
    path.remove_prefix(end);
  }
  return segments;
}

bool IsParameter(std::string_view segment) {
  return segment.size() > 2 && segment.front() == '{' && segment.back() == '}';
}

/// What stands for the parameters of the pattern; nothing if the path is not of it.
std::optional<std::map<std::string, std::string>> Fit(const std::string& pattern, const std::string& path) {
  const auto wanted = Segments(pattern);
  const auto given = Segments(path);
  if (wanted.size() != given.size()) return std::nullopt;
  std::map<std::string, std::string> parameters;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (IsParameter(wanted[i])) {
      if (given[i].empty()) return std::nullopt;
      parameters[std::string(wanted[i].substr(1, wanted[i].size() - 2))] = std::string(given[i]);
    } else if (wanted[i] != given[i]) {
      return std::nullopt;
    }
  }
  return parameters;
}

/// Whether UTF-8 `text` (nlohmann lets nothing else through) has a control character: C0, DEL or C1. Line ends and
/// tabs are none in texts of several lines.
bool HasControlCharacter(std::string_view text, bool several_lines) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (several_lines && (c == '\n' || c == '\r' || c == '\t')) continue;
    if (c < 0x20 || c == 0x7F) return true;
    const bool c1 = c == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0;
    if (c1) return true;
  }
  return false;
}

bool IsMissing(const nlohmann::json& body, const char* name) { return !body.contains(name) || body[name].is_null(); }

}  // namespace

bool RouteRoles::Allows(StationRole role) const {
  switch (role) {
    case StationRole::kNone:
      return none;
    case StationRole::kOperator:
      return operator_;
    case StationRole::kTechnician:
      return technician;
    case StationRole::kAdmin:
      return admin;
  }
  return false;
}

tl::unexpected<ApiError> BadField(std::string field, std::string seen, std::string advice) {
  Error error{"read '" + field + "' of the request", std::move(seen), std::move(advice)};
  return tl::unexpected<ApiError>(ApiError{400, std::move(error), std::move(field)});
}

tl::unexpected<ApiError> Refuse(int status, Error error) {
  return tl::unexpected<ApiError>(ApiError{status, std::move(error), ""});
}

HttpResponse JsonAnswer(const nlohmann::ordered_json& json, int status) {
  HttpResponse response;
  response.status = status;
  response.content_type = "application/json";
  response.body = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return response;
}

void RouteTable::Add(Route route) { routes_.push_back(std::move(route)); }

RouteTable::Match RouteTable::Find(const std::string& method, const std::string& path) const {
  Match best;
  bool found_path = false;
  for (const Route& route : routes_) {
    auto parameters = Fit(route.pattern, path);
    if (!parameters) continue;
    found_path = true;
    // The pattern that leaves less open wins: /api/scans/import before /api/scans/{scan}.
    const bool better = best.route == nullptr || parameters->size() < best.parameters.size();
    if (route.method == method && better) {
      best.route = &route;
      best.parameters = std::move(*parameters);
    }
  }
  best.other_method = best.route == nullptr && found_path;
  return best;
}

tl::expected<std::string, ApiError> TextField(const nlohmann::json& body, const char* name, std::size_t max_bytes) {
  if (IsMissing(body, name)) return BadField(name, "it is missing", "give it");
  const nlohmann::json& value = body[name];
  if (!value.is_string()) return BadField(name, "it is not a text", "give a text");
  const auto& text = value.get_ref<const std::string&>();
  if (text.size() > max_bytes) {
    return BadField(name, "it has " + std::to_string(text.size()) + " bytes",
                    "give at most " + std::to_string(max_bytes));
  }
  if (HasControlCharacter(text, max_bytes > kOneLineBytes)) {
    return BadField(name, "it has control characters", "leave them out");
  }
  return text;
}

tl::expected<std::optional<std::string>, ApiError> OptionalText(const nlohmann::json& body, const char* name,
                                                                std::size_t max_bytes) {
  if (IsMissing(body, name)) return std::nullopt;
  auto text = TextField(body, name, max_bytes);
  if (!text) return tl::unexpected(std::move(text.error()));
  return std::optional<std::string>(std::move(*text));
}

tl::expected<double, ApiError> NumberField(const nlohmann::json& body, const char* name, double low, double high) {
  if (IsMissing(body, name)) return BadField(name, "it is missing", "give it");
  const nlohmann::json& value = body[name];
  if (!value.is_number()) return BadField(name, "it is not a number", "give a number");
  const auto number = value.get<double>();
  if (!(number >= low && number <= high)) {
    const auto text = [](double x) { return nlohmann::json(x).dump(); };
    return BadField(name, "it is " + text(number), "give a number from " + text(low) + " to " + text(high));
  }
  return number;
}

tl::expected<std::optional<double>, ApiError> OptionalNumber(const nlohmann::json& body, const char* name, double low,
                                                             double high) {
  if (IsMissing(body, name)) return std::nullopt;
  auto number = NumberField(body, name, low, high);
  if (!number) return tl::unexpected(std::move(number.error()));
  return std::optional<double>(*number);
}

tl::expected<bool, ApiError> FlagField(const nlohmann::json& body, const char* name) {
  if (IsMissing(body, name)) return BadField(name, "it is missing", "give true or false");
  if (!body[name].is_boolean()) return BadField(name, "it is not true or false", "give true or false");
  return body[name].get<bool>();
}

}  // namespace annulus
