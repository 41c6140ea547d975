#include "modeling/landmarks/body_shape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "base/frames.h"
#include "modeling/measure/section_sampler.h"

namespace annulus {
namespace {

constexpr double kShortestTrunk = 250.0;  // mm of known body below the neck before a trunk is looked for

// Head and neck, shares and mm of adults' and children's heads with room to spare.
constexpr double kSmallestHead = 400.0;     // girth
constexpr double kLargestHead = 750.0;      // girth
constexpr double kCrown = 300.0;            // girth below which a section is still the crown
constexpr double kHollowShare = 0.006;      // skin longer than the tape by this share: ears or eye sockets have begun
constexpr double kLongestHead = 350.0;      // from the top of the scan to the neck
constexpr double kNeckShare = 0.85;         // of the head's girth, at most
constexpr double kWideShoulderShare = 1.7;  // of the neck's girth; no hip has as much of its waist's
constexpr double kSmallestWaist = 400.0;    // girth
constexpr double kShoulderShare = 1.05;     // of the smallest girth so far: the neck is passed

/// Where head and neck are in a run that begins at the crown.
struct HeadAndNeck {
  std::size_t head = 0;
  std::size_t neck = 0;
};

/// Whether hollows of a section end the search for the head's girth.
enum class EarsAre { kHollows, kUnseen };

/// The head's girth is taken above the ears: the largest one before hollows show that ears or eyes have begun, or
/// before the girth falls by a tenth. The neck is the smallest girth below it before the shoulders widen.
std::optional<HeadAndNeck> FindHead(const GirthRun& girths, EarsAre ears) {
  std::size_t head = 0;
  for (std::size_t k = 0; k < girths.size(); ++k) {
    if (ears == EarsAre::kHollows && girths[k].tape > kCrown && girths[k].hollow > kHollowShare) break;
    if (girths[k].tape < 0.9 * girths[head].tape) break;
    if (girths[k].tape > girths[head].tape) head = k;
  }
  const double girth = girths[head].tape;
  // Without the crown nobody knows whether the largest girth was seen.
  if (girths[0].tape > 0.9 * girth || girth < kSmallestHead || girth > kLargestHead) return std::nullopt;
  std::size_t neck = head;
  for (std::size_t k = head; k <= IndexBelow(girths, 0, kLongestHead); ++k) {
    if (girths[k].tape < girths[neck].tape) neck = k;
    const bool shoulders = girths[k].tape > kShoulderShare * girths[neck].tape;
    if (shoulders && girths[neck].tape < kNeckShare * girth) return HeadAndNeck{head, neck};
  }
  return std::nullopt;
}

/// The neck of a scan that begins within the face: the smallest girth before one that only shoulders have.
std::optional<std::size_t> FindCutNeck(const GirthRun& girths) {
  std::size_t neck = 0;
  for (std::size_t k = 0; k <= IndexBelow(girths, 0, kLongestHead); ++k) {
    if (girths[k].tape < girths[neck].tape) neck = k;
    const bool shoulders = girths[k].tape > kWideShoulderShare * girths[neck].tape;
    if (shoulders) return neck > 0 ? std::optional(neck) : std::nullopt;
  }
  return std::nullopt;
}

/// The waist below index `upper`: the smallest girth of the trunk, with more girth both above and below it.
std::optional<std::size_t> FindWaist(const GirthRun& girths, std::size_t upper) {
  std::optional<std::size_t> waist;
  double best_depth = 0.01;
  for (std::size_t k = upper; k <= IndexBelow(girths, upper, 420.0); ++k) {
    double above = 0.0;
    double below = 0.0;
    for (std::size_t j = upper; j < k; ++j) above = std::max(above, girths[j].tape);
    for (std::size_t j = k + 1; j <= IndexBelow(girths, k, 300.0); ++j) below = std::max(below, girths[j].tape);
    const double depth = std::min(above, below) / girths[k].tape - 1.0;
    if (depth > best_depth) {
      best_depth = depth;
      waist = k;
    }
  }
  if (!waist || girths[*waist].tape < kSmallestWaist) return std::nullopt;
  return waist;
}

/// The largest girth less than 320 mm below the waist, none if it lies at the end (then it is no maximum).
std::optional<std::size_t> FindHip(const GirthRun& girths, std::size_t waist) {
  const std::size_t last = IndexBelow(girths, waist, 320.0);
  std::size_t best = waist;
  for (std::size_t k = waist; k <= last; ++k) {
    if (girths[k].tape > girths[best].tape) best = k;
  }
  if (best == waist || best == last) return std::nullopt;
  return best;
}

constexpr double kClearFall = 0.9975;  // of a girth; less is noise and the skin's little waves

/// Whether the girth falls clearly above a section at `chest`, where arms begin to hide the sides: compared in the
/// directions that are seen at both heights.
bool FallsAbove(const MeasuredSurface& body, double chest, double highest) {
  const double end = std::min({highest, chest + 60.0, body.surface().z_max()});
  for (double z = chest + kGirthStep; z <= end; z += kGirthStep) {
    const SectionSampler sampler(body.surface(), SeenDirections(body, 0.5 * (chest + z), 0.5 * (z - chest), 240));
    const double share = TapeLength(sampler.Points(z)) / TapeLength(sampler.Points(chest));
    if (share > 1.0) return false;
    if (share < kClearFall) return true;
  }
  return false;
}

/// From the waist up, the girth grows to the bust; above it, it falls clearly or jumps up where the arms join. None if
/// it grows all the way to `highest` or to the arms, or falls so little that noise would decide.
std::optional<std::size_t> FindChest(const MeasuredSurface& body, const GirthRun& girths, std::size_t waist,
                                     std::size_t upper, double highest) {
  std::size_t chest = waist;
  double lowest = girths[waist].tape;  // above the chest
  for (std::size_t k = waist; k-- > upper;) {
    // The arms join: hidden armpits, or more than 4 % in 5 mm.
    if (girths[k].z > highest || girths[k].bridged || girths[k].tape > 1.04 * girths[k + 1].tape) break;
    lowest = std::min(lowest, girths[k].tape);
    if (girths[k].tape > girths[chest].tape) {
      chest = k;
      lowest = girths[k].tape;
    }
    if (girths[chest].z < girths[k].z - 60.0) break;  // no longer growing for 60 mm
  }
  if (chest == waist) return std::nullopt;
  if (lowest < kClearFall * girths[chest].tape || FallsAbove(body, girths[chest].z, highest)) return chest;
  return std::nullopt;
}

/// Direction of the longer axis of the section at z, rad in [0, pi), and how much longer it is.
struct LongAxis {
  double direction = 0.0;
  double ratio = 1.0;
};
LongAxis LongAxisAt(const SectionSampler& sampler, double z) {
  const std::vector<Eigen::Vector2d> points = sampler.Points(z);
  const Eigen::Vector2d centre = Centroid(points);
  // Second moments of the enclosed area, about its centroid, by triangles from there.
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector2d a = points[k] - centre;
    const Eigen::Vector2d b = points[(k + 1) % points.size()] - centre;
    const Eigen::Vector2d sum = a + b;
    const double twice = a.x() * b.y() - a.y() * b.x();
    moments += twice / 24.0 * (a * a.transpose() + b * b.transpose() + sum * sum.transpose());
  }
  const double difference = moments(0, 0) - moments(1, 1);
  const double half = 0.5 * std::hypot(difference, 2.0 * moments(0, 1));
  const double mean = 0.5 * moments.trace();
  const double direction = 0.5 * std::atan2(2.0 * moments(0, 1), difference);
  return {direction < 0.0 ? direction + kPi : direction, mean > half ? std::sqrt((mean + half) / (mean - half)) : 1.0};
}

/// Where the subject looks, from sections that are broader than deep (trunk) or, without one, deeper than broad (head).
double FrontOf(const MeasuredSurface& body, const BodyShape& shape) {
  constexpr double kClear = 1.1;                 // ratio of the axes
  const double most = RadiansFromDegrees(35.0);  // a subject is placed to look along +y
  const SectionSampler sampler(body.surface(), EvenDirections(180));
  double sum = 0.0;
  double weight = 0.0;
  for (const std::optional<double>& z : {shape.chest, shape.waist, shape.hip}) {
    if (!z) continue;
    const LongAxis axis = LongAxisAt(sampler, *z);
    const double turn = AngleDifference(2.0 * axis.direction, 0.0) / 2.0;
    if (axis.ratio < kClear || std::abs(turn) > most) continue;
    sum += (axis.ratio - 1.0) * turn;
    weight += axis.ratio - 1.0;
  }
  if (weight == 0.0 && shape.head) {
    const LongAxis axis = LongAxisAt(sampler, *shape.head);
    if (axis.ratio >= kClear && std::abs(axis.direction - kPi / 2.0) <= most) return axis.direction;
  }
  return kPi / 2.0 + (weight > 0.0 ? sum / weight : 0.0);
}

/// Chest, waist, hip and armpits of a run below index `start`; shoulders and armpits, `passed` mm, are no chest.
BodyShape WithTrunk(const MeasuredSurface& body, const GirthRun& girths, std::size_t start, double passed) {
  BodyShape shape;
  if (girths[start].z - girths.back().z < kShortestTrunk) return shape;
  const std::size_t upper = IndexBelow(girths, start, passed);
  const std::optional<std::size_t> waist = FindWaist(girths, upper);
  if (!waist) return shape;
  shape.waist = girths[*waist].z;
  const std::optional<std::size_t> hip = FindHip(girths, *waist);
  if (hip) shape.hip = girths[*hip].z;
  shape.armpits = FindArmpits(body, *shape.waist);
  const double highest = shape.armpits ? shape.armpits->z : body.surface().z_max();
  const std::optional<std::size_t> chest = FindChest(body, girths, *waist, upper, highest);
  if (chest) shape.chest = girths[*chest].z;
  return shape;
}

}  // namespace

