#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/result.h"
#include "fitting/spline_surface.h"
#include "modeling/landmarks/ear_outline.h"

namespace annulus {

/// A head with its ears taken off: what a spectacle's temple touches. A temple passes between ear and head, where a
/// star-shaped surface has no gap: there the ear would stop it. In the ears' place is the smoothest surface that joins
/// what is around them (least squares of second derivatives: a thin plate); elsewhere the head is as measured.
/// Immutable; reentrant.
class HeadWithoutEars {
 public:
  /// Takes off the ears that are given; with none it is the head itself. About 20 ms.
  HeadWithoutEars(const SplineSurface& head, const std::optional<EarOutline>& right,
                  const std::optional<EarOutline>& left);

  /// Finds the ears first. Fails as FindFacePoints does.
  static Result<HeadWithoutEars> Find(const SplineSurface& head);

  /// The head as measured, and beneath its ears.
  [[nodiscard]] const SplineSurface& measured() const { return measured_; }
  [[nodiscard]] const SplineSurface& surface() const { return surface_; }
  /// How far the ear stands out of the head at a place, mm; nearly 0 away from the ears. z within the surface.
  [[nodiscard]] double Relief(double theta, double z) const {
    return measured_.Radius(theta, z) - surface_.Radius(theta, z);
  }
  /// Whether the place is on an ear: whether that is 1 mm or more.
  [[nodiscard]] bool IsOnEar(double theta, double z) const { return Relief(theta, z) >= kLeastRelief; }

  static constexpr double kLeastRelief = 1.0;  ///< mm

 private:
  SplineSurface measured_;
  SplineSurface surface_;
};

/// The ear with height and top by its relief over the head beneath: the top is where, coming down the head, the relief
/// first reaches a fifth of its largest. Unchanged where it does not end below the scan's top.
[[nodiscard]] EarOutline WithTopOnTheHead(const EarOutline& ear, const HeadWithoutEars& head);

}  // namespace annulus
