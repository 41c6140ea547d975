#include "modeling/glasses/temple_fit.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "modeling/glasses/frame_skin.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kTouch = 0.08;        // mm: a light touch, kept so that what the scan left open never enters
constexpr double kBeforeEar = 25.0;    // mm before the ear point that belong to the rest on the ear
constexpr double kFarthestOut = 15.0;  // mm that the ear point is moved outward at most
constexpr double kTurnStep = RadiansFromDegrees(0.5);
constexpr double kTipTouch = 0.2;  // mm that a tip keeps from the head
constexpr double kLeastTurn = RadiansFromDegrees(-20.0);
constexpr double kLargestTurn = RadiansFromDegrees(25.0);
constexpr double kTipLever = 20.0;  // mm from the bend to where a tip touches
constexpr double kSettled = 0.01;   // mm
constexpr int kRounds = 10;
constexpr int kTurnRounds = 2;  // in which a tip that enters is turned out rather than moved out
constexpr PointDensity kSearchDensity{12, 5};
constexpr double kExactWithin = 2.5;  // mm

/// What is varied of one temple.
struct Bend {
  double out = 0.0;  ///< mm, of the ear point, outward in the head frame.
  double bow = 0.0;  ///< rad
  double turn = 0.0;
};

/// Least distances of one temple, in its three stretches.
struct Stretches {
  double ear = 1e9;
  double before = 1e9;
  double tip = 1e9;
};

class TempleSearch {
 public:
  TempleSearch(const WearerHead& head, const FrameDesign& design, const Eigen::Isometry3d& station_from_frame,
               const FrameAdjustment& pads)
      : head_(head), design_(design), station_from_frame_(station_from_frame), adjustment_(pads) {}

  [[nodiscard]] TempleShape ShapeOf(std::size_t side, const Bend& bend) const {
    const double outward = side == 0 ? 1.0 : -1.0;
    const Vector3d right = head_.station_from_head().linear().col(0);
    const Vector3d ear = head_.ear(side == 0 ? Eye::kRight : Eye::kLeft) + outward * bend.out * right;
    return {station_from_frame_.inverse() * ear, bend.bow, bend.turn};
  }

  /// The distances of both temples, each bent as said.
  [[nodiscard]] Result<std::array<Stretches, 2>> Measure(const std::array<Bend, 2>& bends) {
    adjustment_.temple_right = ShapeOf(0, bends[0]);
    adjustment_.temple_left = ShapeOf(1, bends[1]);
    const auto shells = TempleShells(design_, adjustment_);
    RETURN_IF_ERROR(shells);
    std::array<Stretches, 2> found;
    for (const FrameShell& temple : *shells) {
      for (const Vector3d& p : SamplePoints(temple.shell, kSearchDensity)) {
        const std::size_t side = p.x() > 0.0 ? 0 : 1;
        const Vector3d& ear = side == 0 ? adjustment_.temple_right.ear : adjustment_.temple_left.ear;
        Take(p, p.y() - ear.y(), found[side]);
      }
    }
    return found;
  }

  /// The same, true to 0.001 mm.
  [[nodiscard]] Result<std::array<Stretches, 2>> MeasureFinely(const std::array<Bend, 2>& bends) {
    adjustment_.temple_right = ShapeOf(0, bends[0]);
    adjustment_.temple_left = ShapeOf(1, bends[1]);
    const auto shells = TempleShells(design_, adjustment_);
    RETURN_IF_ERROR(shells);
    const FrameSkin skin(*shells);
    WornPose pose;
    pose.head = &head_;
    pose.station_from_frame = station_from_frame_;
    pose.ear_y_right = adjustment_.temple_right.ear.y();
    pose.ear_y_left = adjustment_.temple_left.ear.y();
    const std::vector<SkinPlace> places = skin.Measure(pose, kSearchDensity, kExactWithin);
    std::array<Stretches, 2> found;
    for (std::size_t side = 0; side < 2; ++side) {
      const double ear_y = side == 0 ? pose.ear_y_right : pose.ear_y_left;
      const auto least = [&](double from, double to) {
        return skin
            .Least(pose, kSearchDensity, places,
                   [&](const SkinPlace& place) {
                     const double before_ear = place.position.y() - ear_y;
                     return (place.position.x() > 0.0) == (side == 0) && before_ear >= from && before_ear < to;
                   })
            .distance;
      };
      found[side] = {least(-kBehindEar, kBeforeEar), least(kBeforeEar, 1e9), least(-1e9, -kBehindEar)};
    }
    return found;
  }

 private:
  void Take(const Vector3d& p, double before_ear, Stretches& found) const {
    const Vector3d p_in_station = station_from_frame_ * p;
    if (before_ear < -kBehindEar) {
      found.tip = std::min(found.tip, head_.skin_without_ears().FirstOrder(p_in_station).distance);
      return;
    }
    double& least = before_ear < kBeforeEar ? found.ear : found.before;
    least = std::min(least, head_.skin().FirstOrder(p_in_station).distance);
  }

