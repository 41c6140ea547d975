#include "station/profile_plan.h"

#include <algorithm>
#include <array>

namespace annulus {
namespace {

constexpr double kHeadRoomMm = 40.0;  // scanned above the highest point, as the built-in profiles do
constexpr std::array kBuiltIn{"body", "torso", "head", "breath", "target", "target_fine", "check"};

bool IsBuiltIn(const std::string& name) { return std::find(kBuiltIn.begin(), kBuiltIn.end(), name) != kBuiltIn.end(); }

/// What the configuration says of it; nothing set if nothing.
ProfileConfig Configured(const Config& config, const std::string& name) {
  const auto found = config.profiles.find(name);
  return found != config.profiles.end() ? found->second : ProfileConfig{};
}

/// A profile that only the configuration knows starts from nothing: all its lengths must be given.
Result<ScanPlan> OwnPlan(const std::string& name, const ProfileConfig& profile) {
  std::string missing;
  const auto need = [&](const std::optional<double>& value, const char* key) {
    if (!value) missing += (missing.empty() ? "" : ", ") + std::string(key);
  };
  if (!profile.find_top) need(profile.z_top_mm, "z_top_mm");
  need(profile.z_bottom_mm, "z_bottom_mm");
  need(profile.pitch_mm, "pitch_mm");
  need(profile.speed_mm_s, "speed_mm_s");
  if (!missing.empty()) {
    return Fail("plan a scan with profile '" + name + "'", "[profile." + name + "] has no " + missing,
                "add it to the configuration");
  }
  ScanPlan plan;
  plan.profile = name;
  plan.level_rate_hz = *profile.speed_mm_s > 0.0 ? *profile.speed_mm_s / *profile.pitch_mm : 30.0;
  plan.dwell_s = 20.0;  // of a parked ring
  return plan;
}

void Override(ScanPlan& plan, const ProfileConfig& profile) {
  if (profile.z_top_mm) plan.z_top_mm = *profile.z_top_mm;
  if (profile.z_bottom_mm) plan.z_bottom_mm = *profile.z_bottom_mm;
  if (plan.parked() && profile.z_top_mm && !profile.z_bottom_mm) plan.z_bottom_mm = plan.z_top_mm;
  if (profile.pitch_mm) plan.pitch_mm = *profile.pitch_mm;
  if (profile.speed_mm_s) plan.speed_mm_s = *profile.speed_mm_s;
  if (profile.sweeps) plan.sweeps = *profile.sweeps;
  if (profile.level_rate_hz) plan.level_rate_hz = *profile.level_rate_hz;
  if (profile.of_target) plan.of_target = true;
}

}  // namespace

std::vector<std::string> ProfileNames(const Config& config) {
  std::vector<std::string> names(kBuiltIn.begin(), kBuiltIn.end());
  for (const auto& [name, profile] : config.profiles) {
    if (!IsBuiltIn(name)) names.push_back(name);
  }
  return names;
}

bool NeedsTop(const Config& config, const std::string& name) {
  const ProfileConfig profile = Configured(config, name);
  return profile.find_top || ((name == "head" || name == "breath") && !profile.z_top_mm);
}

Result<ScanPlan> PlanOfProfile(const Config& config, const std::string& name,
                               std::optional<Millimetres> subject_height) {
  const ProfileConfig profile = Configured(config, name);
  const bool built_in = IsBuiltIn(name);
  if (NeedsTop(config, name)) {
    if (!subject_height) {
      return Fail("plan a scan with profile '" + name + "'", "where the subject's top is, is not known",
                  "enter the height, or search for the top first");
    }
  } else if (profile.z_top_mm && name == "head") {
    subject_height = Millimetres(*profile.z_top_mm - kHeadRoomMm);
  }
  auto plan = built_in || !config.profiles.contains(name) ? BuiltInPlan(name, subject_height) : OwnPlan(name, profile);
  if (!plan) return plan;
  Override(*plan, profile);
  if (!built_in && profile.find_top) plan->z_top_mm = subject_height->value() + kHeadRoomMm;
  return plan;
}

}  // namespace annulus
