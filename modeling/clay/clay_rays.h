#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/clay/clay_body.h"

namespace annulus {

/// The wall of a clay body as radii about a line: level rays from the line outwards, each of which meets it once.
class ClayRays {
 public:
  /// Base patches below `walls` are the wall, u around and v upwards; then follow as many of the lower cap as of the
  /// upper one. Borrows the body. Fails, with where, if the wall is not star-shaped about the axis at its heights
  /// (looked at 6 × 6 places of every leaf: an undercut, or an axis outside), or the caps leave no height between them.
  static Result<ClayRays> Make(const ClayBody& body, const SegmentAxis& axis, std::size_t walls);

  /// The heights at which there is wall all around, between the caps, mm.
  [[nodiscard]] double z_min() const { return z_min_; }
  [[nodiscard]] double z_max() const { return z_max_; }
  /// How far the caps are from level planes at those heights, mm.
  [[nodiscard]] double caps_off() const { return caps_off_; }

  /// Where a ray meets the wall.
  struct Hit {
    double radius = 0.0;  ///< From the axis, mm, to 1e-9.
    PatchIndex leaf = kNoIndex;
  };
  /// The ray at a height between the caps; nothing if no wall is met.
  [[nodiscard]] std::optional<Hit> Meet(double theta, double z) const;

 private:
  /// A leaf of the wall in the box of its control points.
  struct Piece {
    PatchIndex leaf = kNoIndex;
    Eigen::Vector3d low, high;
  };

  ClayRays() = default;
  void FindCaps(std::size_t walls);
  void FillFloors(std::size_t walls);
  [[nodiscard]] std::size_t FloorOf(double z) const;

  const ClayBody* body_ = nullptr;
  SegmentAxis axis_;
  double z_min_ = 0.0;
  double z_max_ = 0.0;
  double caps_off_ = 0.0;
  std::vector<std::vector<Piece>> floors_;  ///< Pieces that reach into each of equal slices of the height.
};

}  // namespace annulus
