// Customers, consents, export, erasure (docs/console_api.md §3).

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "modeling/glasses/prescription.h"
#include "station/console/booth_words.h"
#include "station/console/consent_texts.h"
#include "station/console/console_context.h"
#include "station/console/customer_export.h"
#include "station/console/model_cache.h"
#include "station/console/request_keys.h"
#include "station/console/retention.h"
#include "station/console/route_errors.h"
#include "station/console/scan_json.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kNameBytes = 256;
constexpr std::size_t kNoteBytes = 4096;

Json ConsentToJson(const Consent& consent) {
  return {{"id", consent.id},
          {"purposes", consent.purposes},
          {"text_version", consent.text_version},
          {"language", consent.language},
          {"given_ms", consent.given.count()},
          {"withdrawn_ms", consent.withdrawn ? Json(consent.withdrawn->count()) : Json(nullptr)}};
}

Json CustomerToJson(Store& store, const Customer& customer) {
  const auto scans = store.ScansOf(customer.id);
  return {{"id", customer.id},
          {"name", customer.name},
          {"contact", customer.contact},
          {"note", customer.note},
          {"height_mm", customer.height_mm ? Json(*customer.height_mm) : Json(nullptr)},
          {"prescription",
           customer.prescription_json ? Json::parse(*customer.prescription_json, nullptr, false) : Json(nullptr)},
          {"created_ms", customer.created.count()},
          {"keep_until_ms", customer.keep_until.count()},
          {"scans", scans ? scans->size() : 0}};
}

/// A text of the body if it is there.
tl::expected<void, ApiError> TakeText(const nlohmann::json& body, const char* name, std::size_t most,
                                      std::string& into) {
  if (!body.contains(name)) return {};
  auto text = OptionalText(body, name, most);
  if (!text) return tl::unexpected(std::move(text.error()));
  into = text->value_or("");
  return {};
}

tl::expected<void, ApiError> TakePrescription(const nlohmann::json& body, Customer& customer) {
  if (!body.contains("prescription")) return {};
  const auto& given = body.at("prescription");
  customer.prescription_json.reset();
  if (given.is_null()) return {};
  const auto read = PrescriptionFromJson(given.dump(), "prescription");
  if (!read) return BadField("prescription", read.error().seen, read.error().advice);
  customer.prescription_json = PrescriptionToJson(*read);
  return {};
}

/// What the body says of a customer, on top of what is known.
tl::expected<Customer, ApiError> ReadCustomer(const nlohmann::json& body, Customer customer) {
  constexpr double kLowest = 300.0;
  constexpr double kHighest = 2500.0;
  if (const auto known = OnlyKeys(body, {"name", "contact", "note", "height_mm", "prescription"}); !known)
    return tl::unexpected(known.error());
  for (const auto& taken :
       {TakeText(body, "name", kNameBytes, customer.name), TakeText(body, "contact", kNameBytes, customer.contact),
        TakeText(body, "note", kNoteBytes, customer.note), TakePrescription(body, customer)}) {
    if (!taken) return tl::unexpected(taken.error());
  }
  if (customer.name.find_first_not_of(' ') == std::string::npos) {
    return BadField("name", "it is empty", "give a name, or a number that stands for one");
  }
  if (body.contains("height_mm")) {
    const auto height = OptionalNumber(body, "height_mm", kLowest, kHighest);
    if (!height) return tl::unexpected(height.error());
    customer.height_mm.reset();
    if (*height) customer.height_mm = static_cast<int>(std::lround(**height));
  }
  return customer;
}

ApiResult FindCustomers(ConsoleContext& context, const ApiRequest& request) {
  std::size_t limit = 50;
  if (const auto text = request.http.Query("limit")) {
    const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), limit);
    if (error != std::errc() || end != text->data() + text->size() || limit < 1 || limit > 500) {
      return BadField("limit", "it is no number of 1 … 500", "give one");
    }
  }
  const std::string_view search = request.http.Query("search").value_or("");
  if (search.size() > kNameBytes) return BadField("search", "it is too long", "give some letters of the name");
  const auto found = context.store.FindCustomers(search, limit);
  if (!found) return StoreAway(found.error());
  Json list = Json::array();
  for (const Customer& customer : *found) list.push_back(CustomerToJson(context.store, customer));
  return JsonAnswer({{"customers", std::move(list)}});
}

