#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "render/camera.h"
#include "render/image.h"

namespace annulus {

/// A place in a picture.
struct PicturePoint {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  ///< Pixels from the upper left corner, y down.
  double depth = 0.0;                            ///< mm along the optical axis.
};

/// A stretch of a line in a picture.
struct OverlayRun {
  std::vector<Eigen::Vector2d> points;  ///< Pixels, y down.
  bool visible = true;                  ///< False where something stands before it.
};

/// Lines and points over a finished picture: where they appear, and what is hidden behind what the picture shows.
/// Borrows the picture.
class Overlay {
 public:
  /// `picture` was drawn by `camera` and has a depth per pixel. What lies less than `tolerance` mm behind it counts as
  /// on it: tapes lie on the skin.
  Overlay(const Camera& camera, const RgbImage& picture, double tolerance = 4.0);

  /// Nothing for a point that is not finite or nearer than the camera's near plane.
  [[nodiscard]] std::optional<PicturePoint> Project(const Eigen::Vector3d& p_in_station) const;
  /// Whether the picture shows something before the point. Beside an outline the farther side counts, so that a tape
  /// that turns round a body is not hidden by the body's own edge. Outside the picture nothing is hidden.
  [[nodiscard]] bool Hides(const PicturePoint& point) const;
  /// A line in parts that are seen and parts that are hidden; neighbouring parts share a point. A part between two
  /// others that is shorter than kShortestRun counts as they do. Points that cannot be projected part the line.
  [[nodiscard]] std::vector<OverlayRun> Runs(const std::vector<Eigen::Vector3d>& line) const;

 private:
  static constexpr double kShortestRun = 6.0;  ///< Pixels.

  Camera camera_;
  const RgbImage& picture_;
  double tolerance_;
};

/// Places for labels in one column, as near as may be to where they are wanted: the order stays, neighbours are at
/// least `gap` apart, all lie in [from, to] if they fit there, and the sum of the squared ways is least (pool adjacent
/// violators). `wanted` in any order; the answer is in the same order. Labels that do not fit run over `to`.
[[nodiscard]] std::vector<double> SpreadLabels(const std::vector<double>& wanted, double gap, double from, double to);

}  // namespace annulus
