#include "modeling/glasses/glasses_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/units.h"
#include "modeling/glasses/fit_report.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr const char* kAttempt = "fit the glasses";
constexpr double kPoorCost = 12.0;         // above: other starts are tried
constexpr double kPoorCostRanking = 40.0;  // the same where a frame that hardly fits is only one of many
constexpr double kSolverMargin = 0.3;      // mm that the solver keeps more than the goal asks
constexpr double kEnters = 0.03;           // mm of penetration that the last correction removes
constexpr int kCorrections = 6;
constexpr double kLeastGap = 4.0;     // mm
constexpr double kSpareOutset = 1.5;  // mm
constexpr double kLargestGap = 45.0;

Status CheckOptions(const GlassesFitOptions& options) {
  const auto bad = [](double value, double low, double high) { return !(value >= low && value <= high); };
  if (bad(options.limits.width_share, 0.0, 0.5) || bad(options.limits.gap_change, 0.0, 15.0) ||
      bad(options.limits.face_form_change, 0.0, 0.3)) {
    return Fail(kAttempt, "the limits of made-to-measure are not within their ranges",
                "give a width share of 0 … 0.5, a gap change of 0 … 15 mm");
  }
  for (std::size_t side = 0; side < 2; ++side) {
    if (options.pupil_height[side] && bad(*options.pupil_height[side], 5.0, 60.0)) {
      return Fail(kAttempt, fmt::format("a pupil height of {:.1f} mm is asked for", *options.pupil_height[side]),
                  "give 5 … 60 mm over the box's lower edge");
    }
    if (options.lens_back[side] && bad(*options.lens_back[side], -15.0, 25.0)) {
      return Fail(kAttempt, fmt::format("the lens' back is {:.1f} mm behind its rim", *options.lens_back[side]),
                  "give -15 … 25 mm");
    }
    if (bad(options.lens_mass_g[side], 0.0, 200.0)) {
      return Fail(kAttempt, "a lens' mass is not 0 … 200 g", "check the lens' weight");
    }
  }
  if (bad(options.frame_density, 0.5, 20.0)) {
    return Fail(kAttempt, fmt::format("the frame's density is {:.2f} g/cm³", options.frame_density), "give 0.5 … 20");
  }
  return {};
}

PoseTask TaskOf(const WearerHead& head, const FrameDesign& design, const GlassesFitOptions& options) {
  PoseTask task;
  task.head = &head;
  task.design = design;
  task.goals = options.goals;
  task.goals.skin_clearance += kSolverMargin;
  task.size = options.size;
  task.limits = options.limits;
  task.pupil_height = options.pupil_height;
  const Eigen::Isometry3d head_from_station = head.station_from_head().inverse();
  for (std::size_t side = 0; side < 2; ++side) {
    const Eye eye = side == 0 ? Eye::kRight : Eye::kLeft;
    task.inputs.eyes[side] = head_from_station * head.eye(eye);
    task.inputs.ears[side] = head_from_station * head.ear(eye);
    task.inputs.lens_back[side] = options.lens_back[side].value_or(kLensBackBehindRim);
  }
  return task;
}

/// Mean distance of what would bear, right and left, in a pose; mm.
double MeanBearing(const WearerHead& head, const FrontShape& front, const FrontPose& pose) {
  const Eigen::Isometry3d station_from_frame = head.station_from_head() * pose.HeadFromFrame();
  double sum = 0.0;
  for (std::size_t side = 0; side < 2; ++side) {
    if (front.bearing == NoseBearing::kAdjust) {
      sum += head.skin().Nearest(station_from_frame * front.pads[side]).distance;
      continue;
    }
    double least = 1e3;
    for (const std::size_t k : front.bearing_points[side]) {
      least = std::min(least, head.skin().FirstOrder(station_from_frame * front.points[k].position).distance);
    }
    sum += least;
  }
  return 0.5 * sum;
}

