// Girths, extents and arcs of horizontal sections, heights, and the parts of the body between levels.

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
  bool arcs;
};
constexpr std::array<LevelRow, 10> kRows{{
    {"level.head", "head", "Head", "head level", kHeadOverHairLimit, false, true, false, true},
    {"level.neck", "neck", "Neck", "neck level", kSmallGirthLimit, false, true, true, false},
    {"level.axilla", "axilla", "Chest at axilla", "axilla level", kLargeGirthLimit, false, false, true, false},
    {"level.chest", "chest", "Chest", "chest level", kLargeGirthLimit, true, true, true, true},
    {"level.under_bust", "under_bust", "Under-bust", "under-bust level", kLargeGirthLimit, false, false, true, false},
    {"level.waist", "waist", "Waist", "natural waist level", kLargeGirthLimit, true, true, true, true},
    {"level.omphalion", "omphalion", "Abdominal", "omphalion level", kLargeGirthLimit, false, false, false, false},
    {"level.iliac", "top_hip", "Top hip", "top hip level", kLargeGirthLimit, false, false, false, false},
    {"level.hip", "hip", "Hip", "hip level", kLargeGirthLimit, true, true, true, true},
    {"level.crotch", "crotch", "Crotch level", "crotch level", kLargeGirthLimit, false, false, false, false},
}};

/// The widths of the torso's front and back between the arms are arcs of the axilla level.
struct AcrossRow {
  ArcSide side;
  const char* id;
  const char* term;
  const char* part;
};
constexpr std::array<AcrossRow, 2> kAcross{{{ArcSide::kFront, "across_chest", "Across chest", "front"},
                                            {ArcSide::kBack, "across_back", "Across back", "back"}}};

void AddNamed(MeasurementList& list, RawMeasurement raw, MeasurementSpec spec) {
  raw.spec = std::move(spec);
  list.Add(std::move(raw));
}

void AddArc(MeasurementList& list, const LevelMeasures& section, const AcrossRow& row, const std::string& where) {
  AddNamed(list, section.Arc(row.side),
           {row.id, row.term,
            std::string("The ") + row.part + " part of the horizontal tape at the " + where +
                ", parted by the plane halfway between the most forward and the most rearward point.",
            "tape, part", "mm", 0.0});
}

void AddRow(MeasurementList& list, const LevelRow& row, const LevelMeasures& section) {
  const std::string id = row.id;
  const std::string term = row.term;
  const std::string where = row.where;
  AddNamed(list, section.Girth(),
           {id + "_girth", term + " girth", "Horizontal tape girth at the " + where + " (convex hull of the section).",
            "tape, horizontal", "mm", row.girth_limit});
  if (row.taut) {
    const MeasurementSpec spec{id + "_girth_taut",
                               term + " girth, taut in space",
                               "Shortest tape around the body, held at the " + where +
                                   " in front, at the back and at both sides, and free by 10 mm elsewhere.",
                               "tape, taut in space",
                               "mm",
                               row.girth_limit};
    auto raw = section.TautGirth();
    if (raw) raw->spec = spec;
    list.Add(spec, std::move(raw));
  }
  if (row.perimeter) {
    AddNamed(list, section.Perimeter(),
             {id + "_perimeter", term + " girth, skin",
              "Length of the section's curve at the " + where + ", hollows followed.", "skin, horizontal", "mm", 0.0});
  }
  if (row.extents) {
    AddNamed(list, section.Breadth(),
             {id + "_breadth", term + " breadth", "Extent of the section from side to side at the " + where + ".",
              "extent", "mm", kBreadthLimit});
    AddNamed(list, section.Depth(),
             {id + "_depth", term + " depth", "Extent of the section from front to back at the " + where + ".",
              "extent", "mm", kDepthLimit});
  }
  if (row.arcs) {
    const std::string front = id + "_front_arc";
    const std::string back = id + "_back_arc";
    AddArc(list, section, {ArcSide::kFront, front.c_str(), (term + " arc, front").c_str(), "front"}, where);
    AddArc(list, section, {ArcSide::kBack, back.c_str(), (term + " arc, back").c_str(), "back"}, where);
  }
  if (id == "axilla") {
    for (const AcrossRow& across : kAcross) AddArc(list, section, across, where);
  }
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
  const MeasurementSpec spec{
      "neck_base_girth",
      "Neck base girth",
      "Taut tape over the skin from the front neck point over the right side neck point, the back "
      "neck point and the left side neck point.",
      "tape, taut over the skin",
      "mm",
      kSmallGirthLimit};
  auto raw = NeckBase(list.body(), points);
  if (raw) raw->spec = spec;
  list.Add(spec, std::move(raw));
}

}  // namespace annulus
