// Girths, extents and arcs of horizontal sections, and the girth around the base of the neck.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "modeling/measure/taut_tape.h"
#include "modeling/table/level_measures.h"
#include "modeling/table/measurement_groups.h"
#include "modeling/table/place_geometry.h"

namespace annulus {
namespace {

constexpr std::size_t kDirections = 1440;

/// What a part of the tape is called; no id: the table does not have it.
struct ArcWords {
  const char* id = nullptr;
  const char* term = nullptr;
};

/// A level whose section is measured, what its numbers are called, and which of them the table has besides the girth.
struct LevelRow {
  const char* landmark;
  const char* id;
  const char* term;
  const char* where;
  double girth_limit;
  bool taut;
  bool perimeter;
  bool extents;
  ArcWords front{};
  ArcWords back{};
};
constexpr std::array<LevelRow, 10> kRows{{
    {"level.head",
     "head",
     "Head",
     "head level",
     kHeadOverHairLimit,
     false,
     true,
     false,
     {"head_front_arc", "Head arc, front"},
     {"head_back_arc", "Head arc, back"}},
    {"level.neck", "neck", "Neck", "neck level", kSmallGirthLimit, false, true, true},
    {"level.axilla",
     "axilla",
     "Chest at axilla",
     "axilla level",
     kLargeGirthLimit,
     false,
     false,
     true,
     {"across_chest", "Across chest"},
     {"across_back", "Across back"}},
    {"level.chest",
     "chest",
     "Chest",
     "chest level",
     kLargeGirthLimit,
     true,
     true,
     true,
     {"chest_front_arc", "Chest arc, front"},
     {"chest_back_arc", "Chest arc, back"}},
    {"level.under_bust", "under_bust", "Under-bust", "under-bust level", kLargeGirthLimit, false, false, true},
    {"level.waist",
     "waist",
     "Waist",
     "natural waist level",
     kLargeGirthLimit,
     true,
     true,
     true,
     {"waist_front_arc", "Waist arc, front"},
     {"waist_back_arc", "Waist arc, back"}},
    {"level.omphalion", "omphalion", "Abdominal", "omphalion level", kLargeGirthLimit, false, false, false},
    {"level.iliac", "top_hip", "Top hip", "top hip level", kLargeGirthLimit, false, false, false},
    {"level.hip",
     "hip",
     "Hip",
     "hip level",
     kLargeGirthLimit,
     true,
     true,
     true,
     {"hip_front_arc", "Hip arc, front"},
     {"hip_back_arc", "Hip arc, back"}},
    {"level.crotch", "crotch", "Crotch level", "crotch level", kLargeGirthLimit, false, false, false},
}};

void AddArc(MeasurementList& list, const LevelMeasures& section, ArcSide side, const LevelRow& row) {
  const ArcWords& words = side == ArcSide::kFront ? row.front : row.back;
  if (words.id == nullptr) return;
  list.Add(
      {words.id, words.term,
       std::string("The ") + (side == ArcSide::kFront ? "front" : "back") + " part of the horizontal tape at the " +
           row.where + ", parted by the plane halfway between the most forward and the most rearward point.",
       "tape, part", "mm", 0.0},
      section.Arc(side));
}

void AddRow(MeasurementList& list, const LevelRow& row, const LevelMeasures& section) {
  const std::string id = row.id;
  const std::string term = row.term;
  const std::string where = row.where;
  list.Add({id + "_girth", term + " girth", "Horizontal tape girth at the " + where + " (convex hull of the section).",
            "tape, horizontal", "mm", row.girth_limit},
           section.Girth());
  if (row.taut) {
    list.Add({id + "_girth_taut", term + " girth, taut in space",
              "Shortest tape around the body, held at the " + where +
                  " in front, at the back and at both sides, and free by 10 mm elsewhere.",
              "tape, taut in space", "mm", row.girth_limit},
             section.TautGirth());
  }
  if (row.perimeter) {
    list.Add({id + "_perimeter", term + " girth, skin",
              "Length of the section's curve at the " + where + ", hollows followed.", "skin, horizontal", "mm", 0.0},
             section.Perimeter());
  }
  if (row.extents) {
    list.Add({id + "_breadth", term + " breadth", "Extent of the section from side to side at the " + where + ".",
              "extent", "mm", kBreadthLimit},
             section.Breadth());
    list.Add({id + "_depth", term + " depth", "Extent of the section from front to back at the " + where + ".",
              "extent", "mm", kDepthLimit},
             section.Depth());
  }
  AddArc(list, section, ArcSide::kFront, row);
  AddArc(list, section, ArcSide::kBack, row);
}

/// The points around the base of the neck, in the order of a tape.
constexpr std::array<const char*, 4> kNeckBase{"neck_front", "neck_right", "neck_back", "neck_left"};

/// The girth around the base of the neck: taut from point to point.
Result<RawMeasurement> NeckBase(const MeasuredSurface& body, const std::array<const Landmark*, 4>& points) {
  RawMeasurement raw;
  raw.paths.emplace_back();
  double measured = 0.0;
  // A tape's length follows its ends along its own direction there; two tapes meet at every point.
  std::array<Eigen::Vector3d, 4> by_point;
  by_point.fill(Eigen::Vector3d::Zero());
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Landmark& from = *points[k];
    const Landmark& to = *points[(k + 1) % points.size()];
    const auto tape = TautTape(body, PlaceOf(from), PlaceOf(to));
    if (!tape) return Fail(tape);
    raw.estimate = Combine(1.0, raw.estimate, 1.0, tape->length);
    measured += tape->knowledge.measured * tape->length.value;
    raw.landmarks.push_back(from.id);
    std::vector<Eigen::Vector3d>& line = raw.paths.back();
    const std::size_t first = line.size();
    for (const PathPoint& point : tape->path) line.push_back(point.position);
    if (line.size() < first + 2) continue;
    by_point[k] += (line[first] - line[first + 1]).stableNormalized();
    by_point[(k + 1) % points.size()] += (line[line.size() - 1] - line[line.size() - 2]).stableNormalized();
  }
  for (std::size_t k = 0; k < points.size(); ++k) FollowPlace(raw, body, *points[k], by_point[k]);
  raw.height_share = HeightShare(raw.paths.back());
  raw.measured_share = raw.estimate.value > 0.0 ? std::min(1.0, measured / raw.estimate.value) : 0.0;
  return raw;
}

}  // namespace

void AddLevels(MeasurementList& list) {
  const SectionSampler sampler(list.body().surface(), EvenDirections(kDirections));
  for (const LevelRow& row : kRows) {
    const Landmark* landmark = list.Find(row.landmark);
    if (landmark == nullptr) continue;
    const auto section = LevelMeasures::At(list.body(), sampler, *landmark, list.front());
    if (section) {
      AddRow(list, row, *section);
    } else {
      list.Omit(std::string(row.term) + " girth", section.error().seen);
    }
  }
  std::array<const Landmark*, 4> points{};
  for (std::size_t k = 0; k < points.size(); ++k) points[k] = list.Find(kNeckBase[k]);
  if (std::find(points.begin(), points.end(), nullptr) != points.end()) return;
  list.Add({"neck_base_girth", "Neck base girth",
            "Taut tape over the skin from the front neck point over the right side neck point, the back neck point and "
            "the left side neck point.",
            "tape, taut over the skin", "mm", kSmallGirthLimit},
           NeckBase(list.body(), points));
}

}  // namespace annulus
