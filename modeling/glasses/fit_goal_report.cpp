#include <algorithm>
#include <cmath>
#include <limits>

#include "base/units.h"
#include "modeling/glasses/boxing.h"
#include "modeling/glasses/fit_report.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kRigidGap = 0.5;         // mm that a rigid bridge may differ from what bears in the goals' ranges
constexpr double kPaddedGap = 3.5;        // mm, with adjustable pads
constexpr double kShortestTemple = 75.0;  // mm, hinge to ear point
constexpr double kLongestTemple = 125.0;
constexpr double kShortestTip = 25.0;  // mm behind the ear point, of a temple of given length
constexpr double kLongestTip = 55.0;
constexpr double kUnevenPush = 0.12;  // of the nose's load, either way from a half
constexpr double kRimSlack = 1e-6;    // mm
constexpr double kTouchesNose = 0.3;  // mm
constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

class GoalList {
 public:
  explicit GoalList(std::vector<FitGoal>& goals) : goals_(goals) {}

  void AddLength(const char* id, const char* term, double value, double sigma, double low, double high) {
    goals_.push_back({id, term, "mm", value, sigma, low, high, value >= low && value <= high, ""});
  }
  void AddAngle(const char* id, const char* term, double value, double sigma, double low, double high) {
    AddLength(id, term, DegreesFromRadians(value), DegreesFromRadians(sigma), DegreesFromRadians(low),
              DegreesFromRadians(high));
    goals_.back().unit = "deg";
  }
  void AddShare(const char* id, const char* term, double value, double low, double high) {
    AddLength(id, term, 100.0 * value, kNotKnown, 100.0 * low, 100.0 * high);
    goals_.back().unit = "%";
  }

 private:
  std::vector<FitGoal>& goals_;
};

/// Least distance along the line of sight from the lids about the pupil to the lens' back, mm.
double LashClearance(const FittedFrame& fitted, std::size_t side) {
  const GoalInputs& inputs = fitted.problem.task().inputs;
  const Eigen::Isometry3d head_from_frame = fitted.seated.pose.HeadFromFrame();
  const LensPlane& lens = fitted.front.lenses[side];
  const Vector3d normal = head_from_frame.linear() * lens.forward;
  const Vector3d centre = head_from_frame * lens.centre;
  const Vector3d sight = inputs.level.col(1);
  const Eigen::Isometry3d& station_from_head = fitted.head->station_from_head();
  double least = std::numeric_limits<double>::infinity();
  for (const double across : {-8.0, -4.0, 0.0, 4.0, 8.0}) {
    for (const double up : {-2.0, 1.0, 4.0}) {
      Vector3d p = inputs.eyes[side] + across * inputs.level.col(0) + up * inputs.level.col(2);
      for (int round = 0; round < 8; ++round) {
        const HeadGap gap = fitted.head->skin().FirstOrder(station_from_head * p);
        const double slope = (station_from_head.linear().transpose() * gap.gradient).dot(sight);
        p -= std::clamp(gap.distance / std::max(slope, 0.2), -3.0, 3.0) * sight;
      }
      const double along = (centre - p).dot(normal) / sight.dot(normal);
      least = std::min(least, along - inputs.lens_back[side] / sight.dot(normal));
    }
  }
  return least;
}

/// Both sides of the nose are touched, and every goal so far (pupils, vertex distances, tilt, face form) is met.
bool BearsWell(const GlassesFit& fit) {
  const auto touches = [](const FrameContact& contact) { return contact.distance <= kTouchesNose; };
  return touches(fit.contacts[0]) && touches(fit.contacts[1]) &&
         std::all_of(fit.goals.begin(), fit.goals.end(), [](const FitGoal& goal) { return goal.met; });
}

}  // namespace

