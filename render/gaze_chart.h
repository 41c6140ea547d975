#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <string_view>
#include <vector>

#include "render/colour.h"

namespace annulus {

/// A picture on a flat wall with its smaller copies (each half the size of the one before), for looking it up at any
/// coarseness.
class WallPicture {
 public:
  /// Requires width * height values, both >= 1; row 0 is the top.
  WallPicture(int width, int height, std::vector<LinearRgb> rgb);

  /// The colour around (x, y), in texels of the full size from the upper left corner, seen with a spot `spot` texels
  /// wide; beyond the edge, the edge's colour.
  [[nodiscard]] LinearRgb At(double x, double y, double spot) const;
  [[nodiscard]] int width() const { return levels_.front().width; }
  [[nodiscard]] int height() const { return levels_.front().height; }

 private:
  struct Level {
    int width;
    int height;
    std::vector<LinearRgb> rgb;

    [[nodiscard]] LinearRgb Between(double x, double y) const;
  };

  std::vector<Level> levels_;
};

/// What the wearer looks at.
enum class GazeSceneKind {
  kShop,  ///< An optician's shop: a test chart on the far wall at 6 m, shelves, a window, tiles.
  kGrid,  ///< A white wall at 6 m with squares of 0.5 m and a test chart in its middle.
};
/// "shop", "grid".
[[nodiscard]] const std::array<std::string_view, 2>& GazeSceneNames();

/// The distance of chart and grid, mm.
inline constexpr double kChartDistance = 6000.0;

/// A picture's worth of world before the eyes, looked up by direction: all of it counts as distant, as a prescription
/// for distance does. View frame: x the wearer's left, y up, z forward. Immutable, thread-safe.
class GazeScene {
 public:
  [[nodiscard]] static GazeScene Make(GazeSceneKind kind);

  /// Linear light from `direction` (any length), seen with a spot of `spot` rad. Finite, 0 … 1.
  [[nodiscard]] LinearRgb Light(const Eigen::Vector3d& direction, double spot) const;

 private:
  /// A rectangle with a picture.
  struct Wall {
    /// `right` and `down`: the sides from `corner` (upper left as seen), mm.
    Wall(const Eigen::Vector3d& corner, const Eigen::Vector3d& right, const Eigen::Vector3d& down, WallPicture picture);

    Eigen::Vector3d normal;  // unit
    double distance;         // normal · corner, mm
    Eigen::Vector3d across;  // texels to the right of a point p: across · p - left
    Eigen::Vector3d along;
    double left, top;
    double texels_per_mm;
    WallPicture picture;
  };
  GazeScene() = default;

  std::vector<Wall> walls_;  // nearer ones first where they overlap
  LinearRgb beyond_ = LinearRgb::Zero();
};

/// Diameter of a Landolt ring of a decimal visual acuity (> 0) on the chart, mm: its gap is 1' / acuity, the ring five
/// gaps (ISO 8596).
[[nodiscard]] double LandoltDiameter(double acuity);

}  // namespace annulus
