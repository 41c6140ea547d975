#include "modeling/landmarks/landmark_catalog.h"

#include <algorithm>
#include <array>
#include <string>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr LandmarkKind kLevel = LandmarkKind::kLevel;
constexpr LandmarkKind kPoint = LandmarkKind::kPoint;

constexpr std::array<LandmarkEntry, 18> kCatalog{{
    {"level.head", "Head girth level",
     "Height of the largest horizontal tape girth above the ears, where hollows of the section begin.", kLevel},
    {"level.neck", "Neck level", "Height of the smallest horizontal tape girth below the head.", kLevel},
    {"neck_back", "Back neck point (cervicale)",
     "In the mid-plane behind, where the back's profile bulges most, over a chord of 50 mm, within 50 mm of the height "
     "of the side neck points; without a bulge, at that height.",
     kPoint},
    {"neck_right", "Side neck point, right",
     "On the outline seen from the front, where it first slopes by 45 degrees going down from the neck to the right "
     "shoulder.",
     kPoint},
    {"neck_left", "Side neck point, left",
     "On the outline seen from the front, where it first slopes by 45 degrees going down from the neck to the left "
     "shoulder.",
     kPoint},
    {"neck_front", "Front neck point",
     "Point of the mid-plane in front that is set back most between the chin and the chest (the pit of the neck).",
     kPoint},
    {"shoulder_right", "Shoulder point, right",
     "On the outline seen from the front, where it turns down by more than 45 degrees again outside the right "
     "shoulder's top line.",
     kPoint},
    {"shoulder_left", "Shoulder point, left",
     "On the outline seen from the front, where it turns down by more than 45 degrees again outside the left "
     "shoulder's top line.",
     kPoint},
    {"level.axilla", "Axilla level",
     "25 mm below the mean upper end of what the arms hide of the trunk, because the groove beside an arm hides more "
     "than "
     "the armpit; without arms, where the breadth grows most suddenly.",
     kLevel},
    {"level.chest", "Chest (bust) level",
     "Height of the largest horizontal tape girth between axilla and waist; where the girth does not fall by 0.25 % "
     "above it, of the most forward part of the chest.",
     kLevel},
    {"bust_right", "Bust point, right", "Most forward point of the chest's right half about the chest level.", kPoint},
    {"bust_left", "Bust point, left", "Most forward point of the chest's left half about the chest level.", kPoint},
    {"level.under_bust", "Under-bust level",
     "Height at which the front outline, seen from the side, is bent inwards most between chest and waist.", kLevel},
    {"level.waist", "Natural waist level", "Height of the smallest horizontal tape girth between chest and hip.",
     kLevel},
    {"level.omphalion", "Omphalion level",
     "Height of the navel, if the ring sees its hollow in the mid-plane; else a quarter of the way from waist to hip.",
     kLevel},
    {"level.iliac", "Top hip (iliac) level", "Midway between natural waist and hip: no ring sees the iliac crest.",
     kLevel},
    {"level.hip", "Hip level", "Height of the largest horizontal tape girth below the waist.", kLevel},
    {"level.crotch", "Crotch level",
     "Lowest height at which the section is one loop, if the clefts of the legs show there in front and behind.",
     kLevel},
}};

}  // namespace

std::span<const LandmarkEntry> BodyLandmarkCatalog() { return kCatalog; }

Landmark FromCatalog(std::string_view id) {
  const auto* const entry =
      std::find_if(kCatalog.begin(), kCatalog.end(), [&](const LandmarkEntry& e) { return e.id == id; });
  ENSURE(entry != kCatalog.end(), "the catalogue holds " + std::string(id));
  Landmark landmark;
  landmark.id = entry->id;
  landmark.term = entry->term;
  landmark.definition = entry->definition;
  landmark.kind = entry->kind;
  return landmark;
}

std::string OmittedText(std::string_view id, std::string_view why) {
  return FromCatalog(id).term + ": " + std::string(why) + ".";
}

}  // namespace annulus
