#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "modeling/glasses/fit_report.h"

namespace annulus {
namespace {

constexpr double kEnters = 0.05;     // mm of penetration that count
constexpr double kTouches = 0.3;     // mm within which a part touches
constexpr double kRestsOnEar = 1.0;  // mm within which a temple rests

/// What must be said, and how much it counts: the excess in half ranges.
struct Remark {
  double weight = 0.0;
  std::string text;
};

double ExcessOf(const FitGoal& goal) {
  const double half = std::max(0.5 * (goal.high - goal.low), 1e-9);
  if (goal.met) return 0.0;
  return (goal.value < goal.low ? goal.low - goal.value : goal.value - goal.high) / half;
}

bool StartsWith(const std::string& text, const char* start) { return text.rfind(start, 0) == 0; }

std::string SideOf(const FitGoal& goal) {
  if (goal.id.ends_with("_right")) return "right";
  return goal.id.ends_with("_left") ? "left" : "";
}

/// The plain sentence for a goal that is not met.
std::string AdviceFor(const FitGoal& goal, const FittedFrame& fitted) {
  const bool is_low = goal.value < goal.low;
  // Less than a tenth is said as a tenth: "0.0 too wide" helps nobody.
  const double by = std::max(is_low ? goal.low - goal.value : goal.value - goal.high, 0.1);
  const bool padded = fitted.front.bearing == NoseBearing::kAdjust;
  const double middle = 0.5 * (goal.low + goal.high);
  const std::string side = SideOf(goal);
  if (goal.id == "dbl") {
    return fmt::format("DBL {:.0f} is {:.1f} mm too {} for this nose: choose {:.0f}{}", goal.value, by,
                       is_low ? "narrow" : "wide", middle, padded ? "" : " or adjustable pads");
  }
  if (StartsWith(goal.id, "vertex_distance")) {
    return fmt::format("the {} lens is {:.1f} mm too {} the eye (vertex distance {:.1f} mm): {}", side, by,
                       is_low ? "near to" : "far from", goal.value,
                       padded   ? "bend the pad arms"
                       : is_low ? "choose a narrower bridge or adjustable pads"
                                : "choose a wider bridge or adjustable pads");
  }
  if (StartsWith(goal.id, "pupil_height")) {
    return fmt::format("the {} pupil is {:.1f} mm too {} in the lens: {}", side, by, is_low ? "low" : "high",
                       is_low ? "the frame sits too high; choose a wider or a higher bridge"
                              : "the frame sits too low; choose a narrower or a lower bridge");
  }
  if (StartsWith(goal.id, "pd_")) {
    return fmt::format("the {} lens' centre is {:.1f} mm too far {}: choose a {} frame", side, by,
                       is_low ? "out" : "in", is_low ? "narrower" : "wider");
  }
  if (goal.id == "pantoscopic_tilt") {
    return fmt::format("the tilt of {:.1f} degrees is {:.1f} too {}: bend the temples' joints", goal.value, by,
                       is_low ? "small" : "large");
  }
  if (goal.id == "face_form") {
    return fmt::format("the face-form angle of {:.1f} degrees is {:.1f} too {}: bend the bridge or choose a {} front",
                       goal.value, by, is_low ? "small" : "large", is_low ? "more curved" : "flatter");
  }
  if (StartsWith(goal.id, "temple_length")) {
    return fmt::format("the {} temple would need {:.0f} mm to its bend: choose a temple {:.0f} mm {}", side, goal.value,
                       by, is_low ? "shorter" : "longer");
  }
  if (StartsWith(goal.id, "temple_splay")) {
    return fmt::format(
        "the front is too {} for this head: the {} temple leaves it at {:.1f} degrees {}; choose a {} "
        "frame or a larger temple outset",
        is_low ? "wide" : "narrow", side, std::abs(goal.value), is_low ? "inward" : "outward",
        is_low ? "narrower" : "wider");
  }
  if (goal.id == "lash_clearance") {
    return fmt::format(
        "the lashes have {:.1f} mm less than {:.0f} mm to the lens: move the lenses forward by pads or "
        "bridge",
        by, goal.low);
  }
  if (goal.id == "skin_clearance") {
    return fmt::format("rim or lens come {:.1f} mm too near to brow or cheek: choose a less high frame or less tilt",
                       by);
  }
  return fmt::format("the {} flank of the nose carries more: {:.0f} % on the right; bend the pads or shift the bridge",
                     is_low ? "left" : "right", goal.value);
}

/// 100·exp(-p/50). p: 12 for every half range by which a goal is missed (at most 40 each), 3 for a goal at the edge of
/// its range (by the square of the way), 30 for each contact that does not hold, 40 if anything enters.
double ScoreOf(const GlassesFit& fit, std::size_t broken) {
  double penalty = 0.0;
  for (const FitGoal& goal : fit.goals) {
    const double half = std::max(0.5 * (goal.high - goal.low), 1e-9);
    const double way = std::min(std::abs(goal.value - 0.5 * (goal.low + goal.high)) / half, 1.0);
    const bool has_best =
        goal.id != "lash_clearance" && goal.id != "skin_clearance" && !StartsWith(goal.id, "temple_length");
    penalty += std::min(12.0 * ExcessOf(goal), 40.0) + (has_best ? 3.0 * way * way : 0.0);
  }
  penalty += 30.0 * static_cast<double>(broken);
  if (fit.penetration > kEnters) penalty += 40.0;
  return 100.0 * std::exp(-penalty / 50.0);
}

}  // namespace

void AddAdvice(const FittedFrame& fitted, const SkinReport& skin, GlassesFit& fit) {
  std::vector<Remark> remarks;
  if (fit.penetration > kEnters) {
    remarks.push_back({1e3, fmt::format("{} would have to enter the head by {:.1f} mm: choose a wider frame",
                                        skin.deepest, fit.penetration)});
  }
  std::size_t broken = 0;
  for (const FrameContact& contact : fit.contacts) {
    const bool is_temple = StartsWith(contact.part, "temple");
    const double allowed = is_temple ? kRestsOnEar : kTouches;
    if (contact.distance <= allowed) continue;
    ++broken;
    remarks.push_back(
        {is_temple ? 50.0 : 100.0,
         fmt::format("{} does not touch the {}: {:.1f} mm are left; {}", contact.part, is_temple ? "head" : "nose",
                     contact.distance,
                     is_temple ? "bend the temple in"
                               : "bridge or rims meet it first: choose another bridge or adjustable pads")});
  }
  for (FitGoal& goal : fit.goals) {
    if (goal.met) continue;
    goal.advice = AdviceFor(goal, fitted);
    remarks.push_back({ExcessOf(goal), goal.advice});
  }
  std::stable_sort(remarks.begin(), remarks.end(),
                   [](const Remark& a, const Remark& b) { return a.weight > b.weight; });
  for (Remark& remark : remarks) {
    // Right and left of the same trouble are said once each; a sentence twice would be noise.
    if (std::find(fit.advice.begin(), fit.advice.end(), remark.text) == fit.advice.end()) {
      fit.advice.push_back(std::move(remark.text));
    }
  }
  fit.wearable = fit.advice.empty();
  fit.score = ScoreOf(fit, broken);
}

}  // namespace annulus
