#pragma once

#include <Eigen/Core>
#include <array>

#include "fitting/spline_surface.h"
#include "modeling/landmarks/face_points.h"
#include "modeling/landmarks/mid_plane.h"

namespace annulus {

/// The front of a head as a relief over the plane of lateral distance and height: how far it lies forward, mm. Borrows
/// the surface.
class FaceRelief {
 public:
  FaceRelief(const SplineSurface& head, const MidPlane& plane) : head_(head), plane_(plane) {}

  /// The point of the front, within 69 degrees of the direction in which the face looks, that lies `lateral` mm from
  /// the mid-plane (positive to the subject's right) at height z; the end of that sector where none does. Heights
  /// beyond the surface's are held at its ends.
  [[nodiscard]] Eigen::Vector3d PointAt(double lateral, double z) const;
  /// How far that point lies forward, mm.
  [[nodiscard]] double Forward(double lateral, double z) const;
  /// How hollow the relief is at a place over a vertical chord of 2 · half mm: negative on a bulge, mm.
  [[nodiscard]] double Hollow(double lateral, double z, double half) const;

 private:
  const SplineSurface& head_;
  MidPlane plane_;
};

/// The mouth as the lips' relief shows it.
struct Mouth {
  /// Half the mouth's breadth, per side, mm from the mid-plane; [0] is the subject's right.
  std::array<double, 2> half_breadth{};
  double stomion = 0.0;  ///< z of the crease between the lips in the mid-plane, mm.
  /// How far the crease has risen (or sunk, negative) at the corners, mm; between, with the square of the distance.
  std::array<double, 2> corner_rise{};
  double upper_height = 0.0;  ///< From the crease up to the upper lip's border, mm.
  double lower_height = 0.0;  ///< From the crease down to the lower lip's border, mm.
  LandmarkSource source = LandmarkSource::kProportion;
};

/// Finds the crease between the lips below the nose: the deepest hollow that has a bulge on both sides; its ends, where
/// it has become a quarter as deep as in the middle; the lips' borders, a little beyond where they bulge most. By
/// proportion to nose and pupillary distance where no crease shows.
[[nodiscard]] Mouth FindMouth(const FaceRelief& relief, const FacePoints& face);

/// Height of the brow's ridge straight above an eye, mm: where the forehead bulges most above the socket; by proportion
/// where it does not.
[[nodiscard]] double FindBrowHeight(const FaceRelief& relief, const FacePoints& face, double eye_lateral, double eye_z);

}  // namespace annulus
