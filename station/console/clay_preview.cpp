#include "station/console/clay_preview.h"

#include <fmt/format.h>

#include <utility>

#include "modeling/clay/clay_convert.h"
#include "modeling/clay/clay_girths.h"
#include "modeling/clay/clay_tessellate.h"
#include "station/console/mesh_bytes.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

Json GirthsJson(const ClayGirths& girths) {
  Json list = Json::array();
  for (std::size_t k = 0; k < girths.levels().size(); ++k) {
    list.push_back({{"z_mm", girths.levels()[k]}, {"perimeter_mm", girths.Perimeter(k)}, {"tape_mm", girths.Tape(k)}});
  }
  return list;
}

}  // namespace

Result<std::shared_ptr<const ClayBody>> ClaySlot::Get(const SurfaceSegment& segment) {
  const std::lock_guard lock(mutex_);
  if (!body_) {
    auto made = ClayFromSurface(segment);
    if (!made) return Fail(made);
    body_ = std::make_shared<const ClayBody>(std::move(made->body));
  }
  return body_;
}

Result<ClayPreview> PreviewClay(const ClayBody& body, const ClayScript& script, const std::vector<double>& girths) {
  ClayBody shaped = body;
  ClayGirths followed(shaped, girths);
  Json operations = Json::array();
  for (std::size_t n = 0; n < script.steps.size(); ++n) {
    const auto report = Perform(shaped, script.steps[n], script.practice);
    if (!report) {
      Error error = report.error();
      error.attempted = fmt::format("operation {}", n);
      return tl::unexpected<Error>(std::move(error));
    }
    followed.Follow(shaped);
    operations.push_back({{"volume_before_mm3", report->volume_before_mm3},
                          {"volume_after_mm3", report->volume_after_mm3},
                          {"moved_mm3", report->moved_mm3},
                          {"girths", GirthsJson(followed)}});
  }
  MeshPart part;
  part.mesh = Tessellate(shaped.mesh(), 1);
  ClayPreview preview;
  preview.mesh = MeshBytes({part});
  preview.notes = {{"volume_mm3", shaped.volume()},
                   {"area_mm2", shaped.Area()},
                   {"patches", shaped.mesh().leaf_count()},
                   {"girths", GirthsJson(followed)},
                   {"operations", std::move(operations)}};
  return preview;
}

}  // namespace annulus
