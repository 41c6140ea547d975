#include "station/console/scan_documents.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "modeling/mesh/mesh_io.h"
#include "modeling/mesh/tessellate.h"
#include "station/console/booth_words.h"
#include "station/console/job_folder.h"
#include "station/console/model_cache.h"
#include "station/console/route_errors.h"
#include "station/console/scan_json.h"
#include "station/measurement_files.h"
#include "station/store/store.h"

namespace annulus {
namespace {

struct DocumentKind {
  std::string_view name;
  const char* ending;
  const char* media_type;
};
/// Those that are made of the table of measurements, by the ending of their file.
constexpr std::array<DocumentKind, 6> kOfTable{{{"sheet", ".pdf", "application/pdf"},
                                                {"csv", ".csv", "text/csv; charset=utf-8"},
                                                {"json", ".json", "application/json"},
                                                {"smis", ".smis", "application/xml"},
                                                {"vit", ".vit", "application/xml"},
                                                {"freesewing", ".freesewing.json", "application/json"}}};

HttpResponse FileAnswer(std::string name, const char* media_type, std::string body) {
  HttpResponse answer{200, media_type, {}, std::move(body)};
  answer.headers.emplace_back("Content-Disposition", "attachment; filename=\"" + std::move(name) + "\"");
  return answer;
}

std::string AsText(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The page asks for it by a link, so that only the query can say how it is to be read.
tl::expected<SheetOptions, ApiError> ReadSheetOptions(ConsoleContext& context, const ScanRow& scan,
                                                      const HttpRequest& http) {
  SheetOptions options;
  options.language = LanguageOf(LanguageName(http));
  const auto unit = LengthUnitFromName(http.Query("units").value_or("mm"));
  if (!unit) return BadField("units", "it is not known", "give mm, cm or inch");
  options.unit = *unit;
  const auto customer = context.store.GetCustomer(scan.customer_id);
  if (!customer) return StoreAway(customer.error());
  options.subject = customer->name;
  return options;
}

/// FreeSewing draws clothes: of a head alone there are two numbers that no pattern of its can be drawn with.
bool HasTrunk(const MeasurementTable& table) {
  return std::any_of(table.measurements.begin(), table.measurements.end(), [](const Measurement& one) {
    return one.id == "chest_girth" || one.id == "waist_girth" || one.id == "hip_girth";
  });
}

ApiResult TableDocument(ConsoleContext& context, const ScanRow& scan, const ApiRequest& request,
                        const DocumentKind& kind) {
  const auto options = ReadSheetOptions(context, scan, request.http);
  if (!options) return tl::unexpected(options.error());
  const auto open = context.models.Open(scan.id);
  if (!open) return NotThere(open.error());
  const auto table = MeasureTable((*open)->loaded.body, (*open)->landmarks);
  if (!table) return Refuse(409, table.error());
  if (kind.name == "freesewing" && !HasTrunk(*table)) {
    return Refuse(409, {"write measurements for FreeSewing", "the scan has none of chest, waist or hip",
                        "scan with the profile body or torso"});
  }
  auto folder = JobFolder::Make(context);
  if (!folder) return StoreAway(folder.error());
  const std::string name = scan.id + kind.ending;
  const auto written =
      WriteMeasurements(context.storage, folder->File(name), {*table, *(*open)->loaded.model}, *options);
  if (!written) return Refuse(409, written.error());
  auto bytes = context.storage.ReadAll(folder->File(name), kMaxInputBytes);
  if (!bytes) return StoreAway(bytes.error());
  return FileAnswer(name, kind.media_type, AsText(*bytes));
}

ApiResult StlDocument(ConsoleContext& context, const ScanRow& scan) {
  const auto open = context.models.Open(scan.id);
  if (!open) return NotThere(open.error());
  TessellationOptions options;
  options.max_z_spacing_mm = 2.0;
  options.ends = EndClosure::kBoth;
  TriangleMesh mesh;
  for (const SurfaceSegment& segment : (*open)->loaded.model->segments) {
    Append(mesh, TessellateSurface(segment, options));
  }
  return FileAnswer(scan.id + ".stl", "model/stl", WriteStl(mesh, "annulus " + scan.id));
}

ApiResult ModelDocument(ConsoleContext& context, const ScanRow& scan) {
  const auto artefact = NewestArtefact(context.store, scan.id, "model");
  if (!artefact) return NotThere(artefact.error());
  const auto bytes = context.store.ReadArtefact(artefact->id);
  if (!bytes) return StoreAway(bytes.error());
  return FileAnswer(scan.id + "-model.json", "application/json", AsText(*bytes));
}

ApiResult RecordingDocument(ConsoleContext& context, const ScanRow& scan) {
  if (scan.recording_missing) {
    return Refuse(404, {"read the recording of " + scan.id, "its file is not there", "restore a backup of the store"});
  }
  const auto bytes = context.store.ReadRecording(scan.id);
  if (!bytes) return StoreAway(bytes.error());
  return FileAnswer(scan.id + ".mcap", "application/octet-stream", AsText(*bytes));
}

}  // namespace

ApiResult ScanDocument(ConsoleContext& context, const ApiRequest& request) {
  const std::string_view kind = request.http.Query("kind").value_or("");
  const auto of_table =
      std::find_if(kOfTable.begin(), kOfTable.end(), [&](const DocumentKind& one) { return one.name == kind; });
  if (of_table == kOfTable.end() && kind != "recording" && kind != "model" && kind != "stl") {
    return BadField("kind", "there is no such document",
                    "give sheet, csv, json, smis, vit, freesewing, model, stl or recording");
  }
  // What is a customer's goes to who serves customers; raw readings to who mends the booth.
  const bool of_operator = request.caller.role == StationRole::kOperator;
  if (of_operator == (kind == "recording")) {
    return Refuse(403, {"give out a document", "your role may not have this kind", "ask somebody who may"});
  }
  const auto scan = context.store.GetScan(request.path.at("scan"));
  if (!scan) return NotThere(scan.error());
  if (kind == "recording") return RecordingDocument(context, *scan);
  if (kind == "model") return ModelDocument(context, *scan);
  if (kind == "stl") return StlDocument(context, *scan);
  return TableDocument(context, *scan, request, *of_table);
}

}  // namespace annulus
