#include "acquisition/scan_plan.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr double kRunUpMarginMm = 5.0;
constexpr double kDefaultHeightMm = 1800.0;
/// Above the top of the head.
constexpr double kHeadRoomMm = 40.0;
/// From the top of the head to below the chin, with neck.
constexpr double kHeadLengthMm = 320.0;
constexpr std::uint32_t kMostSweeps = 16;
constexpr std::uint32_t kMostLevels = 20'000;
constexpr std::uint32_t kFewestLevels = 4;
/// Counts of unchecked plans end here, so that the sum over all sweeps does not overflow.
constexpr double kCountLimit = 1e8;
/// Rounding that a level's place or a ratio may have.
constexpr double kRounding = 1e-6;

std::string Number(double value) {
  std::string text = std::to_string(std::round(value * 100.0) / 100.0);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

double RoundedUp(double value, double step) { return std::ceil(value / step - kRounding) * step; }

/// Works on a plan and remembers why.
class PlanFitter {
 public:
  PlanFitter(const ScanPlan& plan, const AxisLimits& axis, const RingLimits& ring)
      : plan_(plan), axis_(axis), ring_(ring) {}

  PlanCheck Check() {
    if (FindNonsense()) return Invalid();
    FitRate();
    if (!plan_.parked()) {
      FitSpeed();
      FitInterleave();
    }
    if (plan_.level_rate_hz < ring_.min_level_rate.value() * (1.0 - kRounding)) {
      return Invalid("the ring does not go below " + Number(ring_.min_level_rate.value()) +
                     " levels/s, which this pitch and speed would need");
    }
    FitTravel();
    const std::uint32_t levels = plan_.TotalLevels();
    if (plan_.z_top_mm < plan_.z_bottom_mm || levels < kFewestLevels * plan_.sweeps) {
      return Invalid("nothing is left to scan between " + Number(axis_.z_min.value()) + " and " +
                     Number(axis_.z_max.value()) + " mm");
    }
    if (levels > kMostLevels) {
      return Invalid(std::to_string(levels) + " levels are more than the " + std::to_string(kMostLevels) +
                     " that one scan may have");
    }
    return {reasons_.empty() ? PlanVerdict::kValid : PlanVerdict::kAdjusted, plan_, reasons_};
  }

 private:
  PlanCheck Invalid(std::string reason) {
    reasons_ = {std::move(reason)};
    return Invalid();
  }
  PlanCheck Invalid() { return {PlanVerdict::kInvalid, plan_, reasons_}; }

  bool FindNonsense();
  void FitRate();
  void FitSpeed();
  void FitInterleave();
  void FitTravel();

  ScanPlan plan_;
  const AxisLimits& axis_;
  const RingLimits& ring_;
  std::vector<std::string> reasons_;
};

bool PlanFitter::FindNonsense() {
  const auto demand = [this](bool condition, const char* reason) {
    if (!condition) reasons_.emplace_back(reason);
  };
  for (double value :
       {plan_.z_top_mm, plan_.z_bottom_mm, plan_.pitch_mm, plan_.speed_mm_s, plan_.level_rate_hz, plan_.dwell_s}) {
    if (!std::isfinite(value) || std::abs(value) > 1e6) {
      reasons_.emplace_back("a number of the plan is not finite or absurdly large");
      return true;
    }
  }
  demand(plan_.level_rate_hz > 0.0, "level_rate_hz must be above 0");
  demand(plan_.speed_mm_s >= 0.0, "speed_mm_s must not be below 0");
  if (plan_.parked()) {
    demand(plan_.z_top_mm == plan_.z_bottom_mm, "a parked ring has z_top_mm = z_bottom_mm");
    demand(plan_.dwell_s > 0.0, "a parked ring needs dwell_s above 0");
    demand(plan_.sweeps == 1, "a parked ring has one sweep");
  } else {
    demand(plan_.z_top_mm > plan_.z_bottom_mm, "z_top_mm must be above z_bottom_mm");
    demand(plan_.pitch_mm >= 0.05, "pitch_mm must be at least 0.05");
    demand(plan_.sweeps >= 1 && plan_.sweeps <= kMostSweeps, "sweeps must be 1 to 16");
  }
  return !reasons_.empty();
}

void PlanFitter::FitRate() {
  const double most = ring_.max_level_rate.value();
  if (plan_.level_rate_hz <= most) return;
  // The distance between levels is what was asked for: speed goes down with the rate.
  plan_.speed_mm_s *= most / plan_.level_rate_hz;
  plan_.level_rate_hz = most;
  reasons_.push_back("the ring allows " + Number(most) + " levels/s: rate and speed lowered");
}

void PlanFitter::FitSpeed() {
  const double most = axis_.max_speed.value();
  if (plan_.speed_mm_s <= most) return;
  plan_.level_rate_hz *= most / plan_.speed_mm_s;
  plan_.speed_mm_s = most;
  reasons_.push_back("the machine allows " + Number(most) + " mm/s: speed lowered, and the level rate to " +
                     Number(plan_.level_rate_hz) + " per second");
}

void PlanFitter::FitInterleave() {
  const double ratio = plan_.sweep_pitch_mm() / plan_.pitch_mm;
  const double wanted = std::clamp(std::round(ratio), 1.0, static_cast<double>(plan_.sweeps));
  if (std::abs(ratio - wanted) <= kRounding * wanted) return;
  const double speed = wanted * plan_.pitch_mm * plan_.level_rate_hz;
  if (speed > axis_.max_speed.value()) {
    plan_.level_rate_hz = plan_.speed_mm_s / (wanted * plan_.pitch_mm);
    reasons_.push_back(
        "levels of one sweep must be a whole number of pitches apart, at most the number of sweeps: "
        "level rate set to " +
        Number(plan_.level_rate_hz) + " per second");
    return;
  }
  plan_.speed_mm_s = speed;
  reasons_.push_back(
      "levels of one sweep must be a whole number of pitches apart, at most the number of sweeps: "
      "speed set to " +
      Number(speed) + " mm/s");
}

void PlanFitter::FitTravel() {
  const double room = plan_.parked() ? 0.0 : RunUp(plan_, axis_).value();
  const double highest = axis_.z_max.value() - room;
  const double lowest = axis_.z_min.value() + room;
  if (plan_.z_top_mm > highest) {
    plan_.z_top_mm = highest;
    reasons_.push_back("the machine's travel with its run-up ends at " + Number(highest) + " mm: z_top_mm lowered");
  }
  if (plan_.z_bottom_mm < lowest) {
    plan_.z_bottom_mm = lowest;
    reasons_.push_back("the machine's travel with its run-up begins at " + Number(lowest) + " mm: z_bottom_mm raised");
  }
}

ScanPlan BodyPlan(double height_mm) {
  ScanPlan plan;
  plan.profile = "body";
  plan.z_top_mm = height_mm;
  plan.z_bottom_mm = 0.0;
  plan.pitch_mm = 5.0;
  plan.speed_mm_s = 300.0;
  plan.sweeps = 4;
  plan.level_rate_hz = 30.0;
  return plan;
}

/// A target of about a metre on the floor or on a stand: down and up over the same levels, so that a target that moved,
/// or a carriage with play, shows. About 40 s with all travel.
ScanPlan TargetPlan() {
  ScanPlan plan;
  plan.profile = "target";
  plan.of_target = true;
  plan.z_top_mm = 1150.0;
  plan.z_bottom_mm = 150.0;
  plan.pitch_mm = 5.0;
  plan.speed_mm_s = 100.0;
  plan.sweeps = 2;
  plan.level_rate_hz = 20.0;
  return plan;
}

/// The same as one sweep so fine that the height of a step's edge is found.
ScanPlan FineTargetPlan() {
  ScanPlan plan = TargetPlan();
  plan.profile = "target_fine";
  plan.pitch_mm = 1.0;
  plan.speed_mm_s = 40.0;
  plan.sweeps = 1;
  plan.level_rate_hz = 40.0;
  return plan;
}

/// One quick sweep over a target that is left in the booth, for the daily check.
ScanPlan CheckPlan() {
  ScanPlan plan = TargetPlan();
  plan.profile = "check";
  plan.pitch_mm = 10.0;
  plan.speed_mm_s = 200.0;
  plan.sweeps = 1;
  return plan;
}

}  // namespace

