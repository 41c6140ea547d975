/// The model reader. Beyond "no crash": what is accepted is finite, is written and read back to the same bytes, and
/// can be measured or refused.
#include <cmath>
#include <cstdint>
#include <span>

#include "base/ensure.h"
#include "base/frames.h"
#include "modeling/exchange/model_json.h"
#include "modeling/measure/section.h"

namespace {

using namespace annulus;

void CheckAccepted(const SurfaceModel& model) {
  for (const SurfaceSegment& segment : model.segments) {
    ENSURE(segment.surface.coefficients().allFinite(), "coefficients are finite");
    ENSURE(segment.surface.z_min() < segment.surface.z_max(), "a surface has a height");
    ENSURE(segment.knowledge.columns() >= 1 && segment.knowledge.rows() >= 1, "a map has cells");
  }
  const auto body = MeasuredSurface::FromModel(model);
  if (!body) return;
  const double z = 0.5 * (body->surface().z_min() + body->surface().z_max());
  (void)body->KnowledgeAt(1.0, z);
  (void)body->RadiusSigma(1.0, z);
  ENSURE(std::isfinite(body->Radius(1.0, z)), "radii are finite");
  if (model.main().paper == nullptr) return;
  const Eigen::Vector3d point = body->Point(1.0, z);
  ENSURE(std::abs(AngleDifference(std::atan2(point.y(), point.x()), 1.0)) < 1e-9, "u is solved for theta");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto model = ModelFromJson(text, "fuzz");
  if (!model) {
    ENSURE(model.error().Text().find('\n') == std::string::npos, "a message is one line");
    return 0;
  }
  CheckAccepted(*model);
  const std::string written = ModelToJson(*model);
  const auto again = ModelFromJson(written, "written");
  ENSURE(again.has_value(), again ? "" : again.error().Text());
  ENSURE(ModelToJson(*again) == written, "a model reads back as the same bytes");
  return 0;
}
