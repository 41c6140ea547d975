#include "modeling/landmarks/head_landmarks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "base/ensure.h"
#include "base/frames.h"
#include "modeling/landmarks/head_features.h"

namespace annulus {
namespace {

constexpr LandmarkKind kLevel = LandmarkKind::kLevel;
constexpr LandmarkKind kPoint = LandmarkKind::kPoint;

/// A nose of this height, sellion to pronasale, has scale 1, mm.
constexpr double kUsualNose = 38.0;
/// sd of a place by proportion, mm: landmarks vary by about as much between people of one size.
constexpr double kProportionSd = 8.0;

// Placing: simulated heads of statures 1500, 1700 and 1880 mm, 24 scans each (12 at 1 mm pitch and 0.3 mm noise, 12 at
// 5 mm and 0.5 mm), anywhere within 8 mm and 8.6 degrees of the axis, fitted; rms of (found − the same rule on the
// exact head at the axis) less what the fit's covariance tells, the larger of the two pitches: across/up 0.0/0.7
// glabella, 0.0/0.1 sellion, 0.2/0.1 pronasale, 0.0/0.1 menton, 0.0/0.0 opisthocranion, 0.5/0.3 orbitale,
// 0.7/0.2 alare, 0.2/0.3 temple, 0.7/0.9 otobasion, 1.3/0.8 tragion, 0.0/1.0 euryon, 1.3/0.5 zygion, 0.1 vertex. To
// these is added, as a sum of squares, how far the rule on the exact head is from the simulation's own landmark: up 0.6
// glabella, 0.2 sellion and pronasale, 0.0 vertex; across 2.0 otobasion. Eye: the ball on 200 random heads without
// noise, rms 0.07/0.18. Rounded up to half millimetres, 0.5 at least. Where the simulation has no landmark of its own
// the difference between the rule and what a person feels is a judgement, and decides: vertex (hair), menton, orbitale,
// tragion, zygion, gonion.
constexpr std::array<HeadLandmarkEntry, 24> kCatalog{{
    {"vertex", "Vertex",
     "Height of the crown: a ring sees it from the side only, so the area of the uppermost sections is extrapolated to "
     "nothing; hair counts.",
     kLevel, 0.0, 1.0},
    {"glabella", "Glabella",
     "Most forward point of the forehead's mid profile between the brows, as the head is held; where the forehead only "
     "slopes, where it bulges most over a chord of 30 mm.",
     kPoint, 0.5, 1.0},
    {"sellion", "Sellion",
     "Deepest point of the nose's root: where the nose's ridge is hollow along the mid profile and highest across.",
     kPoint, 0.5, 0.5},
    {"pronasale", "Pronasale", "Most forward point of the nose's tip, as the head is held.", kPoint, 0.5, 0.5},
    {"menton", "Menton",
     "Point of the chin's mid profile farthest forwards and down, at 45 degrees: a ring does not see the chin from "
     "below.",
     kPoint, 0.5, 2.0},
    {"opisthocranion", "Opisthocranion",
     "Most rearward point of the head in the mid-plane above the neck; hair counts.", kPoint, 0.5, 1.0},
    {"eye_right", "Eye centre, right",
     "Straight before the centre of the ball of 12.4 mm radius that the open or closed eye makes; where none shows, "
     "the "
     "middle of the socket's hollow under a vertical chord of 40 mm.",
     kPoint, 0.5, 0.5},
    {"eye_left", "Eye centre, left",
     "Straight before the centre of the ball of 12.4 mm radius that the open or closed eye makes; where none shows, "
     "the "
     "middle of the socket's hollow under a vertical chord of 40 mm.",
     kPoint, 0.5, 0.5},
    {"orbitale_right", "Orbitale, right",
     "Below the eye's centre, where the surface recedes most steeply from the cheek into the socket: the bone's rim is "
     "felt, not seen.",
     kPoint, 1.5, 3.0},
    {"orbitale_left", "Orbitale, left",
     "Below the eye's centre, where the surface recedes most steeply from the cheek into the socket: the bone's rim is "
     "felt, not seen.",
     kPoint, 1.5, 3.0},
    {"alare_right", "Alare, right",
     "Beside the nose's tip and 3 mm below it, where the surface is most hollow over a horizontal chord of 16 mm: the "
     "furrow round the nose's wing.",
     kPoint, 1.0, 1.0},
    {"alare_left", "Alare, left",
     "Beside the nose's tip and 3 mm below it, where the surface is most hollow over a horizontal chord of 16 mm: the "
     "furrow round the nose's wing.",
     kPoint, 1.0, 1.0},
    {"temple_right", "Temple at the eye, right",
     "At the eye centre's height, where the face turns to the side: its tangent is at 30 degrees to the mid-plane.",
     kPoint, 1.0, 0.5},
    {"temple_left", "Temple at the eye, left",
     "At the eye centre's height, where the face turns to the side: its tangent is at 30 degrees to the mid-plane.",
     kPoint, 1.0, 0.5},
    {"otobasion_superius_right", "Otobasion superius, right",
     "Top of the ear, where it has sunk to a fifth of its height above the head: a spectacle's temple rests there.",
     kPoint, 2.0, 1.0},
    {"otobasion_superius_left", "Otobasion superius, left",
     "Top of the ear, where it has sunk to a fifth of its height above the head: a spectacle's temple rests there.",
     kPoint, 2.0, 1.0},
    {"tragion_right", "Tragion, right",
     "Where the ear begins coming from the cheek, 0.45 of its height below its top: the notch itself is too small for "
     "the ring.",
     kPoint, 3.0, 4.0},
    {"tragion_left", "Tragion, left",
     "Where the ear begins coming from the cheek, 0.45 of its height below its top: the notch itself is too small for "
     "the ring.",
     kPoint, 3.0, 4.0},
    {"euryon_right", "Euryon, right",
     "Point of the head above the ears that is farthest from the mid-plane; where the head widens down to the ears, "
     "just above them; hair counts.",
     kPoint, 1.0, 1.5},
    {"euryon_left", "Euryon, left",
     "Point of the head above the ears that is farthest from the mid-plane; where the head widens down to the ears, "
     "just above them; hair counts.",
     kPoint, 1.0, 1.5},
    {"zygion_right", "Zygion, right",
     "Point of the cheek before the ear that is farthest from the mid-plane; where the cheek widens back to the ear, "
     "at "
     "its bulge 18 mm before the ear.",
     kPoint, 2.0, 2.0},
    {"zygion_left", "Zygion, left",
     "Point of the cheek before the ear that is farthest from the mid-plane; where the cheek widens back to the ear, "
     "at "
     "its bulge 18 mm before the ear.",
     kPoint, 2.0, 2.0},
    {"gonion_right", "Gonion, right",
     "Corner of the jaw below the ear: where the side of the face bulges most over a vertical chord of 40 mm.", kPoint,
     3.0, 3.0},
    {"gonion_left", "Gonion, left",
     "Corner of the jaw below the ear: where the side of the face bulges most over a vertical chord of 40 mm.", kPoint,
     3.0, 3.0},
}};

/// Collects landmarks by the catalogue.
class Listing {
 public:
  explicit Listing(const MeasuredSurface& body) : body_(body), surface_(body.surface()) {}

