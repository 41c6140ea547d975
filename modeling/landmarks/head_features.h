#pragma once

#include <optional>
#include <vector>

#include "modeling/landmarks/ear_outline.h"
#include "modeling/landmarks/face_points.h"
#include "modeling/landmarks/mid_plane.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// A head seen: what the searches for its landmarks share. Borrows surface and grid.
struct HeadView {
  const MeasuredSurface& body;
  const HeadGrid& grid;
  FacePoints face;
  MidPlane plane;
  std::optional<EarOutline> ear_right{};
  std::optional<EarOutline> ear_left{};
  Eyeballs eyeballs{};
  double scale = 1.0;  ///< Height of the nose over 38 mm: how large the face is.

  [[nodiscard]] const SplineSurface& surface() const { return body.surface(); }
  [[nodiscard]] const std::optional<EarOutline>& Ear(BodySide side) const {
    return side == BodySide::kRight ? ear_right : ear_left;
  }
  /// Unit vector to that side of the head, horizontal.
  [[nodiscard]] Eigen::Vector3d Outward(BodySide side) const {
    return side == BodySide::kRight ? plane.right() : Eigen::Vector3d(-plane.right());
  }
};

/// Where a landmark was found.
struct FoundFeature {
  Estimate theta;  ///< rad
  Estimate z;      ///< mm
  double confidence = 0.0;
  LandmarkSource source = LandmarkSource::kDetected;
  double placing = 0.0;  ///< mm; sd of placing by a second-best rule, where it is more than the catalogue's.
};

/// A feature's place, or empty where it does not show and no proportion is known for it.
using Feature = std::optional<FoundFeature>;

/// The mid profile, top to bottom; placed by proportion where they do not show.
[[nodiscard]] FoundFeature FindGlabella(const HeadView& head, const FoundFeature& sellion);
[[nodiscard]] FoundFeature FindSellion(const HeadView& head);
[[nodiscard]] FoundFeature FindPronasale(const HeadView& head);
/// Empty where the profile shows no chin below the nose (a beard, a scan that ends there).
[[nodiscard]] Feature FindMenton(const HeadView& head, const FoundFeature& pronasale);
[[nodiscard]] Feature FindOpisthocranion(const HeadView& head, const FoundFeature& sellion);
/// The crown's height, extrapolated from the uppermost sections by at most 20 mm; empty where they are too large for
/// that. Only z counts.
[[nodiscard]] Feature FindVertexLevel(const HeadView& head);

/// Features of one side.
[[nodiscard]] FoundFeature FindEyeCentre(const HeadView& head, BodySide side);
[[nodiscard]] FoundFeature FindOrbitale(const HeadView& head, const FoundFeature& eye, BodySide side);
[[nodiscard]] Feature FindAlare(const HeadView& head, const FoundFeature& pronasale, BodySide side);
[[nodiscard]] Feature FindTemple(const HeadView& head, const FoundFeature& eye, BodySide side);
[[nodiscard]] FoundFeature FindOtobasion(const HeadView& head, BodySide side);
[[nodiscard]] FoundFeature FindTragion(const HeadView& head, const FoundFeature& orbitale, BodySide side);
[[nodiscard]] Feature FindEuryon(const HeadView& head, BodySide side);
[[nodiscard]] Feature FindZygion(const HeadView& head, const FoundFeature& tragion, const FoundFeature& orbitale,
                                 BodySide side);
[[nodiscard]] Feature FindGonion(const HeadView& head, const FoundFeature& tragion, const FoundFeature& menton,
                                 BodySide side);

}  // namespace annulus