  const WearerHead& head_;
  const FrameDesign& design_;
  const Eigen::Isometry3d& station_from_frame_;
  FrameAdjustment adjustment_;
};

/// One step of the secant rule for both sides; what does not react stays.
using Variable = double Bend::*;
using Distance = double Stretches::*;

struct Aim {
  Variable variable;
  Distance distance;
  double wanted;
  double step;
  double low;
  double high;
};

/// Whether both sides are where they should be, or at the end of what can be bent.
Result<bool> Improve(TempleSearch& search, const Aim& aim, std::array<Bend, 2>& bends) {
  const auto now = search.Measure(bends);
  RETURN_IF_ERROR(now);
  const auto missing = [&](std::size_t side) { return aim.wanted - (*now)[side].*aim.distance; };
  const auto is_settled = [&](std::size_t side) {
    const double at = bends[side].*aim.variable;
    return std::abs(missing(side)) < kSettled || (missing(side) < 0.0 && at <= aim.low) ||
           (missing(side) > 0.0 && at >= aim.high);
  };
  if (is_settled(0) && is_settled(1)) return true;
  std::array<Bend, 2> moved = bends;
  for (Bend& bend : moved) bend.*aim.variable += aim.step;
  const auto there = search.Measure(moved);
  RETURN_IF_ERROR(there);
  for (std::size_t side = 0; side < 2; ++side) {
    const double slope = ((*there)[side].*aim.distance - (*now)[side].*aim.distance) / aim.step;
    if (!(std::abs(slope) * aim.step > 1e-6)) continue;
    const double largest = 10.0 * std::abs(aim.step);
    const double change = std::clamp(missing(side) / slope, -largest, largest);
    bends[side].*aim.variable = std::clamp(bends[side].*aim.variable + change, aim.low, aim.high);
  }
  return false;
}

/// The true distances, between the points too: where bow and turn are not enough, outward alone keeps a temple off.
Result<std::array<Stretches, 2>> KeepOff(TempleSearch& search, const std::array<double, 2>& extra,
                                         std::array<Bend, 2>& bends) {
  auto now = search.MeasureFinely(bends);
  for (int round = 0; round < kRounds && now; ++round) {
    bool is_free = true;
    for (std::size_t side = 0; side < 2; ++side) {
      const double least = std::min((*now)[side].ear, (*now)[side].before) - extra[side];
      const double tip = (*now)[side].tip - extra[side];
      if (least < 0.0 || tip < 0.0) is_free = false;
      if (least < 0.0) bends[side].out += kTouch - 1.1 * least;
      if (tip < 0.0 && round < kTurnRounds) bends[side].turn -= (kTipTouch - tip) / kTipLever;
      if (tip < 0.0 && round >= kTurnRounds) bends[side].out += kTouch - 1.5 * tip;
    }
    if (is_free) break;
    now = search.MeasureFinely(bends);
  }
  return now;
}

}  // namespace

Result<std::array<TempleFit, 2>> FitTemples(const WearerHead& head, const FrameDesign& design,
                                            const Eigen::Isometry3d& station_from_frame, const FrameAdjustment& pads,
                                            const std::array<double, 2>& extra) {
  TempleSearch search(head, design, station_from_frame, pads);
  std::array<Bend, 2> bends;
  for (Bend& bend : bends) bend.out = 1.0;
  const Aim rest{&Bend::out, &Stretches::ear, kTouch, 0.5, -5.0, kFarthestOut};
  const Aim bow{&Bend::bow, &Stretches::before, kTouch, kTurnStep, 0.0, kLargestBow};
  const Aim turn{&Bend::turn, &Stretches::tip, kTipTouch, kTurnStep, kLeastTurn, kLargestTurn};
  for (int round = 0; round < kRounds; ++round) {
    const auto rests = Improve(search, rest, bends);
    RETURN_IF_ERROR(rests);
    const auto bows = Improve(search, bow, bends);
    RETURN_IF_ERROR(bows);
    if (*rests && *bows) break;
  }
  for (int round = 0; round < kRounds; ++round) {
    const auto turns = Improve(search, turn, bends);
    RETURN_IF_ERROR(turns);
    if (*turns) break;
  }
  const auto found = KeepOff(search, extra, bends);
  RETURN_IF_ERROR(found);
  std::array<TempleFit, 2> fits;
  for (std::size_t side = 0; side < 2; ++side) {
    fits[side] = {search.ShapeOf(side, bends[side]), (*found)[side].ear, (*found)[side].before, (*found)[side].tip};
  }
  return fits;
}

}  // namespace annulus