std::uint32_t ScanPlan::interleave() const {
  ENSURE(!parked() && pitch_mm > 0.0, "a moving plan has a pitch");
  return static_cast<std::uint32_t>(std::max(1.0, std::round(sweep_pitch_mm() / pitch_mm)));
}

double ScanPlan::SweepTop(std::uint32_t sweep) const {
  return parked() ? z_top_mm : z_top_mm - (sweep % interleave()) * pitch_mm;
}

std::uint32_t ScanPlan::SweepLevels(std::uint32_t sweep) const {
  if (parked()) return static_cast<std::uint32_t>(std::clamp(std::round(dwell_s * level_rate_hz), 0.0, kCountLimit));
  const double span = SweepTop(sweep) - z_bottom_mm;
  if (span < 0.0) return 0;
  // The lowest level keeps clear of z_bottom itself: 1800 mm at 10 mm are 180 levels, as 6 s at 30 per second are.
  const double levels = std::ceil(span / sweep_pitch_mm() - kRounding);
  return static_cast<std::uint32_t>(std::clamp(levels, 1.0, kCountLimit));
}

std::uint32_t ScanPlan::TotalLevels() const {
  std::uint32_t total = 0;
  for (std::uint32_t sweep = 0; sweep < sweeps; ++sweep) total += SweepLevels(sweep);
  return total;
}

Millimetres RunUp(const ScanPlan& plan, const AxisLimits& limits) {
  const double v = plan.speed_mm_s;
  return Millimetres(v * v / (2.0 * limits.max_acceleration.value()) + kRunUpMarginMm);
}

