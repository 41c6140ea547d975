#include "station/console/scan_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/store/store.h"

namespace annulus {

using Json = nlohmann::ordered_json;

Json SummaryOf(const ScanRow& scan) {
  Json summary = Json::parse(scan.summary_json, nullptr, false);
  return summary.is_object() ? summary : Json::object();
}

Json ScanToJson(Store& store, const ScanRow& scan, StationRole who) {
  const auto artefacts = store.ArtefactsOf(scan.id);
  const bool model = artefacts && std::any_of(artefacts->begin(), artefacts->end(),
                                              [](const Artefact& one) { return one.kind == "model"; });
  Json json{{"id", scan.id}};
  if (who == StationRole::kOperator) {
    json["customer_id"] = scan.customer_id;
    json["consent_id"] = scan.consent_id;
  }
  json["profile"] = scan.profile;
  json["taken_ms"] = scan.taken.count();
  json["verdict"] = scan.verdict;
  json["recording_missing"] = scan.recording_missing;
  json["model"] = model;
  json["summary"] = SummaryOf(scan);
  json["summary"].erase("ticket");
  return json;
}

Result<Artefact> NewestArtefact(Store& store, const std::string& scan_id, std::string_view kind) {
  const auto artefacts = store.ArtefactsOf(scan_id);
  if (!artefacts) return Fail(artefacts);
  const Artefact* newest = nullptr;
  for (const Artefact& artefact : *artefacts) {
    if (artefact.kind == kind && (newest == nullptr || artefact.made >= newest->made)) newest = &artefact;
  }
  if (newest != nullptr) return *newest;
  return Fail("find the " + std::string(kind) + " of " + scan_id, "there is none",
              kind == "model" ? "wait until the scan is fitted, or fit it" : "make it first");
}

Json ArtefactJson(const Artefact& artefact) {
  return {{"id", artefact.id},
          {"kind", artefact.kind},
          {"name", artefact.name},
          {"derived", artefact.derived},
          {"made_ms", artefact.made.count()},
          {"bytes", artefact.bytes}};
}

}  // namespace annulus
