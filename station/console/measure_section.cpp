#include "station/console/measure_section.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/units.h"
#include "modeling/measure/plane_cut.h"
#include "modeling/measure/section.h"
#include "modeling/measure/taut_tape.h"
#include "modeling/mesh/convex_hull_2d.h"
#include "station/console/measure_places.h"
#include "station/measurement_output.h"
#include "station/section_output.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kOutlinePoints = 360;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::vector<Eigen::Vector3d> AtHeight(const std::vector<Eigen::Vector2d>& points, double z) {
  std::vector<Eigen::Vector3d> lifted;
  for (const Eigen::Vector2d& p : points) lifted.emplace_back(p.x(), p.y(), z);
  return lifted;
}

/// Outlines of what stands beside the trunk at a height: arms, legs.
void AddLimbs(Json& loops, const SurfaceModel& model, double z) {
  for (std::size_t k = 1; k < model.segments.size(); ++k) {
    const SurfaceSegment& limb = model.segments[k];
    if (z < limb.surface.z_min() || z > limb.surface.z_max()) continue;
    std::vector<Eigen::Vector3d> outline;
    for (std::size_t i = 0; i < kOutlinePoints / 2; ++i) {
      const double theta = kTwoPi * static_cast<double>(i) / (kOutlinePoints / 2);
      if (limb.knowledge.At(theta, z) != Knowledge::kUnknown) outline.push_back(limb.Point(theta, z));
    }
    if (outline.size() > 2) loops.push_back(PointsJson(outline));
  }
}

Result<Json> AnswerLevel(const LoadedModel& loaded, double z) {
  const auto section = MeasureSection(loaded.body, z);
  if (!section) return Fail(section);
  const auto outline = SectionCurve(loaded.body, z, kOutlinePoints);
  if (!outline) return Fail(outline);
  const auto taut = TautLoop(loaded.body, z);  // beside what was not seen there is none
  const Uncertain tape = taut ? loaded.body.WithSigma(taut->length) : Uncertain{kNone, kNone};
  Json loops = Json::array({PointsJson(AtHeight(*outline, z))});
  AddLimbs(loops, *loaded.model, z);
  Json answer = SectionToJson(*loaded.model, *section, tape);
  answer["loops"] = std::move(loops);
  answer["tape"] = PointsJson(AtHeight(ConvexHull(*outline), z));
  return answer;
}

Result<Json> AnswerTilted(const LoadedModel& loaded, const SectionQuestion& question) {
  const Eigen::Vector3d normal = Eigen::Vector3d(std::tan(RadiansFromDegrees(question.lean_deg)),
                                                 std::tan(RadiansFromDegrees(question.tilt_deg)), 1.0)
                                     .normalized();
  const auto girth = GirthInPlane(loaded.body, {normal, normal.z() * question.z_mm});
  if (!girth) return Fail(girth);
  const std::vector<Uncertain> numbers = loaded.body.WithSigmas({girth->perimeter, girth->tape, girth->area});
  return Json{{"z_mm", question.z_mm},
              {"tilt_deg", question.tilt_deg},
              {"lean_deg", question.lean_deg},
              {"perimeter_mm", numbers[0].value},
              {"tape_mm", numbers[1].value},
              {"area_mm2", numbers[2].value},
              {"perimeter_sigma_mm", JsonNumber(numbers[0].sigma)},
              {"tape_sigma_mm", JsonNumber(numbers[1].sigma)},
              {"area_sigma_mm2", JsonNumber(numbers[2].sigma)},
              {"measured_share", girth->knowledge.measured},
              {"loops", Json::array({PathJson(girth->loop)})},
              {"tape", PathJson(girth->tape_path)}};
}

}  // namespace

Result<Json> AnswerSection(const LoadedModel& loaded, const SectionQuestion& question) {
  const bool level = question.tilt_deg == 0.0 && question.lean_deg == 0.0;
  return level ? AnswerLevel(loaded, question.z_mm) : AnswerTilted(loaded, question);
}

}  // namespace annulus
