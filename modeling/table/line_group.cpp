// Lengths along the skin of front, back and sides; shoulders and bust points.

#include <array>
#include <cmath>
#include <string>

#include "base/units.h"
#include "modeling/landmarks/mid_direction.h"
#include "modeling/measure/section.h"
#include "modeling/measure/surface_path.h"
#include "modeling/table/measurement_groups.h"
#include "modeling/table/place_geometry.h"

namespace annulus {
namespace {

/// Where on the body a line runs down: quarter turns from the front, counter-clockwise seen from above.
enum class LineSide { kFront = 0, kLeft = 1, kBack = 2, kRight = 3 };

struct LineRow {
  const char* upper;
  const char* lower;
  LineSide side;
  const char* id;
  const char* term;
};
constexpr std::array<LineRow, 10> kLines{
    {{"neck_front", "level.waist", LineSide::kFront, "neck_to_waist_front", "Neck to waist, front"},
     {"neck_back", "level.waist", LineSide::kBack, "neck_to_waist_back", "Neck to waist, back"},
     {"neck_back", "level.axilla", LineSide::kBack, "scye_depth", "Cervicale to axilla level (scye depth)"},
     {"level.chest", "level.waist", LineSide::kFront, "chest_to_waist_front", "Chest to waist, front"},
     {"level.waist", "level.hip", LineSide::kFront, "waist_to_hip_front", "Waist to hip, front"},
     {"level.waist", "level.hip", LineSide::kBack, "waist_to_hip_back", "Waist to hip, back"},
     {"level.waist", "level.hip", LineSide::kRight, "waist_to_hip_right", "Waist to hip, right side"},
     {"level.waist", "level.hip", LineSide::kLeft, "waist_to_hip_left", "Waist to hip, left side"},
     {"level.waist", "level.iliac", LineSide::kRight, "waist_to_top_hip", "Waist to top hip, right side"},
     {"level.axilla", "level.waist", LineSide::kRight, "side_seam_upper", "Axilla to waist, right side"}}};

const char* SideWord(LineSide side) {
  switch (side) {
    case LineSide::kFront:
      return "front mid line";
    case LineSide::kBack:
      return "back mid line";
    case LineSide::kRight:
      return "right side";
    case LineSide::kLeft:
      return "left side";
  }
  return "";
}

/// The direction in which the line runs, rad: through the upper point, or where the side's mid-plane meets the section.
double DirectionOf(const MeasurementList& list, const LineRow& row, const Landmark& upper, const Landmark& lower) {
  if (upper.kind == LandmarkKind::kPoint) return upper.theta.value;
  const double quarters = static_cast<double>(static_cast<int>(row.side));
  return MidDirection(list.body(), list.front() + quarters * kPi / 2.0, 0.5 * (upper.z.value + lower.z.value));
}

std::vector<Eigen::Vector3d> LineOf(const MeasuredSurface& body, double theta, double low, double high) {
  constexpr int kPoints = 60;
  std::vector<Eigen::Vector3d> line;
  for (int k = 0; k <= kPoints; ++k) line.push_back(body.surface().Point(theta, high + (low - high) * k / kPoints));
  return line;
}

/// The length along the meridian and how it follows its ends.
using MeridianMeasure = Result<Estimate> (*)(const MeasuredSurface&, double, double, double);
Result<RawMeasurement> LineLength(const MeasurementList& list, const LineRow& row, const Landmark& upper,
                                  const Landmark& lower, MeridianMeasure measure) {
  const MeasuredSurface& body = list.body();
  const double theta = DirectionOf(list, row, upper, lower);
  const auto length = measure(body, theta, lower.z.value, upper.z.value);
  if (!length) return Fail(length);
  RawMeasurement raw;
  raw.estimate = *length;
  raw.landmarks = {upper.id, lower.id};
  raw.paths = {LineOf(body, theta, lower.z.value, upper.z.value)};
  std::vector<PathPoint> points;
  for (int k = 0; k <= 200; ++k) {
    points.push_back(RadialPoint(body.surface(), {theta, lower.z.value + (upper.z.value - lower.z.value) * k / 200.0}));
  }
  raw.measured_share = KnowledgeAlong(body, points, PathEnds::kOpen).measured;
  // At the ends the line grows by its slope; sideways by differences.
  const auto speed = [&](double z) { return std::hypot(1.0, body.surface().Jet(theta, z).r_z); };
  Follow(raw, upper.z, speed(upper.z.value), upper.placing_up / speed(upper.z.value));
  Follow(raw, lower.z, -speed(lower.z.value), lower.placing_up / speed(lower.z.value));
  if (upper.kind == LandmarkKind::kPoint) {
    constexpr double kStep = 0.01;  // rad
    const auto aside = measure(body, theta + kStep, lower.z.value, upper.z.value);
    const double by_theta = aside ? (aside->value - length->value) / kStep : 0.0;
    const double across = FrameAt(body, PlaceOf(upper)).by_theta.norm();
    Follow(raw, upper.theta, by_theta, across > 0.0 ? upper.placing_across / across : 0.0);
  }
  raw.height_share = HeightShare(raw.paths.front());
  return raw;
}

void AddLine(MeasurementList& list, const LineRow& row) {
  const Landmark* upper = list.Find(row.upper);
  const Landmark* lower = list.Find(row.lower);
  if (upper == nullptr || lower == nullptr) return;
  const std::string between = upper->term + " to " + lower->term + " on the " + SideWord(row.side) + ".";
  for (const auto& [measure, suffix, term, method] : {std::tuple{&MeridianLength, "", "", "skin, vertical"},
                                                      std::tuple{&MeridianTape, "_tape", ", taut", "tape, vertical"}}) {
    const MeasurementSpec spec{
        std::string(row.id) + suffix,
        std::string(row.term) + term,
        (*suffix == 0 ? "Length along the skin from " : "Length of a taut tape over the skin from ") + between,
        method,
        "mm",
        kSegmentLengthLimit};
    list.Add(spec, LineLength(list, row, *upper, *lower, measure));
  }
}

constexpr std::array<DistanceRow, 4> kDistances{
    {{"bust_right", "bust_left", "bust_point_to_bust_point", "Bust point to bust point", kBreadthLimit},
     {"shoulder_right", "shoulder_left", "shoulder_breadth", "Shoulder breadth", kBreadthLimit},
     {"neck_right", "shoulder_right", "shoulder_length_right", "Shoulder length, right", kSegmentLengthLimit},
     {"neck_left", "shoulder_left", "shoulder_length_left", "Shoulder length, left", kSegmentLengthLimit}}};

struct SlopeRow {
  const char* neck;
  const char* shoulder;
  const char* id;
  const char* term;
};
constexpr std::array<SlopeRow, 2> kSlopes{
    {{"neck_right", "shoulder_right", "shoulder_slope_right", "Shoulder slope, right"},
     {"neck_left", "shoulder_left", "shoulder_slope_left", "Shoulder slope, left"}}};

}  // namespace

void AddLines(MeasurementList& list) {
  for (const LineRow& row : kLines) AddLine(list, row);
  AddDistances(list, kDistances);
  for (const SlopeRow& row : kSlopes) {
    const Landmark* neck = list.Find(row.neck);
    const Landmark* shoulder = list.Find(row.shoulder);
    if (neck == nullptr || shoulder == nullptr) continue;
    list.Add({row.id, row.term,
              "Angle under the horizontal of the straight line from " + neck->term + " to " + shoulder->term + ".",
              "angle", "deg", 0.0},
             SlopeBelowHorizontal(list.body(), *neck, *shoulder));
  }
}

}  // namespace annulus