void AddGoals(const FittedFrame& fitted, const SkinReport& skin, GlassesFit& fit) {
  const PoseTask& task = fitted.problem.task();
  const FitGoals& goals = fitted.options->goals;
  const GoalVector v = ValuesOf(fitted.front, task.inputs, fitted.seated.pose);
  FrontState state = fitted.state;
  state.pose = fitted.seated.pose;
  const std::array<Vector3d, 2> bearing{fit.contacts[0].position, fit.contacts[1].position};
  const GoalVector s = fitted.options->detail == FitDetail::kFull ? SigmasOf(fitted.problem, state, bearing)
                                                                  : GoalVector(GoalVector::Constant(std::nan("")));
  const auto value = [&](GoalValue goal) { return v[static_cast<int>(goal)]; };
  const auto sigma = [&](GoalValue goal) { return s[static_cast<int>(goal)]; };
  const std::array<LensPlane, 2>& lenses = fitted.front.lenses;
  GoalList list(fit.goals);
  const auto length = [&](const char* id, const char* term, GoalValue goal, double low, double high) {
    list.AddLength(id, term, value(goal), sigma(goal), low, high);
  };
  const auto angle = [&](const char* id, const char* term, GoalValue goal, const GoalRange& range) {
    list.AddAngle(id, term, value(goal), sigma(goal), range.low, range.high);
  };
  const auto pd = [&](const char* id, const char* term, GoalValue goal, std::size_t side) {
    const double centre = std::abs(lenses[side].centre.x());
    length(id, term, goal, centre - goals.decentration.high, centre - goals.decentration.low);
  };
  const auto height = [&](const char* id, const char* term, GoalValue goal, std::size_t side) {
    const GoalRange range = PupilRange(task, fitted.front, side);
    length(id, term, goal, 0.5 * lenses[side].b + range.low, 0.5 * lenses[side].b + range.high);
  };
  pd("pd_right", "Monocular pupillary distance, right", GoalValue::kPdRight, 0);
  pd("pd_left", "Monocular pupillary distance, left", GoalValue::kPdLeft, 1);
  height("pupil_height_right", "Fitting height, right", GoalValue::kHeightRight, 0);
  height("pupil_height_left", "Fitting height, left", GoalValue::kHeightLeft, 1);
  length("vertex_distance_right", "Vertex distance, right", GoalValue::kVertexRight, goals.vertex_distance.low,
         goals.vertex_distance.high);
  length("vertex_distance_left", "Vertex distance, left", GoalValue::kVertexLeft, goals.vertex_distance.low,
         goals.vertex_distance.high);
  angle("pantoscopic_tilt", "Pantoscopic tilt", GoalValue::kPantoscopicTilt, goals.pantoscopic_tilt);
  angle("face_form", "Face-form angle", GoalValue::kFaceForm, goals.face_form);
  const double dbl = DistanceBetweenLenses(MakeRim(fitted.front.design));
  const double beside = dbl - fitted.front.design.bridge_gap();
  const double slack = fitted.front.bearing == NoseBearing::kAdjust ? kPaddedGap : kRigidGap;
  double low = fitted.least_gap + beside - slack;
  double high = fitted.largest_gap + beside + slack;
  // A gap with which the front does bear where lenses and pupils may be is in the range, however it was estimated.
  if (BearsWell(fit)) {
    low = std::min(low, dbl);
    high = std::max(high, dbl);
  }
  list.AddLength("dbl", "Distance between lenses", dbl, sigma(GoalValue::kDbl), low, high);
  const std::optional<double> overall = fitted.options->temple_length;
  const double shortest = overall ? *overall - kLongestTip : kShortestTemple;
  const double longest = overall ? *overall - kShortestTip : kLongestTemple;
  length("temple_length_right", "Temple length to bend, right", GoalValue::kTempleRight, shortest, longest);
  length("temple_length_left", "Temple length to bend, left", GoalValue::kTempleLeft, shortest, longest);
  angle("temple_splay_right", "Temple splay, right", GoalValue::kSplayRight, goals.temple_splay);
  angle("temple_splay_left", "Temple splay, left", GoalValue::kSplayLeft, goals.temple_splay);
  const double vertex_sigma = sigma(GoalValue::kVertexRight);
  list.AddLength("lash_clearance", "Clearance of the lashes",
                 std::min(LashClearance(fitted, 0), LashClearance(fitted, 1)), vertex_sigma, goals.lash_clearance,
                 25.0);
  list.AddLength("skin_clearance", "Clearance of brow and cheek", skin.rims, kNotKnown,
                 goals.skin_clearance - kRimSlack, 25.0);
  list.AddShare("nose_balance", "Right flank's share of the nose's load", fit.balance.right_share, 0.5 - kUnevenPush,
                0.5 + kUnevenPush);
}

}  // namespace annulus
