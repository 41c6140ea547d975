// Measurements of head and face.

#include <array>
#include <string>

#include "modeling/measure/plane_cut.h"
#include "modeling/table/measurement_groups.h"
#include "modeling/table/place_geometry.h"

namespace annulus {
namespace {

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

Result<SurfaceDistance> ArcThrough(const MeasuredSurface& body, const std::array<SurfacePlace, 3>& places) {
  return DistanceByPlane(body, places[0], places[1], places[2], CutMethod::kSpline);
}

/// What an arc of the length `here` (mm) gains where one of its three places moves over the skin by a step; if it
/// cannot go that way, what it loses on the other. The places turn the plane, so that no closed form is at hand.
Result<double> GainByMoving(const MeasuredSurface& body, std::array<SurfacePlace, 3> places, double here,
                            std::size_t moved, const SurfacePlace& step) {
  const SurfacePlace start = places[moved];
  places[moved] = {start.theta + step.theta, start.z + step.z};
  if (const auto there = ArcThrough(body, places)) return there->length.value - here;
  places[moved] = {start.theta - step.theta, start.z - step.z};
  const auto there = ArcThrough(body, places);
  if (!there) return Fail(there);
  return here - there->length.value;
}

/// The arc, which moves with its three landmarks.
Result<RawMeasurement> EarToEar(const MeasuredSurface& body, const std::array<const Landmark*, 3>& points) {
  const std::array<SurfacePlace, 3> places{PlaceOf(*points[0]), PlaceOf(*points[1]), PlaceOf(*points[2])};
  const auto arc = ArcThrough(body, places);
  if (!arc) return Fail(arc);
  RawMeasurement raw;
  raw.measured_share = arc->knowledge.measured;
  raw.estimate = arc->length;
  raw.paths.emplace_back();
  for (const PathPoint& point : arc->path) raw.paths.back().push_back(point.position);
  raw.height_share = HeightShare(raw.paths.back());
  constexpr double kStep = 1.0;  // mm
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Landmark& point = *points[k];
    raw.landmarks.push_back(point.id);
    const PlaceFrame frame = FrameAt(body, places[k]);
    const double by_theta = frame.by_theta.norm();
    const double by_z = frame.by_z.norm();
    const auto up = GainByMoving(body, places, arc->length.value, k, {0.0, kStep / by_z});
    const auto across = GainByMoving(body, places, arc->length.value, k, {kStep / by_theta, 0.0});
    if (!up) return Fail(up);
    if (!across) return Fail(across);
    Follow(raw, point.z, *up * by_z / kStep, point.placing_up / by_z);
    Follow(raw, point.theta, *across * by_theta / kStep, point.placing_across / by_theta);
  }
  return raw;
}

}  // namespace

void AddHead(MeasurementList& list) {
  AddDistances(list, kDistances);
  const Landmark* right = list.Find("tragion_right");
  const Landmark* left = list.Find("tragion_left");
  for (const ArcRow& row : kArcs) {
    const Landmark* via = list.Find(row.via);
    if (right == nullptr || left == nullptr || via == nullptr) continue;
    list.Add({row.id, row.term,
              "Length over the skin from the right to the left tragion in the plane through " + via->term + ".",
              "skin, plane cut", "mm", 0.0},
             EarToEar(list.body(), {right, via, left}));
  }
}

}  // namespace annulus
