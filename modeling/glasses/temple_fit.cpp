#include "modeling/glasses/temple_fit.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "modeling/glasses/frame_points.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kTouch = 0.02;        // mm: what counts as touching, kept so that rounding never enters
constexpr double kBeforeEar = 25.0;    // mm before the ear point that belong to the rest on the ear
constexpr double kBehindEar = 3.0;     // mm
constexpr double kFarthestOut = 15.0;  // mm that the ear point is moved outward at most
constexpr double kTurnStep = RadiansFromDegrees(0.5);
constexpr double kTipTouch = 0.1;      // mm that a tip keeps from the head
constexpr double kLeastTurn = RadiansFromDegrees(-20.0);
constexpr double kLargestTurn = RadiansFromDegrees(25.0);
constexpr int kRounds = 8;
constexpr PointDensity kSearchDensity{16, 4};

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
    const Result<Frame> frame = BuildFrame(design_, adjustment_);
    RETURN_IF_ERROR(frame);
    std::array<Stretches, 2> found;
    for (const PartPoints& part : SampleFrame(*frame, kSearchDensity, PointChoice::kTemples)) {
      for (const Vector3d& p : part.points) {
        const std::size_t side = p.x() > 0.0 ? 0 : 1;
        const Vector3d& ear = side == 0 ? adjustment_.temple_right.ear : adjustment_.temple_left.ear;
        Take(p, p.y() - ear.y(), found[side]);
      }
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

Status Improve(TempleSearch& search, const Aim& aim, std::array<Bend, 2>& bends) {
  const auto now = search.Measure(bends);
  RETURN_IF_ERROR(now);
  std::array<Bend, 2> moved = bends;
  for (Bend& bend : moved) bend.*aim.variable += aim.step;
  const auto there = search.Measure(moved);
  RETURN_IF_ERROR(there);
  for (std::size_t side = 0; side < 2; ++side) {
    const double slope = ((*there)[side].*aim.distance - (*now)[side].*aim.distance) / aim.step;
    const double missing = aim.wanted - (*now)[side].*aim.distance;
    if (!(std::abs(slope) * aim.step > 1e-6)) continue;
    const double largest = 10.0 * std::abs(aim.step);
    const double change = std::clamp(missing / slope, -largest, largest);
    bends[side].*aim.variable = std::clamp(bends[side].*aim.variable + change, aim.low, aim.high);
  }
  return {};
}

}  // namespace

Result<std::array<TempleFit, 2>> FitTemples(const WearerHead& head, const FrameDesign& design,
                                            const Eigen::Isometry3d& station_from_frame,
                                            const FrameAdjustment& pads) {
  TempleSearch search(head, design, station_from_frame, pads);
  std::array<Bend, 2> bends;
  for (Bend& bend : bends) bend.out = 1.0;
  const Aim rest{&Bend::out, &Stretches::ear, kTouch, 0.5, -5.0, kFarthestOut};
  const Aim bow{&Bend::bow, &Stretches::before, kTouch, kTurnStep, 0.0, kLargestBow};
  const Aim turn{&Bend::turn, &Stretches::tip, kTipTouch, kTurnStep, kLeastTurn, kLargestTurn};
  for (int round = 0; round < kRounds; ++round) {
    RETURN_IF_ERROR(Improve(search, rest, bends));
    RETURN_IF_ERROR(Improve(search, bow, bends));
  }
  for (int round = 0; round < kRounds; ++round) RETURN_IF_ERROR(Improve(search, turn, bends));
  // Where bow and limits are not enough, outward alone keeps the temple off the head.
  for (int round = 0; round < kRounds; ++round) {
    const auto now = search.Measure(bends);
    RETURN_IF_ERROR(now);
    for (std::size_t side = 0; side < 2; ++side) {
      const double least = std::min({(*now)[side].ear, (*now)[side].before, (*now)[side].tip});
      if (least < 0.5 * kTouch) bends[side].out += 1.2 * (kTouch - least);
    }
  }
  const auto found = search.Measure(bends);
  RETURN_IF_ERROR(found);
  std::array<TempleFit, 2> fits;
  for (std::size_t side = 0; side < 2; ++side) {
    fits[side] = {search.ShapeOf(side, bends[side]), (*found)[side].ear, (*found)[side].before, (*found)[side].tip};
  }
  return fits;
}

}  // namespace annulus