ApiResult AddCustomer(ConsoleContext& context, const ApiRequest& request) {
  auto customer = ReadCustomer(request.body, {});
  if (!customer) return tl::unexpected(std::move(customer.error()));
  const auto added = context.store.AddCustomer(std::move(*customer));
  if (!added) return StoreAway(added.error());
  return JsonAnswer(CustomerToJson(context.store, *added));
}

ApiResult GetCustomer(ConsoleContext& context, const ApiRequest& request) {
  const auto customer = context.store.GetCustomer(request.path.at("customer"));
  if (!customer) return NotThere(customer.error());
  const auto consents = context.store.Consents(customer->id);
  if (!consents) return StoreAway(consents.error());
  const auto scans = context.store.ScansOf(customer->id);
  if (!scans) return StoreAway(scans.error());
  Json json = CustomerToJson(context.store, *customer);
  json["consents"] = Json::array();
  for (const Consent& consent : *consents) json["consents"].push_back(ConsentToJson(consent));
  json["visits"] = Json::array();
  for (const ScanRow& scan : *scans) json["visits"].push_back(ScanToJson(context.store, scan, request.caller.role));
  return JsonAnswer(json);
}

ApiResult ChangeCustomer(ConsoleContext& context, const ApiRequest& request) {
  auto customer = context.store.GetCustomer(request.path.at("customer"));
  if (!customer) return NotThere(customer.error());
  auto changed = ReadCustomer(request.body, std::move(*customer));
  if (!changed) return tl::unexpected(std::move(changed.error()));
  if (const Status kept = context.store.ChangeCustomer(*changed); !kept) return StoreAway(kept.error());
  return JsonAnswer(CustomerToJson(context.store, *changed));
}

tl::expected<std::vector<std::string>, ApiError> ReadPurposes(const nlohmann::json& body) {
  const std::string advice = "give a list of \"measure\", \"glasses\", \"reshape\", \"research\"";
  if (!body.contains("purposes") || !body.at("purposes").is_array() || body.at("purposes").empty()) {
    return BadField("purposes", "it is missing, or no list, or empty", advice);
  }
  std::vector<std::string> purposes;
  for (const auto& one : body.at("purposes")) {
    const bool good = one.is_string() && IsConsentPurpose(one.get_ref<const std::string&>());
    if (!good || std::find(purposes.begin(), purposes.end(), one.get<std::string>()) != purposes.end()) {
      return BadField("purposes", "one is not known, or is there twice", advice);
    }
    purposes.push_back(one);
  }
  return purposes;
}

ApiResult AddConsent(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"purposes", "text_version", "language", "agreed"}); !known)
    return tl::unexpected(known.error());
  const auto customer = context.store.GetCustomer(request.path.at("customer"));
  if (!customer) return NotThere(customer.error());
  Consent consent;
  consent.customer_id = customer->id;
  consent.taken_by = request.caller.user;
  auto purposes = ReadPurposes(request.body);
  if (!purposes) return tl::unexpected(std::move(purposes.error()));
  consent.purposes = std::move(*purposes);
  const auto version = TextField(request.body, "text_version", 32);
  if (!version) return tl::unexpected(version.error());
  if (*version != ConsentTextVersion()) {
    return BadField("text_version", "it is not the wording that is in use", "show the present one, and ask again");
  }
  consent.text_version = *version;
  const auto language = TextField(request.body, "language", 8);
  if (!language) return tl::unexpected(language.error());
  if (*language != "en" && *language != "ja") return BadField("language", "it is not known", "give \"en\" or \"ja\"");
  consent.language = *language;
  const auto agreed = FlagField(request.body, "agreed");
  if (!agreed) return tl::unexpected(agreed.error());
  if (!*agreed) return BadField("agreed", "the customer has not agreed", "do not scan without consent");
  const auto added = context.store.AddConsent(std::move(consent));
  if (!added) return StoreAway(added.error());
  return JsonAnswer(ConsentToJson(*added));
}

