#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "modeling/glasses/prescription.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "annulus-rx";
constexpr int kVersion = 1;
constexpr const char* kAdvice = "correct the file; docs/formats.md describes RX.json";
constexpr std::size_t kLargestFile = 1 << 20;

/// What is wrong with the file. Thrown by the readers of its fields, caught in PrescriptionFromJson.
struct BadRx {
  std::string seen;
};

/// Parses, refusing repeated keys: of two "sph_d" neither can be trusted.
Json Parse(std::string_view text) {
  std::vector<std::set<std::string>> open;
  std::string repeated;
  const auto watch = [&](int /*depth*/, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) open.emplace_back();
    if (event == Json::parse_event_t::object_end && !open.empty()) open.pop_back();
    if (event == Json::parse_event_t::key && !open.empty()) {
      const auto& key = parsed.get_ref<const std::string&>();
      if (!open.back().insert(key).second) repeated = key;
    }
    return true;
  };
  Json root = Json::parse(text, watch, false);
  if (root.is_discarded() || !root.is_object()) throw BadRx{"it is not a complete JSON object"};
  if (!repeated.empty()) throw BadRx{fmt::format("'{}' is given twice", repeated)};
  return root;
}

void OnlyKeys(const Json& object, const std::string& where, std::initializer_list<std::string_view> known) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      throw BadRx{fmt::format("{}'{}' is not a known key (known: {})", where, key, fmt::join(known, ", "))};
    }
  }
}

const Json& Object(const Json& parent, const char* key) {
  const auto found = parent.find(key);
  if (found == parent.end() || !found->is_object()) throw BadRx{fmt::format("'{}' is missing or no object", key)};
  return *found;
}

std::optional<double> MaybeNumber(const Json& object, const std::string& where, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nullopt;
  if (!found->is_number()) throw BadRx{fmt::format("{}'{}' is not a number", where, key)};
  const auto value = found->get<double>();
  if (!std::isfinite(value)) throw BadRx{fmt::format("{}'{}' is too large", where, key)};
  return value;
}

double Number(const Json& object, const std::string& where, const char* key) {
  const std::optional<double> value = MaybeNumber(object, where, key);
  if (!value) throw BadRx{fmt::format("{}'{}' is missing", where, key)};
  return *value;
}

std::string Text(const Json& object, const std::string& where, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_string()) {
    throw BadRx{fmt::format("{}'{}' is missing or no text", where, key)};
  }
  return found->get<std::string>();
}

/// One half of a prism: an amount and the side of its base; `plus` is the side that counts positive.
double PrismHalf(const Json& prism, const std::string& where, const char* amount_key, const char* base_key,
                 std::string_view plus, std::string_view minus) {
  const std::optional<double> amount = MaybeNumber(prism, where, amount_key);
  if (!amount) {
    if (prism.contains(base_key)) throw BadRx{fmt::format("{}'{}' has no '{}'", where, base_key, amount_key)};
    return 0.0;
  }
  if (*amount < 0.0)
    throw BadRx{fmt::format("{}'{}' is {}, below 0: turn the base instead", where, amount_key, *amount)};
  const std::string base = Text(prism, where, base_key);
  if (base != plus && base != minus) {
    throw BadRx{fmt::format("{}'{}' is '{}', neither '{}' nor '{}'", where, base_key, base, plus, minus)};
  }
  return base == plus ? *amount : 0.0 - *amount;
}

Prism PrismFrom(const Json& prism, const std::string& where, Eye eye) {
  if (!prism.contains("magnitude_cm_m") && !prism.contains("base_deg")) {
    OnlyKeys(prism, where, {"horizontal_cm_m", "horizontal_base", "vertical_cm_m", "vertical_base"});
    return {PrismHalf(prism, where, "horizontal_cm_m", "horizontal_base", "in", "out"),
            PrismHalf(prism, where, "vertical_cm_m", "vertical_base", "up", "down")};
  }
  OnlyKeys(prism, where, {"magnitude_cm_m", "base_deg"});
  const double magnitude = Number(prism, where, "magnitude_cm_m");
  const double base = Number(prism, where, "base_deg");
  if (!(magnitude >= 0.0 && magnitude <= 1000.0)) {
    throw BadRx{fmt::format("{}'magnitude_cm_m' is {}, outside 0 to 20", where, magnitude)};
  }
  if (!(base >= 0.0 && base <= 360.0)) throw BadRx{fmt::format("{}'base_deg' is {}, outside 0 to 360", where, base)};
  return PrismFromBase(magnitude, base, eye);
}

