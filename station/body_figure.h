#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "fitting/surface_model.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// A field of numbers on a grid of unit squares; column 0 and row 0 first.
struct FigureGrid {
  std::size_t columns = 0;
  std::size_t rows = 0;
  std::vector<double> values;

  [[nodiscard]] double At(std::size_t column, std::size_t row) const { return values[row * columns + column]; }
};

/// The closed curves where a field passes through `level`, in the grid's units, by linear interpolation between the
/// grid's points; higher values lie to the left. The field counts as lowest outside the grid.
[[nodiscard]] std::vector<std::vector<Eigen::Vector2d>> LevelLoops(const FigureGrid& field, double level);

/// The curve without points that lie within `tolerance` of the line between those kept (Douglas and Peucker).
[[nodiscard]] std::vector<Eigen::Vector2d> Simplified(const std::vector<Eigen::Vector2d>& curve, double tolerance);

/// A stretch of a path in a figure.
struct FigureRun {
  std::vector<Eigen::Vector2d> points;  ///< Figure plane, mm.
  bool visible = true;                  ///< False where the body hides it.
};

/// A body seen from far away at one height: an orthographic drawing. The figure's plane has x to the viewer's right
/// and y up (the station's z), mm.
class BodyFigure {
 public:
  /// `azimuth` (rad) is the station's theta of the viewer: 90 degrees sees the front. Requires a mesh with faces and
  /// pixel_mm > 0.
  BodyFigure(const TriangleMesh& mesh, double azimuth, double pixel_mm);

  /// Where a point of the station frame lies in the figure.
  [[nodiscard]] Eigen::Vector2d Project(const Eigen::Vector3d& point) const;
  /// Lowest and highest corner of what is drawn.
  [[nodiscard]] const Eigen::Vector2d& low() const { return low_; }
  [[nodiscard]] const Eigen::Vector2d& high() const { return high_; }
  /// Rims of all that is covered by the body.
  [[nodiscard]] std::vector<std::vector<Eigen::Vector2d>> Outline() const;
  /// Regions that are lit by more than `light` (0 … 1) by a lamp beside the viewer.
  [[nodiscard]] std::vector<std::vector<Eigen::Vector2d>> Lit(double light) const;
  /// The path in parts that are seen and parts that the body hides.
  [[nodiscard]] std::vector<FigureRun> Runs(const std::vector<Eigen::Vector3d>& path) const;

 private:
  struct Corner;  // of a triangle in the figure
  void DrawTriangle(const Corner& a, const Corner& b, const Corner& c);
  [[nodiscard]] std::vector<std::vector<Eigen::Vector2d>> Loops(const FigureGrid& field, double level) const;
  [[nodiscard]] bool Hides(const Eigen::Vector3d& point) const;

  Eigen::Vector3d right_;
  Eigen::Vector3d toward_;  ///< To the viewer.
  double pixel_mm_;
  Eigen::Vector2d low_;
  Eigen::Vector2d high_;
  FigureGrid depth_;  ///< mm towards the viewer; lowest number where nothing is.
  FigureGrid light_;  ///< 0 … 1; 0 where nothing is.
};

/// The mesh that figures are drawn of: trunk, head and legs above `from_z` (mm), without what is unknown. Arms are left
/// out: nothing is measured on them, and they would hide the trunk's sides.
[[nodiscard]] TriangleMesh FigureMesh(const SurfaceModel& model, double from_z);

}  // namespace annulus
