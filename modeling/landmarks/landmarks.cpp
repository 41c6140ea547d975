#include "modeling/landmarks/landmarks.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "modeling/landmarks/body_landmarks.h"
#include "modeling/landmarks/body_levels.h"
#include "modeling/landmarks/body_shape.h"
#include "modeling/landmarks/head_landmarks.h"
#include "modeling/landmarks/landmark_catalog.h"

namespace annulus {
namespace {

/// Where the subject looks: the trunk says it best, then the eyes.
double FrontOf(const BodyShape& shape, const Landmarks& head) {
  if (shape.waist || shape.hip) return shape.front;
  const Landmark* right = head.Find("eye_right");
  const Landmark* left = head.Find("eye_left");
  if (right == nullptr || left == nullptr) return shape.front;
  const Eigen::Vector3d across = right->position - left->position;
  return std::atan2(across.y(), across.x()) + kPi / 2.0;
}

}  // namespace

Landmarks FindLandmarks(const MeasuredSurface& body, const TaskContext& context) {
  const BodyShape shape = FindBodyShape(body, context);
  Landmarks head = FindHeadLandmarks(body);
  Landmarks levels = FindLevels(body, shape);
  Landmarks points = FindBodyPoints(body, shape, levels);
  Landmarks all;
  all.front = FrontOf(shape, head);
  for (const Landmark& entry : AllLandmarks()) {
    for (Landmarks* part : {&head, &levels, &points}) {
      const auto found = std::find_if(part->found.begin(), part->found.end(),
                                      [&](const Landmark& landmark) { return landmark.id == entry.id; });
      if (found != part->found.end()) all.found.push_back(std::move(*found));
    }
  }
  for (Landmarks* part : {&head, &levels, &points}) {
    std::move(part->omitted.begin(), part->omitted.end(), std::back_inserter(all.omitted));
  }
  return all;
}

std::vector<Landmark> AllLandmarks() {
  std::vector<Landmark> all;
  for (const HeadLandmarkEntry& entry : HeadLandmarkCatalog()) {
    Landmark landmark;
    landmark.id = entry.id;
    landmark.term = entry.term;
    landmark.definition = entry.definition;
    landmark.kind = entry.kind;
    all.push_back(std::move(landmark));
  }
  for (const LandmarkEntry& entry : BodyLandmarkCatalog()) all.push_back(FromCatalog(entry.id));
  return all;
}

}  // namespace annulus