/// The bridge gap with which this form would bear when the pupils lie so far above the box centres and the lenses so
/// far before the eyes (mm): secant rule.
double BearingGap(const PoseProblem& problem, double pupil_above, double vertex_distance) {
  const PoseTask& task = problem.task();
  const double design_gap = task.design.bridge_gap();
  const auto bearing = [&](double gap) {
    FrameDesign design = task.design;
    design.details.bridge_gap = gap;
    const auto front = MakeFrontShape(design, task.goals, task.inputs.lens_back, task.density);
    if (!front) return std::nan("");
    FrontPose pose = problem.Start().pose;
    pose.shift.x() = task.head->nose_lateral();
    pose.shift.y() += vertex_distance - task.goals.vertex_distance.best;
    pose.shift.z() -= pupil_above - task.goals.pupil_above_centre.best;
    return MeanBearing(*task.head, *front, pose);
  };
  double gap = design_gap;
  double distance = bearing(gap);
  double slope = 0.4;
  for (int round = 0; round < 6 && std::isfinite(distance) && std::abs(distance) > 0.05; ++round) {
    const double next = std::clamp(gap - std::clamp(distance / slope, -6.0, 6.0), kLeastGap, kLargestGap);
    const double there = bearing(next);
    if (!std::isfinite(there) || std::abs(next - gap) < 0.01) break;
    slope = std::clamp((there - distance) / (next - gap), 0.1, 1.0);
    gap = next;
    distance = there;
  }
  return gap;
}

/// The best of the pose from the usual start and, if that is poor, of some beside it.
PoseProblem::Summary SolveFromStarts(const PoseProblem& problem, FitDetail detail) {
  const FrontState usual = problem.Start();
  PoseProblem::Summary best = problem.Solve(usual);
  if (best.cost <= (detail == FitDetail::kFull ? kPoorCost : kPoorCostRanking)) return best;
  for (const double up : {-6.0, 6.0}) {
    FrontState start = usual;
    start.pose.shift += Vector3d(0.0, 6.0, up);
    const PoseProblem::Summary other = problem.Solve(start);
    if (other.cost < best.cost - 1e-6) best = other;
  }
  return best;
}

/// Pads, temples and the finished frame for the front as it is seated.
Status Dress(FittedFrame& fitted) {
  const FrameDesign& design = fitted.front.design;
  WornFrame& worn = fitted.worn;
  worn.design = design;
  worn.station_from_frame = fitted.head->station_from_head() * fitted.seated.pose.HeadFromFrame();
  worn.adjustment = StandardAdjustment(design);
  auto pads = FitPads(*fitted.head, design, worn.station_from_frame);
  RETURN_IF_ERROR(pads);
  fitted.pads = *pads;
  if (fitted.pads) {
    worn.adjustment.pad_right = (*fitted.pads)[0].pose;
    worn.adjustment.pad_left = (*fitted.pads)[1].pose;
  }
  const auto temples = FitTemples(*fitted.head, design, worn.station_from_frame, worn.adjustment, fitted.temple_extra);
  RETURN_IF_ERROR(temples);
  fitted.temples = *temples;
  worn.adjustment.temple_right = fitted.temples[0].shape;
  worn.adjustment.temple_left = fitted.temples[1].shape;
  if (fitted.options->detail == FitDetail::kFull) {
    const Result<Frame> frame = BuildFrame(design, worn.adjustment);
    RETURN_IF_ERROR(frame);
    fitted.shells = ShellsOf(*frame);
    fitted.mass = MassOf(*frame, fitted.options->frame_density);
    worn.l6_right = frame->arm_right.l6;
    worn.l6_left = frame->arm_left.l6;
    return {};
  }
  auto shells = FrontShells(design, worn.adjustment);
  RETURN_IF_ERROR(shells);
  const auto temple_shells = TempleShells(design, worn.adjustment);
  RETURN_IF_ERROR(temple_shells);
  shells->insert(shells->end(), temple_shells->begin(), temple_shells->end());
  fitted.shells = std::move(*shells);
  return {};
}

void FillWorn(FittedFrame& fitted, const SkinReport& skin) {
  WornFrame& worn = fitted.worn;
  worn.face = fitted.head->face();
  worn.tilt = fitted.seated.pose.tilt;
  worn.clearance = std::max(skin.rims, 0.0);
  const auto frontal = [](const Vector3d& a, const Vector3d& b) { return std::hypot(a.x() - b.x(), a.z() - b.z()); };
  const Vector3d rim(0.5 * worn.design.rim_spacing(), 0.0, 0.0);
  worn.residuals.eye_right = frontal(worn.station_from_frame * rim, worn.face.eye_right.position);
  worn.residuals.eye_left = frontal(worn.station_from_frame * Vector3d(-rim), worn.face.eye_left.position);
  worn.residuals.ear_right =
      (worn.station_from_frame * worn.adjustment.temple_right.ear - worn.face.ear_right.position).norm();
  worn.residuals.ear_left =
      (worn.station_from_frame * worn.adjustment.temple_left.ear - worn.face.ear_left.position).norm();
}