Result<ScanPlan> BuiltInPlan(const std::string& profile, std::optional<Millimetres> subject_height) {
  const std::string attempted = "plan a scan with profile '" + profile + "'";
  if (subject_height && !(subject_height->value() >= 300.0 && subject_height->value() <= 2500.0)) {
    return Fail(attempted, "a subject height of " + Number(subject_height->value()) + " mm",
                "enter the height in mm, 300 to 2500");
  }
  const double height = subject_height ? subject_height->value() : kDefaultHeightMm;
  if (profile == "body") {
    return BodyPlan(subject_height ? RoundedUp(height + kHeadRoomMm, 10.0) : kDefaultHeightMm);
  }
  if (profile == "torso") {
    // Chin at 0.87, crotch at 0.47 of the stature (Drillis and Contini 1966), with a hand's breadth on either side.
    ScanPlan plan = BodyPlan(RoundedUp(0.87 * height + 40.0, 10.0));
    plan.profile = profile;
    plan.z_bottom_mm = RoundedUp(0.47 * height - 80.0, 10.0);
    plan.sweeps = 2;
    return plan;
  }
  if (profile == "head") {
    if (!subject_height) {
      return Fail(attempted, "no subject height", "enter the height, or let a search sweep find the top");
    }
    ScanPlan plan;
    plan.profile = profile;
    plan.z_top_mm = height + kHeadRoomMm;
    plan.z_bottom_mm = height - kHeadLengthMm;
    plan.pitch_mm = 1.0;
    // 7 s for the head: half of what 30 levels/s take, so about two thirds of the sway.
    plan.speed_mm_s = 50.0;
    plan.level_rate_hz = 50.0;
    return plan;
  }
  if (profile == "breath") {
    ScanPlan plan;
    plan.profile = profile;
    plan.z_top_mm = plan.z_bottom_mm = RoundedUp(0.72 * height, 10.0);  // nipple height, Drillis and Contini 1966
    plan.level_rate_hz = 30.0;
    plan.dwell_s = 20.0;
    return plan;
  }
  if (profile == "target") return TargetPlan();
  if (profile == "target_fine") return FineTargetPlan();
  if (profile == "check") return CheckPlan();
  return Fail(attempted, "no such built-in profile", "use body, torso, head, breath, target, target_fine or check");
}

PlanCheck ValidatePlan(const ScanPlan& plan, const AxisLimits& axis, const RingLimits& ring) {
  return PlanFitter(plan, axis, ring).Check();
}

std::string PlanJson(const ScanPlan& plan) {
  nlohmann::ordered_json json{{"profile", plan.profile},
                              {"z_top_mm", plan.z_top_mm},
                              {"z_bottom_mm", plan.z_bottom_mm},
                              {"pitch_mm", plan.pitch_mm},
                              {"speed_mm_s", plan.speed_mm_s},
                              {"sweeps", plan.sweeps},
                              {"level_rate_hz", plan.level_rate_hz},
                              {"dwell_s", plan.dwell_s}};
  if (plan.of_target) json["of_target"] = true;
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Result<ScanPlan> PlanFromJson(const std::string& text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  const auto wrong = [](const std::string& seen) {
    return Fail("read the plan of a scan", seen, "the recording is damaged; scan again");
  };
  if (!json.is_object()) return wrong("it is not a JSON object");
  ScanPlan plan;
  const auto read = [&](const char* key, auto& value) {
    const auto found = json.find(key);
    if (found == json.end() || !found->is_number()) return false;
    value = found->template get<std::remove_reference_t<decltype(value)>>();
    return true;
  };
  const auto profile = json.find("profile");
  if (profile == json.end() || !profile->is_string()) return wrong("'profile' is missing or wrong");
  plan.profile = profile->get<std::string>();
  const bool complete = read("z_top_mm", plan.z_top_mm) && read("z_bottom_mm", plan.z_bottom_mm) &&
                        read("pitch_mm", plan.pitch_mm) && read("speed_mm_s", plan.speed_mm_s) &&
                        read("level_rate_hz", plan.level_rate_hz) && read("dwell_s", plan.dwell_s);
  plan.of_target = json.value("of_target", nlohmann::json()) == true;
  const auto sweeps = json.find("sweeps");
  if (!complete || sweeps == json.end() || !sweeps->is_number_unsigned()) return wrong("a number is missing or wrong");
  plan.sweeps = static_cast<std::uint32_t>(std::min<std::uint64_t>(sweeps->get<std::uint64_t>(), kMostSweeps + 1));
  // Limits that any plan keeps; those of a machine are not known here.
  constexpr double kAny = 1e6;
  const PlanCheck check = ValidatePlan(
      plan, {Millimetres(-kAny), Millimetres(kAny), MillimetresPerSecond(kAny), MillimetresPerSecondSquared(kAny)},
      {0, Hertz(0.0), Hertz(kAny)});
  if (check.verdict == PlanVerdict::kInvalid) {
    return wrong(check.reasons.empty() ? std::string("it makes no sense") : check.reasons.front());
  }
  return plan;
}

}  // namespace annulus
