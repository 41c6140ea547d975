#include "station/console/glasses_request.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "modeling/glasses/frame_fields.h"
#include "modeling/glasses/prescription.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"
#include "station/look_file.h"

namespace annulus {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kLongestName = 64;

/// The member of an object as a field's text.
tl::expected<std::string, ApiError> FieldText(const std::string& name, const Json& value) {
  const std::string place = "design.fields." + name;
  const FrameField* const field = FindFrameField(name);
  if (field == nullptr) return BadField(place, "a frame has no such field", "see the catalogue");
  if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    if (!text.empty() && text.size() <= kLongestName) return text;
    return BadField(place, fmt::format("its text has {} bytes", text.size()), FieldSyntax(*field));
  }
  if (!value.is_number()) return BadField(place, std::string("it is ") + value.type_name(), FieldSyntax(*field));
  const auto number = value.get<double>();
  if (field->unit != FieldUnit::kWord && number >= field->low && number <= field->high) {
    return fmt::format("{}", number);
  }
  return BadField(
      place, fmt::format("it is {}", number),
      field->unit == FieldUnit::kWord ? FieldSyntax(*field) : fmt::format("give {} … {}", field->low, field->high));
}

tl::expected<std::string, ApiError> NameIn(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return std::string();
  if (found->is_string() && found->get_ref<const std::string&>().size() <= kLongestName) {
    return found->get<std::string>();
  }
  return BadField(std::string("design.") + key, "it is no short text", "see the catalogue");
}

}  // namespace

tl::expected<DesignRequest, ApiError> DesignIn(const Json& body) {
  const auto found = body.find("design");
  if (found == body.end() || !found->is_object()) {
    return BadField("design", "it is missing, or no object", "give {style, size, fields}");
  }
  if (const auto known = OnlyKeys(*found, {"style", "size", "fields"}); !known) {
    return BadField("design." + known.error().field, known.error().error);
  }
  DesignRequest request;
  auto style = NameIn(*found, "style");
  if (!style) return tl::unexpected(style.error());
  auto size = NameIn(*found, "size");
  if (!size) return tl::unexpected(size.error());
  if (style->empty()) return BadField("design.style", "it is missing", "see the catalogue");
  request.style = std::move(*style);
  request.size = std::move(*size);
  const auto fields = found->find("fields");
  if (fields == found->end() || fields->is_null()) return request;
  if (!fields->is_object()) return BadField("design.fields", "it is no object", "give {name: value}");
  for (const auto& [name, value] : fields->items()) {
    auto text = FieldText(name, value);
    if (!text) return tl::unexpected(text.error());
    request.fields.emplace_back(name, std::move(*text));
  }
  return request;
}

nlohmann::ordered_json DesignJson(const DesignRequest& request) {
  nlohmann::ordered_json fields = nlohmann::ordered_json::object();
  for (const auto& [name, text] : request.fields) fields[name] = text;
  return {{"style", request.style}, {"size", request.size}, {"fields", fields}};
}

tl::expected<ComposedDesign, ApiError> ComposedIn(const Json& body) {
  const auto request = DesignIn(body);
  if (!request) return tl::unexpected(request.error());
  const FrameLibrary& library = BuiltInFrameLibrary();
  if (const auto style = library.Find(request->style); !style) return BadField("design.style", style.error());
  // Each text by itself first, so that the one that is wrong is named.
  for (const auto& [name, text] : request->fields) {
    const auto one = WithField((*library.Find(request->style))->design, name, text);
    if (!one) return BadField("design.fields." + name, one.error());
  }
  auto composed = ComposeDesign(library, *request);
  if (composed) return std::move(*composed);
  return BadField(request->size.empty() ? "design" : "design.size", composed.error());
}

tl::expected<Look, ApiError> LookIn(const Json& body) {
  const auto found = body.find("look");
  if (found == body.end() || found->is_null()) return Look{};
  if (!found->is_object()) return BadField("look", "it is no object", "give LOOK.json (docs/formats.md)");
  Json whole = *found;
  whole.emplace("format", "annulus-look");
  whole.emplace("version", 1);
  auto look = LookFromJson(whole.dump(-1, ' ', false, Json::error_handler_t::replace), "look");
  if (look) return std::move(*look);
  // The place stands in quotes at the beginning of what was seen: 'upper.colour' is …
  const std::string& seen = look.error().seen;
  const std::size_t end = seen.empty() || seen.front() != '\'' ? std::string::npos : seen.find('\'', 1);
  return BadField(end == std::string::npos ? "look" : "look." + seen.substr(1, end - 1), look.error());
}

tl::expected<std::optional<std::string>, ApiError> PrescriptionIn(const Json& body) {
  const auto found = body.find("prescription");
  if (found == body.end() || found->is_null()) return std::optional<std::string>();
  if (!found->is_object()) return BadField("prescription", "it is no object", "give RX.json (docs/formats.md)");
  std::string text = found->dump(-1, ' ', false, Json::error_handler_t::replace);
  if (const auto order = PrescriptionFromJson(text, "prescription"); !order) {
    return BadField("prescription", order.error());
  }
  return std::optional(std::move(text));
}

}  // namespace annulus