  void Add(std::string_view id, const Feature& feature, std::string_view why_not) {
    const HeadLandmarkEntry& entry = EntryOf(id);
    const bool is_inside = feature && feature->z.value >= surface_.z_min() &&
                           (entry.kind == LandmarkKind::kLevel || feature->z.value <= surface_.z_max());
    if (!is_inside) {
      landmarks_.omitted.push_back(std::string(entry.term) + ": " + std::string(why_not) + ".");
      return;
    }
    const bool is_seen = entry.kind == LandmarkKind::kLevel ||
                         body_.KnowledgeAt(feature->theta.value, feature->z.value) != Knowledge::kUnknown;
    if (!is_seen) {
      landmarks_.omitted.push_back(std::string(entry.term) + ": its place was not seen.");
      return;
    }
    Landmark landmark;
    landmark.id = entry.id;
    landmark.term = entry.term;
    landmark.definition = entry.definition;
    landmark.kind = entry.kind;
    landmark.source = feature->source;
    landmark.confidence = feature->confidence;
    landmark.z = feature->z;
    landmark.placing_up = std::max(entry.placing_up, feature->placing);
    landmark.position = {0.0, 0.0, feature->z.value};
    if (entry.kind == LandmarkKind::kPoint) {
      landmark.theta = feature->theta;
      landmark.theta.value = WrapAngle(feature->theta.value);
      landmark.position = surface_.Point(feature->theta.value, feature->z.value);
      landmark.placing_across = std::max(entry.placing_across, feature->placing);
    }
    if (feature->source == LandmarkSource::kProportion) {
      landmark.placing_across = std::max(landmark.placing_across, kProportionSd);
      landmark.placing_up = std::max(landmark.placing_up, kProportionSd);
    }
    landmarks_.found.push_back(std::move(landmark));
  }

