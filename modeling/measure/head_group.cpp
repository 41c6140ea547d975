// Measurements of head and face.

#include <array>
#include <string>

#include "modeling/measure/measurement_groups.h"
#include "modeling/measure/place_geometry.h"
#include "modeling/measure/plane_cut.h"

namespace annulus {
namespace {

struct DistanceRow {
  const char* a;
  const char* b;
  const char* id;
  const char* term;
  double limit;
};
constexpr std::array<DistanceRow, 13> kDistances{{
    {"glabella", "opisthocranion", "head_length", "Head length", kHeadOverHairLimit},
    {"euryon_right", "euryon_left", "head_breadth", "Head breadth", kHeadOverHairLimit},
    {"tragion_right", "tragion_left", "bitragion_breadth", "Bitragion breadth", kFaceLimit},
    {"zygion_right", "zygion_left", "face_breadth", "Face breadth (bizygomatic)", kFaceLimit},
    {"gonion_right", "gonion_left", "jaw_breadth", "Jaw breadth (bigonial)", kFaceLimit},
    {"temple_right", "temple_left", "temple_breadth", "Breadth at the temples", kFaceLimit},
    {"sellion", "menton", "face_length", "Face length (sellion to menton)", kFaceLimit},
    {"sellion", "pronasale", "nose_length", "Nose length", kFaceLimit},
    {"alare_right", "alare_left", "nose_breadth", "Nose breadth", kFaceLimit},
    {"eye_right", "eye_left", "pupil_distance", "Pupil distance, estimated", kFaceLimit},
    {"temple_right", "otobasion_superius_right", "temple_to_ear_right", "Temple to ear, right", kFaceLimit},
    {"temple_left", "otobasion_superius_left", "temple_to_ear_left", "Temple to ear, left", kFaceLimit},
    {"pronasale", "opisthocranion", "head_depth_to_nose", "Head depth with nose", kHeadOverHairLimit},
}};

/// An arc over the skin from ear to ear, in the plane through both tragions and a point between.
struct ArcRow {
  const char* via;
  const char* id;
  const char* term;
};
constexpr std::array<ArcRow, 3> kArcs{{{"glabella", "bitragion_frontal_arc", "Bitragion frontal arc"},
                                       {"menton", "bitragion_menton_arc", "Bitragion menton arc"},
                                       {"opisthocranion", "bitragion_back_arc", "Bitragion back arc"}}};

/// How far the ends of an arc move it: d(length)/d(position), by the arc's first and last direction. The point between
/// turns the plane, which changes the length in second order where the arc is near the shortest; by differences here.
Result<RawMeasurement> EarToEar(const MeasuredSurface& body, const Landmark& right, const Landmark& via,
                                const Landmark& left) {
  const auto length = [&](double via_up) {
    return DistanceByPlane(body, PlaceOf(right), {via.theta.value, via.z.value + via_up}, PlaceOf(left),
                           CutMethod::kSpline);
  };
  auto arc = length(0.0);
  if (!arc) return Fail(arc);
  RawMeasurement raw;
  raw.measured_share = arc->knowledge.measured;
  raw.estimate = arc->length;
  raw.landmarks = {right.id, via.id, left.id};
  raw.paths.emplace_back();
  for (const PathPoint& point : arc->path) raw.paths.back().push_back(point.position);
  raw.height_share = HeightShare(raw.paths.back());
  constexpr double kStep = 2.0;  // mm
  if (const auto raised = length(kStep)) {
    Follow(raw, via.z, (raised->length.value - arc->length.value) / kStep, via.placing_up);
  }
  const std::vector<Eigen::Vector3d>& line = raw.paths.back();
  if (line.size() < 2) return raw;
  FollowPlace(raw, body, right, (line[0] - line[1]).stableNormalized());
  FollowPlace(raw, body, left, (line[line.size() - 1] - line[line.size() - 2]).stableNormalized());
  return raw;
}

}  // namespace

void AddDistance(MeasurementList& list, const std::array<const char*, 2>& ends, MeasurementSpec spec) {
  const Landmark* a = list.Find(ends[0]);
  const Landmark* b = list.Find(ends[1]);
  if (a == nullptr || b == nullptr) return;
  RawMeasurement raw = StraightDistance(list.body(), *a, *b);
  spec.definition = "Straight distance from " + a->term + " to " + b->term + ".";
  raw.spec = std::move(spec);
  list.Add(std::move(raw));
}

void AddHead(MeasurementList& list) {
  for (const DistanceRow& row : kDistances) {
    AddDistance(list, {row.a, row.b}, {row.id, row.term, "", "straight line", "mm", row.limit});
  }
  const Landmark* right = list.Find("tragion_right");
  const Landmark* left = list.Find("tragion_left");
  for (const ArcRow& row : kArcs) {
    const Landmark* via = list.Find(row.via);
    if (right == nullptr || left == nullptr || via == nullptr) continue;
    const MeasurementSpec spec{
        row.id,
        row.term,
        "Length over the skin from the right to the left tragion in the plane through " + via->term + ".",
        "skin, plane cut",
        "mm",
        kSegmentLengthLimit};
    auto raw = EarToEar(list.body(), *right, *via, *left);
    if (raw) raw->spec = spec;
    list.Add(spec, std::move(raw));
  }
}

}  // namespace annulus
