#include "station/calibration_plan.h"

#include <fmt/format.h>

#include <cmath>

#include "base/units.h"
#include "station/target_text.h"
#include "station/toml_table.h"

namespace annulus {
namespace {

using toml_table::BadConfig;
using toml_table::Flag;
using toml_table::NumberIn;
using toml_table::ReadTable;
using toml_table::Refuse;
using toml_table::Text;
using toml_table::ToNumber;
using toml_table::ToText;
using toml_table::WholeIn;

constexpr double kOffCentre = 110.0;     // mm; of the first target
constexpr double kThinOffCentre = 90.0;  // mm; of the others
constexpr double kTilt = 7.0;            // degrees

const char* KindText(CalibrationTarget::Kind kind) {
  switch (kind) {
    case CalibrationTarget::Kind::kCylinder:
      return "cylinder";
    case CalibrationTarget::Kind::kSphere:
      return "sphere";
    case CalibrationTarget::Kind::kPlane:
      return "board";
    case CalibrationTarget::Kind::kStep:
      return "step gauge";
  }
  return "target";
}

/// "the front", "the subject's right" …: where a direction points, for somebody who stands before the booth.
std::string SideText(double theta_deg) {
  constexpr const char* kSides[]{"the right", "the front right", "the front", "the front left",
                                 "the left",  "the back left",   "the back",  "the back right"};
  const double turned = std::fmod(std::fmod(theta_deg, 360.0) + 360.0 + 22.5, 360.0);
  return kSides[static_cast<std::size_t>(turned / 45.0) % 8];
}

void ReadTarget(const toml::node& node, const std::string& section, CalibrationPlan& plan, std::vector<bool>& verify) {
  std::string spec;
  std::string line = toml_table::LineOf(node);
  bool only_verify = false;
  ReadTable(node, section,
            {{"spec",
              [&](const toml::node& n, const std::string& key) {
                spec = Text(n, key);
                line = toml_table::LineOf(n);
              }},
             {"verify", [&](const toml::node& n, const std::string& key) { only_verify = Flag(n, key); }}});
  auto target = ParseTarget(spec);
  if (!target) throw BadConfig{line + ": " + target.error().seen, target.error().advice};
  plan.targets.push_back(std::move(*target));
  verify.push_back(only_verify);
}

void ReadPlacement(const toml::node& node, const std::string& section, CalibrationPlan& plan) {
  PlannedPlacement placement;
  std::optional<bool> verify;
  ReadTable(node, section,
            {{"target",
              [&](const toml::node& n, const std::string& key) {
                placement.target = static_cast<std::size_t>(WholeIn(n, key, 1, 1000)) - 1;
              }},
             {"x_mm", ToNumber(placement.x_mm, -1000.0, 1000.0)},
             {"y_mm", ToNumber(placement.y_mm, -1000.0, 1000.0)},
             {"tilt_deg", ToNumber(placement.tilt_deg, 0.0, 45.0)},
             {"tilt_to_deg", ToNumber(placement.tilt_to_deg, -360.0, 360.0)},
             {"turn_deg", ToNumber(placement.turn_deg, -3600.0, 3600.0)},
             {"temperature_c", ToNumber(placement.temperature_c, -50.0, 100.0)},
             {"scan", ToText(placement.scan)},
             {"verify", [&](const toml::node& n, const std::string& key) { verify = Flag(n, key); }}});
  placement.verify = verify.value_or(false);
  plan.placements.push_back(std::move(placement));
}

/// Applies `read` to every table of a list of tables, and to what the tables are called.
template <class Read>
void ForEachTable(const toml::node& node, const std::string& key, const Read& read) {
  const std::string name = key.substr(key.rfind('.') + 1);
  const toml::array* list = node.as_array();
  if (list == nullptr) Refuse(node, name, "a list of tables, each begun by [[" + name + "]]");
  for (const toml::node& entry : *list) read(entry, name);
}

CalibrationPlan ReadAll(const toml::table& root) {
  CalibrationPlan plan;
  std::vector<bool> verify;
  ReadTable(root, "the file",
            {{"technician", ToText(plan.technician)},
             {"ambient_c", ToNumber(plan.ambient_c, -50.0, 100.0)},
             {"valid_days", ToNumber(plan.valid_days, 0.01, 10'000.0)},
             {"target",
              [&](const toml::node& n, const std::string& key) {
                ForEachTable(n, key, [&](const toml::node& entry, const std::string& name) {
                  ReadTarget(entry, name, plan, verify);
                });
              }},
             {"placement", [&](const toml::node& n, const std::string& key) {
                ForEachTable(n, key, [&](const toml::node& entry, const std::string& name) {
                  ReadPlacement(entry, name, plan);
                });
              }}});
  if (plan.targets.empty()) throw BadConfig{"it names no target", "add a [[target]] with its spec"};
  for (PlannedPlacement& placement : plan.placements) {
    if (placement.target >= plan.targets.size()) {
      throw BadConfig{
          fmt::format("a placement is of target {}, but there are {}", placement.target + 1, plan.targets.size()),
          "count the [[target]]s from 1"};
    }
    placement.verify = placement.verify || verify[placement.target];
  }
  if (plan.placements.empty()) plan.placements = UsualPlacements(plan.targets, verify);
  return plan;
}

}  // namespace

std::string PlannedPlacement::Instruction(const CalibrationTarget& of) const {
  std::string text = fmt::format("stand the {} of {:g} mm radius", KindText(of.kind), of.radius_mm);
  if (of.kind == CalibrationTarget::Kind::kPlane) text = "stand the board";
  if (!of.serial.empty()) text += " (" + of.serial + ")";
  const double off = std::hypot(x_mm, y_mm);
  if (off < 20.0) {
    text += " in the middle of the ring";
  } else {
    text += fmt::format(" {:.0f} mm from the middle, towards {}", off,
                        SideText(DegreesFromRadians(std::atan2(y_mm, x_mm))));
  }
  if (tilt_deg >= 1.0) {
    text += fmt::format(", tilted by about {:.0f} degrees with its top leaning to {}", tilt_deg, SideText(tilt_to_deg));
  } else {
    text += ", upright";
  }
  if (turn_deg && of.kind != CalibrationTarget::Kind::kSphere) {
    text += fmt::format(", its mark {:g} degrees counter-clockwise from the right", *turn_deg);
  }
  return text;
}

std::vector<PlannedPlacement> UsualPlacements(const std::vector<CalibrationTarget>& targets,
                                              const std::vector<bool>& verify) {
  std::vector<PlannedPlacement> placements;
  const auto add = [&](std::size_t target, double off, double direction_deg, double tilt_to_deg, double turn_deg) {
    PlannedPlacement placement;
    placement.target = target;
    placement.x_mm = off * std::cos(RadiansFromDegrees(direction_deg));
    placement.y_mm = off * std::sin(RadiansFromDegrees(direction_deg));
    placement.tilt_deg = off > 50.0 ? kTilt : 0.0;
    placement.tilt_to_deg = std::fmod(tilt_to_deg, 360.0);
    placement.turn_deg = turn_deg;
    placement.verify = verify[target];
    placements.push_back(placement);
  };
  bool first = true;
  for (std::size_t target = 0; target < targets.size(); ++target) {
    if (verify[target]) continue;
    if (first) {
      add(target, 0.0, 0.0, 0.0, 0.0);
      // Tilted across, so that the foot stays inside the ring.
      for (int k = 0; k < 5; ++k) add(target, kOffCentre, 72.0 * k, 72.0 * k + 90.0, 60.0 * (k + 1));
      first = false;
    } else {
      for (int k = 0; k < 3; ++k) add(target, kThinOffCentre, 180.0 + 120.0 * k, 45.0 + 120.0 * k, 90.0 * k);
    }
  }
  for (std::size_t target = 0; target < targets.size(); ++target) {
    if (verify[target]) add(target, 40.0, 90.0, 0.0, 0.0);
  }
  return placements;
}

Result<CalibrationPlan> ParseCalibrationPlan(std::string_view toml, const std::string& name) {
  const std::string attempted = "read the calibration plan " + name;
  try {
    return ReadAll(toml::parse(toml));
  } catch (const toml::parse_error& error) {
    return Fail(attempted,
                "line " + std::to_string(error.source().begin.line) + ": " + std::string(error.description()),
                "correct this line (TOML)");
  } catch (const BadConfig& bad) {
    return Fail(attempted, bad.seen, bad.advice);
  }
}

Result<CalibrationPlan> ReadCalibrationPlan(Storage& storage, const std::string& target) {
  const bool is_file = target.size() > 5 && target.compare(target.size() - 5, 5, ".toml") == 0;
  if (is_file) {
    const auto text = ReadTextFile(storage, target);
    if (!text) return Fail(text);
    return ParseCalibrationPlan(*text, target);
  }
  auto one = ParseTarget(target);
  if (!one) return Fail(one);
  CalibrationPlan plan;
  plan.targets.push_back(std::move(*one));
  plan.placements = UsualPlacements(plan.targets, {false});
  return plan;
}

}  // namespace annulus
