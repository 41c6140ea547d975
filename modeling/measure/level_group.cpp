// Girths, extents and arcs of horizontal sections, heights, and the parts of the body between levels.

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <utility>

#include "modeling/measure/level_measures.h"
#include "modeling/measure/measurement_groups.h"
#include "modeling/measure/place_geometry.h"
#include "modeling/measure/plane_cut.h"

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
  bool perimeter;
  bool extents;
  bool arcs;
};
constexpr std::array<LevelRow, 10> kRows{{
    {"level.head", "head", "Head", "head level", kHeadOverHairLimit, true, false, true},
    {"level.neck", "neck", "Neck", "neck level", kSmallGirthLimit, true, true, false},
    {"level.axilla", "axilla", "Chest at axilla", "axilla level", kLargeGirthLimit, false, true, false},
    {"level.chest", "chest", "Chest", "chest level", kLargeGirthLimit, true, true, true},
    {"level.under_bust", "under_bust", "Under-bust", "under-bust level", kLargeGirthLimit, false, true, false},
    {"level.waist", "waist", "Waist", "natural waist level", kLargeGirthLimit, true, true, true},
    {"level.omphalion", "omphalion", "Abdominal", "omphalion level", kLargeGirthLimit, false, false, false},
    {"level.iliac", "top_hip", "Top hip", "top hip level", kLargeGirthLimit, false, false, false},
    {"level.hip", "hip", "Hip", "hip level", kLargeGirthLimit, true, true, true},
    {"level.crotch", "crotch", "Crotch level", "crotch level", kLargeGirthLimit, false, false, false},
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
            "tape, part", "mm", kLargeGirthLimit});
}

void AddRow(MeasurementList& list, const LevelRow& row, const LevelMeasures& section) {
  const std::string id = row.id;
  const std::string term = row.term;
  const std::string where = row.where;
  AddNamed(list, section.Girth(),
           {id + "_girth", term + " girth", "Horizontal tape girth at the " + where + " (convex hull of the section).",
            "tape, horizontal", "mm", row.girth_limit});
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

/// The girth around the base of the neck, in the plane through the front and back neck points that is level from side
/// to side.
Result<RawMeasurement> NeckBase(const MeasuredSurface& body, const Landmark& front, const Landmark& back) {
  const Eigen::Vector3d p = FrameAt(body, PlaceOf(front)).position;
  const Eigen::Vector3d q = FrameAt(body, PlaceOf(back)).position;
  const auto plane_through = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector3d along = a - b;
    const Eigen::Vector3d aside = Eigen::Vector3d::UnitZ().cross(along);
    const Eigen::Vector3d normal = along.cross(aside).normalized();
    return CuttingPlane{normal, normal.dot(a)};
  };
  auto girth = GirthInPlane(body, plane_through(p, q));
  if (!girth) return Fail(girth);
  RawMeasurement raw;
  raw.estimate = girth->tape;
  raw.measured_share = girth->knowledge.measured;
  raw.landmarks = {front.id, back.id};
  raw.paths.emplace_back();
  for (const PathPoint& point : girth->tape_path) raw.paths.back().push_back(point.position);
  if (!raw.paths.back().empty()) raw.paths.back().push_back(raw.paths.back().front());
  raw.height_share = HeightShare(raw.paths.back());
  // The plane is raised and tilted by its two points: differences of 2 mm.
  constexpr double kStep = 2.0;
  for (const auto& [landmark, a, b] : {std::tuple{&front, kStep, 0.0}, std::tuple{&back, 0.0, kStep}}) {
    const auto raised =
        GirthInPlane(body, plane_through(p + a * Eigen::Vector3d::UnitZ(), q + b * Eigen::Vector3d::UnitZ()));
    if (!raised) return Fail(raised);
    const double by_height = (raised->tape.value - girth->tape.value) / kStep;
    FollowPoint(raw, body, *landmark, by_height * Eigen::Vector3d::UnitZ());
  }
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
  const Landmark* front = list.Find("neck_front");
  const Landmark* back = list.Find("neck_back");
  if (front == nullptr || back == nullptr) return;
  const MeasurementSpec spec{"neck_base_girth",
                             "Neck base girth",
                             "Tape girth in the plane through the front and back neck points, level from side to side.",
                             "tape, tilted",
                             "mm",
                             kSmallGirthLimit};
  auto raw = NeckBase(list.body(), *front, *back);
  if (raw) raw->spec = spec;
  list.Add(spec, std::move(raw));
}

}  // namespace annulus
