#include "modeling/landmarks/armpits.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/frames.h"
#include "modeling/landmarks/girth_profile.h"
#include "modeling/measure/section_sampler.h"

namespace annulus {
namespace {

constexpr double kHighest = 400.0;   // mm from the waist to above anybody's armpits
constexpr double kLowest = 60.0;     // mm from the waist to below anybody's armpits
constexpr double kSide = kPi / 3.0;  // rad either way of the side in which an arm is looked for
constexpr double kHiddenArc = 0.07;  // rad; single lost returns are no arm
constexpr double kArmLength = 60.0;  // mm of hidden side that make an arm

/// Whether an arm hides a part of the side.
bool IsHidden(const MeasuredSurface& body, double side, double z) {
  const double column = kTwoPi / static_cast<double>(std::max<std::size_t>(1, body.segment().knowledge.columns()));
  const auto reach = static_cast<int>(kSide / column);
  double run = 0.0;
  for (int k = -reach; k <= reach; ++k) {
    run = body.KnowledgeAt(side + k * column, z) == Knowledge::kMeasured ? 0.0 : run + column;
    if (run >= kHiddenArc) return true;
  }
  return false;
}

/// The upper end of the arm's shadow on one side.
std::optional<double> EndOfArm(const MeasuredSurface& body, double side, double waist) {
  constexpr double kStep = 2.5;  // mm
  double hidden = 0.0;
  double end = 0.0;
  const double highest = std::min(body.surface().z_max(), waist + kHighest);
  for (double z = waist - kArmLength; z <= highest; z += kStep) {
    if (z < body.surface().z_min()) continue;
    if (IsHidden(body, side, z)) {
      hidden += kStep;
      end = z;
    } else if (z - end > 20.0) {
      if (hidden >= kArmLength && end > waist + kLowest) return end + 0.5 * kStep;
      hidden = 0.0;
    }
  }
  return std::nullopt;
}

std::optional<Armpits> FindByArms(const MeasuredSurface& body, double waist) {
  const std::optional<double> right = EndOfArm(body, 0.0, waist);
  const std::optional<double> left = EndOfArm(body, kPi, waist);
  if (!right && !left) return std::nullopt;
  const double first = right.value_or(*left);
  const double second = left.value_or(first);
  return Armpits{Armpits::Sign::kArms, 0.5 * (first + second), std::abs(first - second), 0.0};
}

/// Arms that are cut off leave stumps, whose lower edge is a sudden widening: the steepest, and much steeper than 30 mm
/// above and below.
std::optional<Armpits> FindByStumps(const MeasuredSurface& body, double waist) {
  constexpr double kStep = 2.5;       // mm
  constexpr double kSteepest = 0.75;  // mm/mm of the breadth; a trunk's taper has less
  constexpr double kSudden = 1.4;     // times the slope nearby
  constexpr std::size_t kAway = 12;   // steps: 30 mm
  const SectionSampler sampler(body.surface(), EvenDirections(180));
  std::vector<double> breadth;
  const double highest = std::min(body.surface().z_max(), waist + kHighest);
  for (double z = waist; z <= highest; z += kStep) {
    double right = 0.0;
    double left = 0.0;
    for (const Eigen::Vector2d& p : sampler.Points(z)) {
      right = std::max(right, p.x());
      left = std::min(left, p.x());
    }
    breadth.push_back(right - left);
  }
  // Stumps are the broadest part of a trunk: nothing above them is looked at.
  const auto broadest = static_cast<std::size_t>(std::max_element(breadth.begin(), breadth.end()) - breadth.begin());
  constexpr std::size_t kHalf = 3;  // steps: kWideningHalf
  const auto slope = [&](std::size_t k) { return (breadth[k + kHalf] - breadth[k - kHalf]) / (2.0 * kHalf * kStep); };
  const auto first = static_cast<std::size_t>(kLowest / kStep);
  std::optional<Armpits> steepest;
  for (std::size_t k = first; k <= broadest && k + kHalf + kAway < breadth.size(); ++k) {
    const double here = slope(k);
    const double near = std::max(slope(k - kAway), slope(k + kAway));
    if (here < kSteepest || here < kSudden * near || (steepest && here <= steepest->steepness)) continue;
    steepest = Armpits{Armpits::Sign::kStumps, waist + static_cast<double>(k) * kStep, 0.0, here};
  }
  return steepest;
}

}  // namespace

std::optional<Armpits> FindArmpits(const MeasuredSurface& body, double waist) {
  const std::optional<Armpits> arms = FindByArms(body, waist);
  return arms ? arms : FindByStumps(body, waist);
}

}  // namespace annulus
