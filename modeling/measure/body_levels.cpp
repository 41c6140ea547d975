#include "modeling/measure/body_levels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "base/frames.h"
#include "modeling/mesh/convex_hull_2d.h"

namespace annulus {
namespace {

constexpr double kStep = 5.0;  // mm between the sections looked at
constexpr std::size_t kCurvePoints = 240;
constexpr double kSeenShare = 0.6;        // of a section; with less, the inferred rest is taken too
constexpr double kLongestGap = 60.0;      // mm without a known section that are bridged
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

/// One fully known section.
struct Girth {
  double z = 0.0;
  double tape = 0.0;
  double hollow = 0.0;   ///< Share by which the skin is longer than the tape.
  bool bridged = false;  ///< Not seen: between seen neighbours.
};

/// A level is looked for on what was seen: a stretch hidden by an arm leans towards the shoulder above it, and would
/// draw the chest upwards. The tape spans it in a straight line.
Girth GirthOf(const MeasuredSurface& body, double z, const std::vector<Eigen::Vector2d>& curve) {
  std::vector<Eigen::Vector2d> seen;
  double skin = 0.0;
  for (std::size_t k = 0; k < curve.size(); ++k) {
    skin += (curve[(k + 1) % curve.size()] - curve[k]).norm();
    const double theta = kTwoPi * static_cast<double>(k) / static_cast<double>(curve.size());
    if (body.KnowledgeAt(theta, z) == Knowledge::kMeasured) seen.push_back(curve[k]);
  }
  const double whole = ConvexHullPerimeter(curve);
  const bool enough = static_cast<double>(seen.size()) >= kSeenShare * static_cast<double>(curve.size());
  return {z, enough ? ConvexHullPerimeter(seen) : whole, skin / whole - 1.0, false};
}

/// Appends to a run; what was not seen in between is bridged in a straight line, which makes no extreme.
void Append(const Girth& next, std::vector<Girth>& run) {
  if (!run.empty()) {
    const Girth last = run.back();
    const auto steps = static_cast<std::size_t>(std::lround((last.z - next.z) / kStep));
    for (std::size_t k = 1; k < steps; ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(steps);
      const auto between = [share](double from, double to) { return from + share * (to - from); };
      run.push_back({between(last.z, next.z), between(last.tape, next.tape), between(last.hollow, next.hollow), true});
    }
  }
  run.push_back(next);
}

/// Girths from the top down, in runs of sections known all around; short gaps (hands before the hips, armpits) are
/// bridged.
std::vector<std::vector<Girth>> KnownRuns(const MeasuredSurface& body, const TaskContext& context) {
  std::vector<std::vector<Girth>> runs;
  const double top = body.surface().z_max();
  const double height = top - body.surface().z_min();
  const auto steps = static_cast<std::size_t>(height / kStep);
  for (std::size_t k = 0; k <= steps; ++k) {
    const double z = top - static_cast<double>(k) * kStep;
    if (const auto curve = SectionCurve(body, z, kCurvePoints)) {
      if (runs.empty() || runs.back().back().z - z > kLongestGap) runs.emplace_back();
      Append(GirthOf(body, z, *curve), runs.back());
    }
    context.Report("finding levels", static_cast<double>(k), static_cast<double>(steps));
  }
  return runs;
}

std::vector<Girth> Smoothed(const std::vector<Girth>& girths) {
  std::vector<Girth> smooth = girths;
  for (std::size_t k = 1; k + 1 < girths.size(); ++k) {
    smooth[k].tape = (girths[k - 1].tape + 2.0 * girths[k].tape + girths[k + 1].tape) / 4.0;
  }
  return smooth;
}

/// Index of the largest girth of girths[first … last], or none if it lies at an end of the range (then it is no
/// maximum).
std::optional<std::size_t> InnerMaximum(const std::vector<Girth>& girths, std::size_t first, std::size_t last) {
  std::size_t best = first;
  for (std::size_t k = first; k <= last; ++k) {
    if (girths[k].tape > girths[best].tape) best = k;
  }
  if (best == first || best == last) return std::nullopt;
  return best;
}

std::size_t Below(const std::vector<Girth>& girths, std::size_t from, double distance) {
  return std::min(girths.size() - 1, from + static_cast<std::size_t>(distance / kStep));
}

/// Where head and neck are in a run that begins at the crown.
struct HeadAndNeck {
  std::size_t head = 0;
  std::size_t neck = 0;
};

/// Whether hollows of a section end the search for the head's girth.
enum class EarsAre { kHollows, kUnseen };

/// The head's girth is taken above the ears: the largest one before hollows show that ears or eyes have begun, or
/// before the girth falls by a tenth. The neck is the smallest girth below it before the shoulders widen.
std::optional<HeadAndNeck> FindHead(const std::vector<Girth>& girths, EarsAre ears) {
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
  for (std::size_t k = head; k <= Below(girths, 0, kLongestHead); ++k) {
    if (girths[k].tape < girths[neck].tape) neck = k;
    const bool shoulders = girths[k].tape > kShoulderShare * girths[neck].tape;
    if (shoulders && girths[neck].tape < kNeckShare * girth) return HeadAndNeck{head, neck};
  }
  return std::nullopt;
}

/// The neck of a scan that begins within the face: the smallest girth before one that only shoulders have.
std::optional<std::size_t> FindCutNeck(const std::vector<Girth>& girths) {
  std::size_t neck = 0;
  for (std::size_t k = 0; k <= Below(girths, 0, kLongestHead); ++k) {
    if (girths[k].tape < girths[neck].tape) neck = k;
    const bool shoulders = girths[k].tape > kWideShoulderShare * girths[neck].tape;
    if (shoulders) return neck > 0 ? std::optional(neck) : std::nullopt;
  }
  return std::nullopt;
}

/// Chest, waist and hip below `start` (the neck, or the top of a headless trunk).
struct Trunk {
  std::optional<std::size_t> chest;
  std::optional<std::size_t> waist;
  std::optional<std::size_t> hip;
};
Trunk FindTrunk(const std::vector<Girth>& girths, std::size_t start, double below_neck) {
  Trunk trunk;
  const std::size_t last = girths.size() - 1;
  // Waist: the smallest girth of the trunk, with more girth both above and below it.
  const std::size_t upper = Below(girths, start, below_neck);
  double best_depth = 0.01;
  for (std::size_t k = upper; k <= Below(girths, start, below_neck + 420.0); ++k) {
    double above = 0.0;
    double below = 0.0;
    for (std::size_t j = upper; j < k; ++j) above = std::max(above, girths[j].tape);
    for (std::size_t j = k + 1; j <= Below(girths, k, 300.0); ++j) below = std::max(below, girths[j].tape);
    const double depth = std::min(above, below) / girths[k].tape - 1.0;
    if (depth > best_depth) {
      best_depth = depth;
      trunk.waist = k;
    }
  }
  if (!trunk.waist || girths[*trunk.waist].tape < kSmallestWaist) return {};
  trunk.hip = InnerMaximum(girths, *trunk.waist, std::min(last, Below(girths, *trunk.waist, 320.0)));
  // Chest: from the waist up, the girth grows to the bust; above it, it falls a little or jumps up where the arms join.
  std::size_t chest = *trunk.waist;
  for (std::size_t k = *trunk.waist; k-- > upper;) {
    // The arms join: hidden armpits, or more than 4 % in 5 mm.
    if (girths[k].bridged || girths[k].tape > 1.04 * girths[k + 1].tape) break;
    if (girths[k].tape > girths[chest].tape) chest = k;
    if (girths[chest].z < girths[k].z - 60.0) break;  // no longer growing for 60 mm
  }
  if (chest != *trunk.waist) trunk.chest = chest;
  return trunk;
}

/// The vertex of the parabola through an extreme and its neighbours, mm: finer than the step.
double Refined(const std::vector<Girth>& girths, std::size_t k) {
  if (k == 0 || k + 1 >= girths.size()) return girths[k].z;
  const double before = girths[k - 1].tape;
  const double after = girths[k + 1].tape;
  const double bend = before - 2.0 * girths[k].tape + after;
  if (bend == 0.0) return girths[k].z;
  const double shift = std::clamp(0.5 * (before - after) / bend, -1.0, 1.0);
  return girths[k].z - shift * kStep;
}

}  // namespace

BodyLevels FindBodyLevels(const MeasuredSurface& body, const TaskContext& context) {
  BodyLevels levels;
  const std::vector<std::vector<Girth>> runs = KnownRuns(body, context);
  const auto longest =
      std::max_element(runs.begin(), runs.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  if (longest == runs.end() || longest->size() < 5) {
    levels.omitted.emplace_back("All levels: fewer than 25 mm of the body were seen all around.");
    return levels;
  }
  const auto add = [&](const std::vector<Girth>& girths, const char* id, std::optional<std::size_t> k,
                       const char* definition) {
    if (k) {
      levels.found.push_back({id, Refined(girths, *k), definition});
    } else {
      levels.omitted.push_back(std::string("Level ") + id + ": not found in the part that was seen all around.");
    }
  };
  // A standing person's arms may part the run of the head from that of the trunk.
  const std::vector<Girth> top = Smoothed(runs.front());
  std::optional<HeadAndNeck> head = FindHead(top, EarsAre::kHollows);
  if (!head) head = FindHead(top, EarsAre::kUnseen);  // hair is rough: its hollows say nothing
  const std::optional<std::size_t> neck = head ? std::optional(head->neck) : FindCutNeck(top);
  add(top, "head", head ? std::optional(head->head) : std::nullopt, "largest horizontal tape girth above the ears");
  add(top, "neck", neck, "smallest horizontal tape girth below the head");

  const std::vector<Girth> girths = Smoothed(*longest);
  const bool with_neck = neck && longest == runs.begin();
  const std::size_t start = with_neck ? *neck : 0;
  // Shoulders and armpits are passed over: they are no chest.
  double passed = with_neck ? 150.0 : 60.0;
  if (neck && !with_neck) passed = std::max(0.0, 150.0 - (top[*neck].z - girths.front().z));
  Trunk trunk;
  if (girths[start].z - girths.back().z >= kShortestTrunk) trunk = FindTrunk(girths, start, passed);
  add(girths, "chest", trunk.chest, "largest horizontal tape girth between axilla and waist");
  add(girths, "waist", trunk.waist, "smallest horizontal tape girth between chest and hip");
  add(girths, "hip", trunk.hip, "largest horizontal tape girth below the waist");
  return levels;
}

}  // namespace annulus
