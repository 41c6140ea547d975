// Heights over the floor and between levels.

#include <array>
#include <string>

#include "modeling/measure/surface_path.h"
#include "modeling/table/measurement_groups.h"

namespace annulus {
namespace {

struct HeightRow {
  const char* landmark;
  const char* id;
  const char* term;
};
constexpr std::array<HeightRow, 20> kHeights{{{"vertex", "vertex_height", "Stature (vertex height)"},
                                              {"eye_right", "eye_height", "Eye height"},
                                              {"menton", "chin_height", "Chin height"},
                                              {"level.head", "head_height", "Head girth height"},
                                              {"level.neck", "neck_height", "Neck girth height"},
                                              {"neck_back", "cervicale_height", "Cervicale height"},
                                              {"neck_front", "front_neck_height", "Front neck height"},
                                              {"neck_right", "side_neck_height_right", "Side neck height, right"},
                                              {"neck_left", "side_neck_height_left", "Side neck height, left"},
                                              {"shoulder_right", "shoulder_height_right", "Shoulder height, right"},
                                              {"shoulder_left", "shoulder_height_left", "Shoulder height, left"},
                                              {"level.axilla", "axilla_height", "Axilla height"},
                                              {"level.chest", "chest_height", "Chest height"},
                                              {"level.under_bust", "under_bust_height", "Under-bust height"},
                                              {"level.waist", "waist_height", "Waist height"},
                                              {"level.omphalion", "omphalion_height", "Omphalion height"},
                                              {"level.iliac", "top_hip_height", "Top hip height"},
                                              {"level.hip", "hip_height", "Hip height"},
                                              {"level.crotch", "crotch_height", "Crotch height (inside leg)"},
                                              {"bust_right", "bust_point_height", "Bust point height"}}};

struct DropRow {
  const char* upper;
  const char* lower;
  const char* id;
  const char* term;
};
constexpr std::array<DropRow, 4> kDrops{
    {{"neck_back", "level.waist", "cervicale_to_waist_drop", "Cervicale to waist, vertical"},
     {"level.chest", "level.waist", "chest_to_waist_drop", "Chest to waist, vertical"},
     {"level.waist", "level.hip", "waist_to_hip_drop", "Waist to hip, vertical"},
     {"level.waist", "level.crotch", "body_rise", "Waist to crotch, vertical (body rise)"}}};

RawMeasurement HeightOf(const MeasuredSurface& body, const Landmark& landmark) {
  RawMeasurement raw;
  raw.estimate = {landmark.z.value, {}};
  Follow(raw, landmark.z, 1.0, landmark.placing_up);
  raw.height_share = landmark.z.value;
  raw.height_offset = 1.0;
  raw.landmarks = {landmark.id};
  raw.measured_share =
      landmark.kind == LandmarkKind::kLevel
          ? KnowledgeOfLevel(body, landmark.z.value).measured
          : (body.KnowledgeAt(landmark.theta.value, landmark.z.value) == Knowledge::kMeasured ? 1.0 : 0.0);
  return raw;
}

}  // namespace

void AddHeights(MeasurementList& list) {
  const bool over_floor = list.body().surface().z_min() >= 0.0;  // tables from elsewhere may count z from anywhere
  if (!over_floor) list.Omit("Heights above the floor", "the scan reaches below z = 0, which is no floor then");
  for (const HeightRow& row : kHeights) {
    const Landmark* landmark = list.Find(row.landmark);
    if (landmark == nullptr || !over_floor) continue;
    list.Add(
        {row.id, row.term, "Height of " + landmark->term + " above the station's floor.", "height", "mm", kHeightLimit},
        HeightOf(list.body(), *landmark));
  }
  for (const DropRow& row : kDrops) {
    const Landmark* upper = list.Find(row.upper);
    const Landmark* lower = list.Find(row.lower);
    if (upper == nullptr || lower == nullptr) continue;
    RawMeasurement raw = HeightOf(list.body(), *upper);
    const RawMeasurement below = HeightOf(list.body(), *lower);
    raw.estimate = Combine(1.0, raw.estimate, -1.0, below.estimate);
    raw.placing_variance += below.placing_variance;
    raw.height_share = raw.estimate.value;
    raw.height_offset = 0.0;
    raw.measured_share = 0.5 * (raw.measured_share + below.measured_share);
    raw.landmarks.push_back(lower->id);
    list.Add({row.id, row.term, "Difference of the heights of " + upper->term + " and " + lower->term + ".",
              "height difference", "mm", kSegmentLengthLimit},
             std::move(raw));
  }
}

}  // namespace annulus