EyePrescription EyeFrom(const Json& root, const char* key, Eye eye) {
  const Json& object = Object(root, key);
  const std::string where = fmt::format("{}: ", key);
  OnlyKeys(object, where, {"sph_d", "cyl_d", "axis_deg", "prism", "add_d", "pd_mm", "height_mm"});
  EyePrescription order;
  order.sphere = Number(object, where, "sph_d");
  order.cylinder = MaybeNumber(object, where, "cyl_d").value_or(0.0);
  order.axis_deg = MaybeNumber(object, where, "axis_deg");
  order.add = MaybeNumber(object, where, "add_d");
  order.pd = MaybeNumber(object, where, "pd_mm");
  order.height = MaybeNumber(object, where, "height_mm");
  if (object.contains("prism")) order.prism = PrismFrom(Object(object, "prism"), where + "prism: ", eye);
  return order;
}

std::string ConfirmedBy(const Json& root) {
  if (!root.contains("centration")) return {};
  const Json& centration = Object(root, "centration");
  const std::string where = "centration: ";
  OnlyKeys(centration, where, {"status", "confirmed_by"});
  const std::string status = Text(centration, where, "status");
  if (status == "estimate") {
    if (centration.contains("confirmed_by")) throw BadRx{"centration: an 'estimate' has no 'confirmed_by'"};
    return {};
  }
  if (status != "confirmed") {
    throw BadRx{fmt::format("centration: 'status' is '{}', neither 'estimate' nor 'confirmed'", status)};
  }
  std::string name = Text(centration, where, "confirmed_by");
  if (name.find_first_not_of(" \t\r\n") == std::string::npos) {
    throw BadRx{"centration: 'confirmed_by' is empty; a confirmation has a name"};
  }
  return name;
}

Prescription FromRoot(const Json& root) {
  if (root.value("format", Json()) != kFormat) throw BadRx{fmt::format("its format is not '{}'", kFormat)};
  if (root.value("version", Json()) != kVersion) throw BadRx{fmt::format("its version is not {}", kVersion)};
  OnlyKeys(root, "", {"format", "version", "date", "prescriber", "refracted_vertex_mm", "right", "left", "centration"});
  Prescription prescription;
  prescription.date = Text(root, "", "date");
  prescription.prescriber = Text(root, "", "prescriber");
  prescription.refracted_vertex = MaybeNumber(root, "", "refracted_vertex_mm");
  prescription.right = EyeFrom(root, "right", Eye::kRight);
  prescription.left = EyeFrom(root, "left", Eye::kLeft);
  prescription.centration_confirmed_by = ConfirmedBy(root);
  return prescription;
}

void PutIf(Json& object, const char* key, const std::optional<double>& value) {
  if (value) object[key] = *value;
}

Json ToJson(const Prism& prism) {
  Json json = Json::object();
  if (prism.in != 0.0) {
    json["horizontal_cm_m"] = std::abs(prism.in);
    json["horizontal_base"] = prism.in > 0.0 ? "in" : "out";
  }
  if (prism.up != 0.0) {
    json["vertical_cm_m"] = std::abs(prism.up);
    json["vertical_base"] = prism.up > 0.0 ? "up" : "down";
  }
  return json;
}

Json ToJson(const EyePrescription& order) {
  Json json{{"sph_d", order.sphere}, {"cyl_d", order.cylinder}};
  PutIf(json, "axis_deg", order.axis_deg);
  if (order.prism != Prism{}) json["prism"] = ToJson(order.prism);
  PutIf(json, "add_d", order.add);
  PutIf(json, "pd_mm", order.pd);
  PutIf(json, "height_mm", order.height);
  return json;
}

}  // namespace

std::string PrescriptionToJson(const Prescription& prescription) {
  Json root{
      {"format", kFormat}, {"version", kVersion}, {"date", prescription.date}, {"prescriber", prescription.prescriber}};
  PutIf(root, "refracted_vertex_mm", prescription.refracted_vertex);
  root["right"] = ToJson(prescription.right);
  root["left"] = ToJson(prescription.left);
  Json centration{{"status", prescription.centration_confirmed() ? "confirmed" : "estimate"}};
  if (prescription.centration_confirmed()) centration["confirmed_by"] = prescription.centration_confirmed_by;
  root["centration"] = centration;
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<Prescription> PrescriptionFromJson(std::string_view json, std::string_view name) {
  const std::string attempted = fmt::format("read the prescription {}", name);
  if (json.size() > kLargestFile) return Fail(attempted, "it has more than 1 MiB", kAdvice);
  try {
    Prescription prescription = FromRoot(Parse(json));
    if (const Status valid = Validate(prescription); !valid)
      return Fail(attempted, valid.error().seen, valid.error().advice);
    return prescription;
  } catch (const BadRx& bad) {
    return Fail(attempted, bad.seen, kAdvice);
  }
}

}  // namespace annulus
