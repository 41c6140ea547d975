#include "station/console/customer_export.h"

#include <nlohmann/json.hpp>

#include "station/console/scan_json.h"
#include "station/console/zip_writer.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

std::string_view AsText(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A title that a person has typed, as part of a file's name.
std::string FileName(const std::string& title) {
  std::string name;
  for (const char c : title) {
    const auto byte = static_cast<unsigned char>(c);
    name += byte < 0x20 || c == '/' || c == '\\' || c == ':' || byte == 0x7F ? '_' : c;
  }
  return name;
}

Status AddArtefacts(ZipWriter& zip, Store& store, const ScanRow& scan, const std::string& folder) {
  const auto artefacts = store.ArtefactsOf(scan.id);
  if (!artefacts) return Fail(artefacts);
  for (const Artefact& artefact : *artefacts) {
    const auto bytes = store.ReadArtefact(artefact.id);
    if (!bytes) return Fail(bytes);
    const std::string name = artefact.kind + "-" + artefact.id + "-" + FileName(artefact.name);
    RETURN_IF_ERROR(zip.Add(folder + name, AsText(*bytes)));
  }
  return {};
}

Status AddScan(ZipWriter& zip, Store& store, const ScanRow& scan) {
  const std::string folder = "scans/" + scan.id + "/";
  Json json = ScanToJson(store, scan, StationRole::kOperator);
  if (!scan.recording.empty() && !scan.recording_missing) {
    const auto recording = store.ReadRecording(scan.id);
    if (!recording) return Fail(recording);
    RETURN_IF_ERROR(zip.Add(folder + "recording.mcap", AsText(*recording)));
  }
  RETURN_IF_ERROR(zip.Add(folder + "scan.json", json.dump(1) + "\n"));
  return AddArtefacts(zip, store, scan, folder);
}

}  // namespace

Result<std::string> ExportOfCustomer(Store& store, const Customer& customer, const Json& known,
                                     std::chrono::nanoseconds wall) {
  ZipWriter zip{
      std::chrono::system_clock::time_point(std::chrono::duration_cast<std::chrono::system_clock::duration>(wall))};
  RETURN_IF_ERROR(zip.Add("customer.json", known.dump(1) + "\n"));
  const auto consents = store.Consents(customer.id);
  if (!consents) return Fail(consents);
  Json list = Json::array();
  for (const Consent& consent : *consents) {
    list.push_back({{"id", consent.id},
                    {"purposes", consent.purposes},
                    {"text_version", consent.text_version},
                    {"language", consent.language},
                    {"taken_by", consent.taken_by},
                    {"given_ms", consent.given.count()},
                    {"withdrawn_ms", consent.withdrawn ? Json(consent.withdrawn->count()) : Json(nullptr)}});
  }
  RETURN_IF_ERROR(zip.Add("consents.json", list.dump(1) + "\n"));
  const auto scans = store.ScansOf(customer.id);
  if (!scans) return Fail(scans);
  for (const ScanRow& scan : *scans) RETURN_IF_ERROR(AddScan(zip, store, scan));
  return zip.Finish();
}

}  // namespace annulus