  /// The landmarks in the catalogue's order.
  [[nodiscard]] Landmarks Get() const {
    Landmarks ordered = landmarks_;
    std::stable_sort(ordered.found.begin(), ordered.found.end(),
                     [](const Landmark& a, const Landmark& b) { return &EntryOf(a.id) < &EntryOf(b.id); });
    return ordered;
  }

 private:
  static const HeadLandmarkEntry& EntryOf(std::string_view id) {
    const auto* const entry =
        std::find_if(kCatalog.begin(), kCatalog.end(), [&](const HeadLandmarkEntry& e) { return e.id == id; });
    ENSURE(entry != kCatalog.end(), "the catalogue holds " + std::string(id));
    return *entry;
  }

  const MeasuredSurface& body_;
  const SplineSurface& surface_;
  Landmarks landmarks_;
};

Result<HeadView> LookAtHead(const MeasuredSurface& body, const HeadGrid& grid) {
  const auto found = FindFaceAndEars(body.surface(), grid);
  if (!found) return Fail(found);
  const FacePoints& face = found->face;
  HeadView head{body, grid, face, found->plane, found->ear_right, found->ear_left, found->eyeballs};
  head.scale = std::clamp((face.sellion.position.z() - face.pronasale.position.z()) / kUsualNose, 0.7, 1.3);
  return head;
}

std::string Sided(std::string_view id, BodySide side) {
  return std::string(id) + (side == BodySide::kRight ? "_right" : "_left");
}

void AddSide(const HeadView& head, const FoundFeature& pronasale, const Feature& menton, BodySide side,
             Listing& listing) {
  const FoundFeature eye = FindEyeCentre(head, side);
  const FoundFeature orbitale = FindOrbitale(head, eye, side);
  const FoundFeature tragion = FindTragion(head, orbitale, side);
  listing.Add(Sided("eye", side), eye, "the scan ends above it");
  listing.Add(Sided("orbitale", side), orbitale, "the scan ends above it");
  listing.Add(Sided("alare", side), FindAlare(head, pronasale, side), "no furrow beside the nose shows");
  listing.Add(Sided("temple", side), FindTemple(head, eye, side), "the face has no corner at the height of the eye");
  listing.Add(Sided("otobasion_superius", side), FindOtobasion(head, side), "the scan ends above it");
  listing.Add(Sided("tragion", side), tragion, "the scan ends above it");
  listing.Add(Sided("euryon", side), FindEuryon(head, side), "the head shows no largest breadth above the ears");
  listing.Add(Sided("zygion", side), FindZygion(head, tragion, orbitale, side), "the scan ends above it");
  listing.Add(Sided("gonion", side), menton ? FindGonion(head, tragion, *menton, side) : Feature(),
              "the corner of the jaw does not show");
}

}  // namespace

std::span<const HeadLandmarkEntry> HeadLandmarkCatalog() { return kCatalog; }

Landmarks FindHeadLandmarks(const MeasuredSurface& body) {
  const SplineSurface& surface = body.surface();
  if (surface.z_max() - surface.z_min() < kLeastHead) return {{}, {"Landmarks of the head: the scan is too short."}};
  const HeadGrid grid(surface, kHeadDepth);
  const Result<HeadView> head = LookAtHead(body, grid);
  if (!head) return {{}, {"Landmarks of the head: " + head.error().seen + "."}};
  Listing listing(body);
  const FoundFeature sellion = FindSellion(*head);
  const FoundFeature pronasale = FindPronasale(*head);
  const Feature menton = FindMenton(*head, pronasale);
  listing.Add("vertex", FindVertexLevel(*head), "the ring did not see the head up to its crown");
  listing.Add("glabella", FindGlabella(*head, sellion), "the scan ends below it");
  listing.Add("sellion", sellion, "the scan ends below it");
  listing.Add("pronasale", pronasale, "the scan ends above it");
  listing.Add("menton", menton, "the profile shows no chin");
  listing.Add("opisthocranion", FindOpisthocranion(*head, sellion), "the head shows no most rearward point");
  for (const BodySide side : {BodySide::kRight, BodySide::kLeft}) AddSide(*head, pronasale, menton, side, listing);
  return listing.Get();
}

}  // namespace annulus
