#include "modeling/landmarks/landmark_edit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "base/frames.h"
#include "modeling/landmarks/landmarks.h"
#include "modeling/measure/number_text.h"
#include "modeling/measure/surface_path.h"

namespace annulus {
namespace {

constexpr double kWorstPlacing = 100.0;  // mm

/// How many letters must be inserted, removed or changed to make `b` of `a` (Levenshtein's distance).
std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({change, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

/// The three ids that are most like `id`; one that holds it, or is held by it, is like it.
std::string CloseIds(const std::string& id, const std::vector<Landmark>& all) {
  constexpr std::size_t kLongest = 64;  // letters of an unknown id that are compared
  const std::string_view asked = std::string_view(id).substr(0, kLongest);
  std::vector<std::pair<std::size_t, std::string>> ranked;
  for (const Landmark& landmark : all) {
    const bool holds = !asked.empty() && landmark.id.find(asked) != std::string::npos;
    ranked.emplace_back(holds ? 1 : EditDistance(asked, landmark.id), landmark.id);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::string text;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, ranked.size()); ++k) {
    text += (k == 0 ? "" : ", ") + ranked[k].second;
  }
  return text;
}

Status CheckNumbers(const GivenLandmark& given, LandmarkKind kind, const std::string& attempted) {
  if (!std::isfinite(given.z) || (given.theta && !std::isfinite(*given.theta))) {
    return Fail(attempted, "its place is not a finite number", "give finite numbers");
  }
  if (!(given.placing >= 0.0 && given.placing <= kWorstPlacing)) {
    return Fail(attempted, "its sd is not from 0 to 100 mm",
                "give how well it was placed, " + NumberText(kPlacingByHand) + " mm as a rule");
  }
  if (kind == LandmarkKind::kPoint && !given.theta) {
    return Fail(attempted, "a point needs theta and z", "give id=THETA,Z in degrees and mm");
  }
  if (kind == LandmarkKind::kLevel && given.theta) {
    return Fail(attempted, "a level has no theta", "give id=Z in mm");
  }
  return {};
}

Status CheckSeen(const MeasuredSurface& body, const GivenLandmark& given, const std::string& attempted) {
  RETURN_IF_ERROR(CheckInRange(body, given.z, attempted));
  if (given.theta) {
    if (body.KnowledgeAt(*given.theta, given.z) != Knowledge::kUnknown) return {};
    return Fail(attempted, "the ring did not see that place", "choose a place on the data");
  }
  const std::size_t columns = std::max<std::size_t>(1, body.segment().knowledge.columns());
  std::size_t seen = 0;
  for (std::size_t k = 0; k < columns; ++k) {
    const double theta = kTwoPi * static_cast<double>(k) / static_cast<double>(columns);
    if (body.KnowledgeAt(theta, given.z) != Knowledge::kUnknown) ++seen;
  }
  if (2 * seen >= columns) return {};
  return Fail(attempted, "the ring saw less than half of the section there", "choose a height on the data");
}

}  // namespace

Result<Landmarks> SetByHand(const MeasuredSurface& body, const Landmarks& landmarks, const GivenLandmark& given) {
  const std::string attempted = "set landmark '" + given.id + "'";
  const std::vector<Landmark> all = AllLandmarks();
  const auto entry = std::find_if(all.begin(), all.end(), [&](const Landmark& known) { return known.id == given.id; });
  if (entry == all.end()) {
    return Fail(attempted, "no landmark has this id", "the closest are " + CloseIds(given.id, all));
  }
  RETURN_IF_ERROR(CheckNumbers(given, entry->kind, attempted));
  RETURN_IF_ERROR(CheckSeen(body, given, attempted));

  Landmark set = *entry;
  set.source = LandmarkSource::kGiven;
  set.confidence = 1.0;
  set.z = {given.z, {}};
  set.placing_up = given.placing;
  set.position = {0.0, 0.0, given.z};
  if (given.theta) {
    set.theta = {WrapAngle(*given.theta), {}};
    set.placing_across = given.placing;
    set.position = body.Point(set.theta.value, given.z);
  }
  // In the order of all landmarks; no sentence says any more that it is missing.
  Landmarks edited;
  edited.front = landmarks.front;
  for (const Landmark& known : all) {
    const Landmark* found = known.id == given.id ? &set : landmarks.Find(known.id);
    if (found != nullptr) edited.found.push_back(*found);
  }
  const std::string missing = entry->term + ": ";
  for (const std::string& sentence : landmarks.omitted) {
    if (!sentence.starts_with(missing)) edited.omitted.push_back(sentence);
  }
  return edited;
}

}  // namespace annulus
