#include "station/sim_subject.h"

#include <array>
#include <utility>

#include "base/ensure.h"
#include "sim/acting_subject.h"
#include "sim/clothed_subject.h"
#include "sim/dressed_subject.h"
#include "sim/mesh_subject.h"
#include "sim/moving_subject.h"
#include "sim/person.h"
#include "sim/random_head.h"

namespace annulus {
namespace {

/// Whose head the subject "head" is: an ordinary one, on which most frames can be worn.
constexpr std::uint64_t kHeadSeed = 3;

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
  return subject == "body" ? sim::MakePerson({}) : sim::MakeRandomHead(kHeadSeed);
}

namespace {

/// Lengths that are known at a stature of 1700 mm, on this subject.
double Scaled(double length_mm, const sim::Subject& subject) { return length_mm * subject.top_mm() / 1700.0; }

sim::Cap CapOf(const sim::Subject& subject, const sim::Placement& placement) {
  sim::Cap cap;
  cap.rim_mm = Scaled(1625.0, subject);
  cap.axis_x_mm = placement.x_mm;
  cap.axis_y_mm = placement.y_mm;
  cap.forehead_mm = Scaled(92.0, subject);
  return cap;
}

sim::LooseClothing ClothingOf(const sim::Subject& subject) {
  sim::LooseClothing clothing;
  clothing.low_mm = Scaled(850.0, subject);
  clothing.high_mm = Scaled(1380.0, subject);
  return clothing;
}

/// The right arm held out to the front at chest height; of a head alone, the hand before the face.
std::unique_ptr<sim::Subject> RaisingArm(std::unique_ptr<sim::ParametricBody> body, double at_s) {
  sim::ParametricBody::Description without{body->name(),    {},           body->levels(),
                                           body->heights(), body->face(), body->placement()};
  for (const sim::ParametricBody::Part& part : body->parts()) {
    if (part.id != sim::BodyPart::kRightArm) without.parts.push_back(part);
  }
  sim::HeldOutArm arm;
  arm.at_s = at_s;
  const double scale = body->top_mm() / 1700.0;
  if (body->name() == "head") {
    arm.shoulder = {260.0, 120.0, 1300.0};
    arm.elbow = {270.0, 200.0, 1380.0};
    arm.hand = {60.0, 180.0, 1560.0};
  }
  for (Eigen::Vector3d* place : {&arm.shoulder, &arm.elbow, &arm.hand}) *place *= scale;
  return std::make_unique<sim::ArmRaisingSubject>(std::move(body),
                                                  std::make_unique<sim::ParametricBody>(std::move(without)), arm);
}

/// Puts motion and steps on whoever is dressed already.
std::unique_ptr<sim::Subject> Moving(std::unique_ptr<sim::Subject> subject, const SimConfig& config) {
  if (config.sway > 0.0 || config.breathing > 0.0) {
    sim::MotionOptions motion;
    motion.sway_scale = config.sway;
    motion.breathing_share = config.breathing;
    motion.breathing_height_mm = 0.735 * subject->top_mm();  // chest level of a standing person
    motion.seed = config.seed;
    subject = std::make_unique<sim::MovingSubject>(std::move(subject), motion);
  }
  if (!config.step_aside_s && !config.leave_s) return subject;
  std::optional<sim::StepAside> step;
  if (config.step_aside_s) step.emplace().at_s = *config.step_aside_s;
  return std::make_unique<sim::WalkingSubject>(std::move(subject), step, config.leave_s);
}

/// What people do and targets do not.
std::string NeedsPerson(const SimConfig& config) {
  const std::array<std::pair<bool, const char*>, 10> of_people{{{config.sway > 0.0, "sim.sway"},
                                                                {config.breathing > 0.0, "sim.breathing"},
                                                                {config.hair, "sim.hair"},
                                                                {config.spectacles, "sim.spectacles"},
                                                                {config.dark_patches, "sim.dark_patches"},
                                                                {config.cap, "sim.cap"},
                                                                {config.loose_clothing, "sim.loose_clothing"},
                                                                {config.step_aside_s.has_value(), "sim.step_aside_s"},
                                                                {config.leave_s.has_value(), "sim.leave_s"},
                                                                {config.raise_arm_s.has_value(), "sim.raise_arm_s"}}};
  for (const auto& [asked, key] : of_people) {
    if (asked) return key;
  }
  return {};
}

/// What only a built-in subject can do, because its parts are known.
std::string NeedsBuiltIn(const SimConfig& config) {
  if (config.spectacles) return "sim.spectacles";
  if (config.cap) return "sim.cap";
  if (config.raise_arm_s) return "sim.raise_arm_s";
  return {};
}

}  // namespace

Result<std::unique_ptr<sim::Subject>> MakeSimSubject(const SimConfig& config, Storage& storage) {
  if (config.target) {
    if (const std::string key = NeedsPerson(config); !key.empty()) {
      return Fail("simulate " + key, "a target stands in the booth, [sim.target]",
                  "leave " + key + " out, or [sim.target]");
    }
    return MakeSimTarget(*config.target);
  }
  std::unique_ptr<sim::Subject> subject;
  sim::Placement placement;
  sim::Dress dress;
  if (IsBuiltInSubject(config.subject)) {
    auto body = std::make_unique<sim::ParametricBody>(BareSubject(config.subject));
    placement = body->placement();
    if (config.spectacles) dress.spectacles.emplace().face = body->face();
    if (config.raise_arm_s) {
      subject = RaisingArm(std::move(body), *config.raise_arm_s);
    } else {
      subject = std::move(body);
    }
  } else {
    if (const std::string key = NeedsBuiltIn(config); !key.empty()) {
      return Fail("simulate " + key + " with " + config.subject, "head and arms of a mesh file are not known",
                  "leave " + key + " out, or choose the subject body or head");
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
  if (config.cap || config.loose_clothing) {
    std::optional<sim::Cap> cap;
    std::optional<sim::LooseClothing> clothing;
    if (config.cap) cap = CapOf(*subject, placement);
    if (config.loose_clothing) clothing = ClothingOf(*subject);
    subject = std::make_unique<sim::ClothedSubject>(std::move(subject), cap, clothing);
  }
  return Moving(std::move(subject), config);
}

}  // namespace annulus
