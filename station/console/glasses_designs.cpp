#include "station/console/glasses_designs.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "station/console/glasses_request.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"
#include "station/look_file.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kKind = "design";
constexpr std::size_t kLongestTitle = 120;

/// A design as the page knows it, from what is in the store.
Json DesignAnswer(const Artefact& artefact, const Json& kept) {
  Json answer{{"id", artefact.id}, {"title", artefact.name}};
  for (const char* key : {"design", "look", "prescription", "worn"}) answer[key] = kept.value(key, Json());
  answer["made_ms"] = artefact.made.count();
  return answer;
}

Result<Json> ReadDesign(Store& store, const Artefact& artefact) {
  const auto bytes = store.ReadArtefact(artefact.id);
  if (!bytes) return Fail(bytes);
  const auto* const text = reinterpret_cast<const char*>(bytes->data());
  Json kept = Json::parse(text, text + bytes->size(), nullptr, false);
  if (kept.is_object()) return kept;
  return Fail("read design " + artefact.id, "it is damaged", "remove it, and make it again");
}

/// What of design, look, prescription and worn the body names, checked, into `kept`.
tl::expected<void, ApiError> TakeParts(ConsoleContext& context, const nlohmann::json& body, const std::string& scan_id,
                                       Json& kept) {
  if (body.contains("design")) {
    if (const auto composed = ComposedIn(body); !composed) return tl::unexpected(composed.error());
    kept["design"] = body.at("design");
  }
  if (body.contains("look")) {
    const auto look = LookIn(body);
    if (!look) return tl::unexpected(look.error());
    kept["look"] = Json::parse(LookToJson(*look));
  }
  if (body.contains("prescription")) {
    const auto order = PrescriptionIn(body);
    if (!order) return tl::unexpected(order.error());
    kept["prescription"] = *order ? Json::parse(**order) : Json();
  }
  if (!body.contains("worn")) return {};
  const auto worn = OptionalText(body, "worn", 64);
  if (!worn) return tl::unexpected(worn.error());
  kept["worn"] = *worn ? Json(**worn) : Json();
  if (!*worn) return {};
  const auto artefact = context.store.GetArtefact(**worn);
  if (artefact && artefact->scan_id == scan_id && artefact->kind == "worn") return {};
  return BadField("worn", "there are no such glasses of this scan", "fit them first");
}

tl::expected<void, ApiError> TitleIsFree(ConsoleContext& context, const std::string& scan_id,
                                         const std::string& title) {
  const auto artefacts = context.store.ArtefactsOf(scan_id);
  if (!artefacts) return Refuse(503, artefacts);
  for (const Artefact& artefact : *artefacts) {
    if (artefact.kind != kKind || artefact.name != title) continue;
    return Refuse(409, {"keep a design", "there is one of this title already", "give it another title"});
  }
  return {};
}

ApiResult Keep(ConsoleContext& context, Artefact artefact, const Json& kept) {
  const std::string text = kept.dump(-1, ' ', false, Json::error_handler_t::replace);
  const auto stored = context.store.PutArtefact(std::move(artefact), std::as_bytes(std::span(text)));
  if (!stored) return Refuse(503, stored);
  return JsonAnswer(DesignAnswer(*stored, kept));
}

tl::expected<Artefact, ApiError> FindDesign(ConsoleContext& context, const std::string& id) {
  auto artefact = context.store.GetArtefact(id);
  if (artefact && artefact->kind == kKind) return std::move(*artefact);
  return Refuse(404, {"find design " + id, "there is none", "look at the scan's designs"});
}

}  // namespace

ApiResult ListDesigns(ConsoleContext& context, const ApiRequest& request) {
  const std::string& scan_id = request.path.at("scan");
  if (const auto scan = context.store.GetScan(scan_id); !scan) return Refuse(404, scan);
  const auto artefacts = context.store.ArtefactsOf(scan_id);
  if (!artefacts) return Refuse(503, artefacts);
  Json designs = Json::array();
  for (const Artefact& artefact : *artefacts) {
    if (artefact.kind != kKind) continue;
    const auto kept = ReadDesign(context.store, artefact);
    if (!kept) return Refuse(503, kept);
    designs.push_back(DesignAnswer(artefact, *kept));
  }
  return JsonAnswer({{"designs", designs}});
}

ApiResult AddDesign(ConsoleContext& context, const ApiRequest& request) {
  const std::string& scan_id = request.path.at("scan");
  const auto& body = request.body;
  if (const auto known = OnlyKeys(body, {"title", "design", "look", "prescription", "worn"}); !known) {
    return tl::unexpected(known.error());
  }
  const auto title = TextField(body, "title", kLongestTitle);
  if (!title) return tl::unexpected(title.error());
  if (title->empty()) return BadField("title", "it is empty", "give it a name");
  const auto scan = context.store.GetScan(scan_id);
  if (!scan) return Refuse(404, scan);
  if (const auto composed = ComposedIn(body); !composed) return tl::unexpected(composed.error());
  Json kept{{"look", Json::parse(LookToJson({}))}};
  if (const auto taken = TakeParts(context, body, scan_id, kept); !taken) return tl::unexpected(taken.error());
  if (const auto free = TitleIsFree(context, scan_id, *title); !free) return tl::unexpected(free.error());
  Artefact artefact;
  artefact.scan_id = scan_id;
  artefact.customer_id = scan->customer_id;
  artefact.kind = kKind;
  artefact.name = *title;
  artefact.derived = false;
  return Keep(context, std::move(artefact), kept);
}

ApiResult ChangeDesign(ConsoleContext& context, const ApiRequest& request) {
  const auto& body = request.body;
  if (const auto known = OnlyKeys(body, {"title", "design", "look", "prescription", "worn"}); !known) {
    return tl::unexpected(known.error());
  }
  const auto title = OptionalText(body, "title", kLongestTitle);
  if (!title) return tl::unexpected(title.error());
  if (*title && (*title)->empty()) return BadField("title", "it is empty", "give it a name");
  auto artefact = FindDesign(context, request.path.at("design"));
  if (!artefact) return tl::unexpected(artefact.error());
  auto kept = ReadDesign(context.store, *artefact);
  if (!kept) return Refuse(503, kept);
  if (const auto taken = TakeParts(context, body, artefact->scan_id, *kept); !taken) {
    return tl::unexpected(taken.error());
  }
  const std::string old_id = artefact->id;
  const bool renamed = *title && **title != artefact->name;
  if (renamed) {
    const auto free = TitleIsFree(context, artefact->scan_id, **title);
    if (!free) return tl::unexpected(free.error());
    artefact->name = **title;
    artefact->id.clear();
  }
  auto answer = Keep(context, std::move(*artefact), *kept);
  if (!answer || !renamed) return answer;
  // Only now: a design is never without a copy.
  if (const Status removed = context.store.RemoveArtefact(old_id); !removed) return Refuse(503, removed);
  return answer;
}

ApiResult RemoveDesign(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  const auto artefact = FindDesign(context, request.path.at("design"));
  if (!artefact) return tl::unexpected(artefact.error());
  if (const Status removed = context.store.RemoveArtefact(artefact->id); !removed) return Refuse(503, removed);
  return JsonAnswer(Json::object());
}

}  // namespace annulus
