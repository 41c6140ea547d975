#include "station/sim_section.h"

#include <array>
#include <limits>
#include <utility>

#include "base/units.h"

namespace annulus {
namespace {

using toml_table::BadConfig;
using toml_table::Ignore;
using toml_table::LineOf;
using toml_table::NumberIn;
using toml_table::ReadTable;
using toml_table::Refuse;
using toml_table::Setter;
using toml_table::Text;
using toml_table::ToFlag;
using toml_table::ToNumber;
using toml_table::ToText;
using toml_table::WholeIn;

using Kind = CalibrationTarget::Kind;

/// Degrees of the file, radians of `target`.
Setter ToAngle(double& target, double low_deg, double high_deg) {
  return [&target, low_deg, high_deg](const toml::node& n, const std::string& key) {
    target = RadiansFromDegrees(NumberIn(n, key, low_deg, high_deg));
  };
}

std::uint64_t SeedOf(const toml::node& node, const std::string& key) {
  return static_cast<std::uint64_t>(WholeIn(node, key, 0, std::numeric_limits<std::int64_t>::max()));
}

Kind KindOf(const toml::node& node, const std::string& key) {
  constexpr std::array<std::pair<const char*, Kind>, 4> kKinds{
      {{"cylinder", Kind::kCylinder}, {"sphere", Kind::kSphere}, {"plane", Kind::kPlane}, {"step", Kind::kStep}}};
  const std::string text = Text(node, key);
  for (const auto& [name, kind] : kKinds) {
    if (text == name) return kind;
  }
  Refuse(node, key, "\"cylinder\", \"sphere\", \"plane\" or \"step\"");
}

std::vector<double> NumbersIn(const toml::node& node, const std::string& key, double low, double high) {
  const toml::array* list = node.as_array();
  if (list == nullptr) Refuse(node, key, "a list of numbers");
  std::vector<double> numbers;
  for (const toml::node& one : *list) numbers.push_back(NumberIn(one, key, low, high));
  return numbers;
}

SimTarget ReadTarget(const toml::node& node, const std::string& section) {
  constexpr double kLargest = 3000.0;  // mm
  SimTarget made;
  CalibrationTarget& target = made.target;
  sim::TargetPlacement& placement = made.placement;
  sim::StepAside push;
  push.lasts_s = 0.5;
  push.x_mm = 3.0;
  push.yaw_rad = 0.0;
  std::optional<double> moved_at_s;
  double taper_mm_per_m = 0.0;
  ReadTable(node, section,
            {{"kind", [&](const toml::node& n, const std::string& key) { target.kind = KindOf(n, key); }},
             {"radius_mm", ToNumber(target.radius_mm, 1.0, kLargest)},
             {"true_radius_mm", ToNumber(made.truth.radius_mm, 1.0, kLargest)},
             {"height_mm", ToNumber(target.height_mm, 1.0, kLargest)},
             {"width_mm", ToNumber(target.width_mm, 1.0, kLargest)},
             {"thickness_mm", ToNumber(made.truth.board_thickness_mm, 0.1, kLargest)},
             {"rod_radius_mm", ToNumber(made.truth.rod_radius_mm, 0.1, kLargest)},
             {"step_mm", ToNumber(target.step_mm, 0.01, kLargest)},
             {"edges_mm",
              [&](const toml::node& n, const std::string& key) { target.edges_mm = NumbersIn(n, key, 0.0, kLargest); }},
             {"x_mm", ToNumber(placement.x_mm, -kLargest, kLargest)},
             {"y_mm", ToNumber(placement.y_mm, -kLargest, kLargest)},
             {"tilt_x_deg", ToAngle(placement.tilt_x, -45.0, 45.0)},
             {"tilt_y_deg", ToAngle(placement.tilt_y, -45.0, 45.0)},
             {"turn_deg", ToAngle(placement.turn_rad, -360.0, 360.0)},
             {"out_of_round_mm", ToNumber(made.out_of_round_mm, 0.0, 100.0)},
             {"taper_mm_per_m", ToNumber(taper_mm_per_m, -100.0, 100.0)},
             {"seed", [&](const toml::node& n, const std::string& key) { made.seed = SeedOf(n, key); }},
             {"moved_at_s", ToNumber(moved_at_s, 0.0, 1e4)},
             {"moved_x_mm", ToNumber(push.x_mm, -100.0, 100.0)},
             {"moved_y_mm", ToNumber(push.y_mm, -100.0, 100.0)}});
  made.truth.taper = taper_mm_per_m / 1000.0;
  if (moved_at_s) {
    push.at_s = *moved_at_s;
    made.moved = push;
  }
  if (const std::string trouble = SimTargetTrouble(made); !trouble.empty()) {
    throw BadConfig{LineOf(node) + ": no such target in [" + section + "]: " + trouble, "correct the target"};
  }
  return made;
}

}  // namespace

void ReadSimSection(const toml::node& node, SimConfig& sim) {
  ReadTable(node, "sim",
            {{"seed", [&](const toml::node& n, const std::string& key) { sim.seed = SeedOf(n, key); }},
             {"subject", ToText(sim.subject)},
             {"subject_scale", ToNumber(sim.subject_scale, 1e-6, 1e6)},
             {"subject_y_up", ToFlag(sim.subject_y_up)},
             {"noise_mm", ToNumber(sim.noise_mm, 0.0, 50.0)},
             {"dropout_rate", ToNumber(sim.dropout_rate, 0.0, 1.0)},
             {"outlier_rate", ToNumber(sim.outlier_rate, 0.0, 1.0)},
             {"sway", ToNumber(sim.sway, 0.0, 10.0)},
             {"breathing", ToNumber(sim.breathing, 0.0, 0.2)},
             {"hair", ToFlag(sim.hair)},
             {"spectacles", ToFlag(sim.spectacles)},
             {"dark_patches", ToFlag(sim.dark_patches)},
             {"faults", ToText(sim.faults)},
             {"reference", ToFlag(sim.reference)},
             {"cap", ToFlag(sim.cap)},
             {"loose_clothing", ToFlag(sim.loose_clothing)},
             {"real_time", ToFlag(sim.real_time)},
             {"step_aside_s", ToNumber(sim.step_aside_s, 0.0, 1e4)},
             {"leave_s", ToNumber(sim.leave_s, 0.0, 1e4)},
             {"raise_arm_s", ToNumber(sim.raise_arm_s, 0.0, 1e4)},
             {"target", [&](const toml::node& n, const std::string& key) { sim.target = ReadTarget(n, key); }},
             {"ring_errors", ToNumber(sim.ring.errors, 0.0, 10.0)},
             {"ring_seed", [&](const toml::node& n, const std::string& key) { sim.ring.seed = SeedOf(n, key); }},
             {"ring_tilt_deg", ToAngle(sim.ring.tilt_rad, -10.0, 10.0)},
             {"ring_bend_mm", ToNumber(sim.ring.bend_mm, 0.0, 20.0)},
             {"ring_position_scale", ToNumber(sim.ring.position_scale, 0.9, 1.1)},
             {"ring_range_mm_per_c", ToNumber(sim.ring.range_mm_per_c, -1.0, 1.0)},
             {"ring_temperature_c", ToNumber(sim.ring.temperature_c, -40.0, 125.0)},
             {"operator", Ignore()}});
}

}  // namespace annulus