Result<GlassesFit> FitOnce(const WearerHead& head, const FrameDesign& design, const GlassesFitOptions& options) {
  const auto problem = PoseProblem::Make(TaskOf(head, design, options));
  RETURN_IF_ERROR(problem);
  const PoseProblem::Summary solved = SolveFromStarts(*problem, options.detail);
  const auto front = problem->Front(solved.state);
  RETURN_IF_ERROR(front);
  const auto seated = SeatFront(head, *front, solved.state.pose);
  RETURN_IF_ERROR(seated);
  FittedFrame fitted{&head, &options, *problem, solved.state, *front, *seated, {}, {}, {}, {}, {}, 0.0, 0.0, {}};
  const FitGoals& goals = problem->task().goals;
  fitted.least_gap = BearingGap(*problem, goals.pupil_above_centre.high, goals.vertex_distance.low);
  fitted.largest_gap = BearingGap(*problem, goals.pupil_above_centre.low, goals.vertex_distance.high);
  if (fitted.least_gap > fitted.largest_gap) std::swap(fitted.least_gap, fitted.largest_gap);
  RETURN_IF_ERROR(Dress(fitted));
  SkinReport skin = MeasureSkin(fitted);
  for (int round = 0; round < kCorrections && skin.penetration > kEnters; ++round) {
    if (skin.front_penetration > kEnters) fitted.seated.pose.shift.y() += skin.front_penetration + 0.01;
    for (std::size_t side = 0; side < 2; ++side) {
      if (skin.temple_penetration[side] > kEnters) fitted.temple_extra[side] += skin.temple_penetration[side] + 0.01;
    }
    RETURN_IF_ERROR(Dress(fitted));
    skin = MeasureSkin(fitted);
  }
  FillWorn(fitted, skin);
  GlassesFit fit;
  fit.worn = fitted.worn;
  fit.penetration = skin.penetration;
  AddBalance(fitted, skin, fit);
  AddGoals(fitted, skin, fit);
  AddAdvice(fitted, skin, fit);
  fit.clearance = std::move(skin.map);
  return fit;
}

/// How much further out the corners must be of temples that leave the front too far outward, mm; 0 if none do.
double MissingOutset(const GlassesFit& fit) {
  double missing = 0.0;
  for (const FitGoal& goal : fit.goals) {
    const bool right = goal.id == "temple_splay_right";
    if ((!right && goal.id != "temple_splay_left") || goal.value <= goal.high) continue;
    const double length = right ? fit.worn.l6_right : fit.worn.l6_left;
    missing = std::max(missing, RadiansFromDegrees(goal.value - goal.high) * length);
  }
  return missing;
}

/// Made to measure: corners move out until temples leave the front within their range. The front gets narrower by some
/// of what they allow, so that they grow by more than is missing, and again; where that does not help they stay.
Result<GlassesFit> WithWiderCorners(const WearerHead& head, FrameDesign design, const GlassesFitOptions& options,
                                    GlassesFit fit) {
  double left = options.limits.outset_change;
  for (double missing = MissingOutset(fit); missing > 0.0 && left > 0.0;) {
    const double more = std::min(missing + kSpareOutset, left);
    left -= more;
    design.details.temple_outset += more;
    if (!Validate(design)) break;
    auto again = FitOnce(head, design, options);
    if (!again) break;
    missing = MissingOutset(*again);
    if (again->wearable > fit.wearable || (again->wearable == fit.wearable && again->score > fit.score)) {
      fit = std::move(*again);
    }
  }
  return fit;
}

}  // namespace

Result<GlassesFit> FitGlasses(const WearerHead& head, const FrameDesign& design, const GlassesFitOptions& options) {
  RETURN_IF_ERROR(Validate(design));
  RETURN_IF_ERROR(CheckOptions(options));
  auto fit = FitOnce(head, design, options);
  if (!fit || options.size == FitSize::kKept) return fit;
  return WithWiderCorners(head, design, options, std::move(*fit));
}

Result<GlassesFit> FitGlasses(const MeasuredSurface& head, const FrameDesign& design,
                              const GlassesFitOptions& options) {
  const auto wearer = WearerHead::Look(head, options.face);
  RETURN_IF_ERROR(wearer);
  return FitGlasses(*wearer, design, options);
}

}  // namespace annulus
