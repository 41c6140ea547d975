#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/console/console_context.h"
#include "station/console/glasses_catalogue.h"
#include "station/console/glasses_colour.h"
#include "station/console/glasses_designs.h"
#include "station/console/glasses_jobs.h"
#include "station/console/glasses_preview.h"
#include "station/console/glasses_request.h"
#include "station/console/mesh_bytes.h"
#include "station/console/model_cache.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"

namespace annulus {
namespace {

ApiResult Preview(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"design", "look", "placement", "free_size"}); !known) {
    return tl::unexpected(known.error());
  }
  auto composed = ComposedIn(request.body);
  if (!composed) return tl::unexpected(composed.error());
  const auto look = LookIn(request.body);
  if (!look) return tl::unexpected(look.error());
  const auto placement = WordOr(request.body, "placement", "quick", {"quick", "paper"});
  if (!placement) return tl::unexpected(placement.error());
  const auto free = FlagOr(request.body, "free_size", false);
  if (!free) return tl::unexpected(free.error());
  const auto model = context.models.Open(request.path.at("scan"));
  if (!model) return Refuse(404, model);
  const auto wearer = (*model)->wearer->Get((*model)->loaded.body, (*model)->landmarks);
  if (!wearer) return Refuse(409, wearer);
  PreviewRequest wanted{std::move(*composed), *look};
  if (*placement == "paper") wanted.placement = PreviewPlacement::kPaper;
  if (*free) wanted.size = FitSize::kMadeToMeasure;
  auto preview = PreviewGlasses(**wearer, wanted);
  if (!preview) return Refuse(409, preview);
  // Only ASCII may stand in a header.
  const std::string notes = preview->notes.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
  return HttpResponse{200, kMeshType, {{"X-Annulus-Notes", notes}}, std::move(preview->mesh)};
}

}  // namespace

void AddGlassesRoutes(RouteTable& table, ConsoleContext& context) {
  // Shared: the handlers live as long as the table, which outlives this call.
  const auto jobs = std::make_shared<GlassesJobs>(context);
  const auto add = [&table](const char* method, const char* pattern, const char* audit, const char* subject,
                            std::function<ApiResult(const ApiRequest&)> handle) {
    table.Add({method, pattern, kOperators, false, audit, subject, std::move(handle)});
  };
  add("GET", "/api/glasses/catalogue", "", "",
      [](const ApiRequest&) -> ApiResult { return JsonAnswer(GlassesCatalogue(BuiltInFrameLibrary())); });
  // Reads only, thirty times a second while a slider moves: not in the audit.
  add("POST", "/api/scans/{scan}/glasses/preview", "", "",
      [&context](const ApiRequest& request) { return Preview(context, request); });
  add("POST", "/api/scans/{scan}/glasses/fit", "glasses_fit", "scan",
      [jobs](const ApiRequest& request) { return jobs->Fit(request); });
  add("POST", "/api/scans/{scan}/glasses/rank", "glasses_rank", "scan",
      [jobs](const ApiRequest& request) { return jobs->Rank(request); });
  add("POST", "/api/scans/{scan}/glasses/picture", "glasses_picture", "scan",
      [jobs](const ApiRequest& request) { return jobs->Picture(request); });
  add("GET", "/api/jobs/{job}/picture", "", "",
      [jobs](const ApiRequest& request) { return jobs->PictureSoFar(request); });
  add("POST", "/api/scans/{scan}/glasses/export", "glasses_export", "scan",
      [jobs](const ApiRequest& request) { return jobs->Export(request); });
  add("GET", "/api/scans/{scan}/designs", "", "",
      [&context](const ApiRequest& request) { return ListDesigns(context, request); });
  add("POST", "/api/scans/{scan}/designs", "design_add", "scan",
      [&context](const ApiRequest& request) { return AddDesign(context, request); });
  add("POST", "/api/designs/{design}", "design_change", "design",
      [&context](const ApiRequest& request) { return ChangeDesign(context, request); });
  add("POST", "/api/designs/{design}/remove", "design_remove", "design",
      [&context](const ApiRequest& request) { return RemoveDesign(context, request); });
  add("POST", "/api/colour", "", "", ColourAnswer);
}

}  // namespace annulus