BodyShape FindBodyShape(const MeasuredSurface& body, const TaskContext& context) {
  std::vector<GirthRun> runs = GirthRuns(body, context);
  const auto longest =
      std::max_element(runs.begin(), runs.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  if (longest == runs.end() || longest->size() < 5) return {};
  // A standing person's arms may part the run of the head from that of the trunk.
  const GirthRun& top = runs.front();
  std::optional<HeadAndNeck> head = FindHead(top, EarsAre::kHollows);
  if (!head) head = FindHead(top, EarsAre::kUnseen);  // hair is rough: its hollows say nothing
  const std::optional<std::size_t> neck = head ? std::optional(head->neck) : FindCutNeck(top);

  const bool with_neck = neck && longest == runs.begin();
  double passed = with_neck ? 150.0 : 60.0;
  if (neck && !with_neck) passed = std::max(0.0, 150.0 - (top[*neck].z - longest->front().z));
  BodyShape shape = WithTrunk(body, *longest, with_neck ? *neck : 0, passed);
  if (head) shape.head = top[head->head].z;
  if (neck) shape.neck = top[*neck].z;
  shape.lowest = longest->back().z;
  shape.front = FrontOf(body, shape);
  shape.runs = std::move(runs);
  return shape;
}

}  // namespace annulus