ApiResult WithdrawConsent(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  if (const Status withdrawn = context.store.WithdrawConsent(request.path.at("consent")); !withdrawn) {
    return NotThere(withdrawn.error());
  }
  return JsonAnswer(Json::object());
}

ApiResult EraseCustomer(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"confirm"}); !known) return tl::unexpected(known.error());
  const std::string& id = request.path.at("customer");
  const auto confirm = TextField(request.body, "confirm", 64);
  if (!confirm) return tl::unexpected(confirm.error());
  if (*confirm != id) return BadField("confirm", "it is not the customer's id", "give " + id);
  if (const auto customer = context.store.GetCustomer(id); !customer) return NotThere(customer.error());
  context.models.DropAll();
  const auto proof = context.store.Erase(id);
  if (!proof) return StoreAway(proof.error());
  return JsonAnswer({{"customer_id", proof->customer_id},
                     {"files", proof->files},
                     {"rows", proof->rows},
                     {"key_destroyed", proof->key_destroyed},
                     {"bytes_searched", proof->bytes_searched},
                     {"marker_hits", proof->marker_hits}});
}

ApiResult ExportCustomer(ConsoleContext& context, const ApiRequest& request) {
  const auto customer = context.store.GetCustomer(request.path.at("customer"));
  if (!customer) return NotThere(customer.error());
  const Json known = CustomerToJson(context.store, *customer);
  auto zip = ExportOfCustomer(context.store, *customer, known, context.clock.WallNow());
  if (!zip) return StoreAway(zip.error());
  HttpResponse answer{200, "application/zip", {}, std::move(*zip)};
  answer.headers.emplace_back("Content-Disposition", "attachment; filename=\"" + customer->id + ".zip\"");
  return answer;
}

ApiResult GetConsentText(ConsoleContext& context, const ApiRequest& request) {
  const ConsentText text =
      ConsentTextIn(LanguageOf(LanguageName(request.http)), RetentionDays(context.store, context.config.store));
  Json purposes = Json::array();
  for (const ConsentPurpose& purpose : text.purposes) purposes.push_back({{"id", purpose.id}, {"text", purpose.text}});
  return JsonAnswer({{"version", text.version},
                     {"language", text.language},
                     {"title", text.title},
                     {"paragraphs", text.paragraphs},
                     {"purposes", std::move(purposes)}});
}

}  // namespace

void AddCustomerRoutes(RouteTable& table, ConsoleContext& context) {
  constexpr RouteRoles kOperatorsAdmins{false, true, false, true};
  const auto add = [&](const char* method, const char* pattern, RouteRoles roles, const char* audit,
                       const char* subject, ApiResult (*answer)(ConsoleContext&, const ApiRequest&)) {
    table.Add({method, pattern, roles, false, audit, subject,
               [&context, answer](const ApiRequest& request) { return answer(context, request); }});
  };
  add("GET", "/api/customers", kOperators, "", "", FindCustomers);
  add("POST", "/api/customers", kOperators, "customer_add", "", AddCustomer);
  add("GET", "/api/customers/{customer}", kOperators, "", "", GetCustomer);
  add("POST", "/api/customers/{customer}", kOperators, "customer_change", "customer", ChangeCustomer);
  add("POST", "/api/customers/{customer}/consents", kOperators, "consent", "customer", AddConsent);
  add("POST", "/api/consents/{consent}/withdraw", kOperators, "consent_withdraw", "consent", WithdrawConsent);
  add("POST", "/api/customers/{customer}/erase", kOperatorsAdmins, "erase", "customer", EraseCustomer);
  add("GET", "/api/customers/{customer}/export", kOperatorsAdmins, "export", "customer", ExportCustomer);
  add("GET", "/api/consent-text", kOperators, "", "", GetConsentText);
}

}  // namespace annulus
