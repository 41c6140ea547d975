#include "station/sim_subject.h"

#include <utility>

#include "base/ensure.h"
#include "sim/dressed_subject.h"
#include "sim/head.h"
#include "sim/mesh_subject.h"
#include "sim/moving_subject.h"
#include "sim/person.h"

namespace annulus {
namespace {

/// A dark patch where a horizontal beam from `theta_deg` at `share` of the height first meets the subject.
std::optional<sim::DarkPatch> PatchOn(const sim::Subject& subject, double theta_deg, double share) {
  constexpr double kFar = 5000.0;
  const double theta = RadiansFromDegrees(theta_deg);
  const double z = subject.bottom_mm() + share * (subject.top_mm() - subject.bottom_mm());
  const Eigen::Vector3d outward = PointFromCylindrical(theta, 1.0, 0.0);
  const Ray ray{kFar * outward + Eigen::Vector3d(0.0, 0.0, z), -outward};
  const auto hit = subject.Cast(ray, 0.0, kFar);
  if (!hit) return std::nullopt;
  sim::DarkPatch patch;
  patch.centre = ray.origin + hit->distance_mm * ray.direction;
  return patch;
}

sim::Hair HairOf(const sim::Subject& subject, const sim::Placement& placement) {
  sim::Hair hair;
  hair.front_edge_mm = subject.top_mm() - 60.0;
  hair.back_edge_mm = subject.top_mm() - 200.0;
  hair.axis_x_mm = placement.x_mm;
  hair.axis_y_mm = placement.y_mm;
  return hair;
}

}  // namespace

bool IsBuiltInSubject(const std::string& subject) { return subject == "body" || subject == "head"; }

sim::ParametricBody BareSubject(const std::string& subject) {
  ENSURE(IsBuiltInSubject(subject), "a built-in subject");
  return subject == "body" ? sim::MakePerson({}) : sim::MakeHead({});
}

Result<std::unique_ptr<sim::Subject>> MakeSimSubject(const SimConfig& config, Storage& storage) {
  std::unique_ptr<sim::Subject> subject;
  sim::Placement placement;
  sim::Dress dress;
  if (IsBuiltInSubject(config.subject)) {
    auto body = std::make_unique<sim::ParametricBody>(BareSubject(config.subject));
    placement = body->placement();
    if (config.spectacles) dress.spectacles.emplace().face = body->face();
    subject = std::move(body);
  } else {
    if (config.spectacles) {
      return Fail("put spectacles on " + config.subject, "the face of a mesh file is not known",
                  "leave sim.spectacles out, or choose the subject body or head");
    }
    sim::MeshPlacement mesh;
    mesh.up = config.subject_y_up ? sim::UpAxis::kY : sim::UpAxis::kZ;
    mesh.scale = config.subject_scale;
    mesh.bottom_mm = 0.0;
    auto loaded = sim::MeshSubject::Load(storage, config.subject, mesh);
    if (!loaded) return Fail(loaded);
    subject = std::make_unique<sim::MeshSubject>(std::move(*loaded));
  }
  if (config.hair) dress.hair = HairOf(*subject, placement);
  if (config.dark_patches) {
    for (const auto& [theta_deg, share] : {std::pair{60.0, 0.65}, std::pair{250.0, 0.55}}) {
      if (const auto patch = PatchOn(*subject, theta_deg, share)) dress.dark_patches.push_back(*patch);
    }
  }
  if (dress.hair || dress.spectacles || !dress.dark_patches.empty()) {
    subject = std::make_unique<sim::DressedSubject>(std::move(subject), std::move(dress));
  }
  if (config.sway > 0.0 || config.breathing > 0.0) {
    sim::MotionOptions motion;
    motion.sway_scale = config.sway;
    motion.breathing_share = config.breathing;
    motion.breathing_height_mm = 0.735 * subject->top_mm();  // chest level of a standing person
    motion.seed = config.seed;
    subject = std::make_unique<sim::MovingSubject>(std::move(subject), motion);
  }
  return subject;
}

}  // namespace annulus
