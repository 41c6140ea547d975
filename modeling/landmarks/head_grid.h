#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fitting/spline_surface.h"

namespace annulus {

/// Which side of the body, the subject's.
enum class BodySide { kRight, kLeft };

/// r(theta, z) of a head sampled at whole degrees and millimetres below its top: what the searches for features run on.
class HeadGrid {
 public:
  static constexpr int kFullCircle = 360;

  /// The upper `depth` mm of the surface, or all of it.
  HeadGrid(const SplineSurface& head, double depth);

  [[nodiscard]] int rows() const { return rows_; }
  /// Height of a row, mm: row 0 is the top.
  [[nodiscard]] double z(int row) const { return top_ - row; }
  /// The row nearest to z, within the grid.
  [[nodiscard]] int RowAt(double z) const;
  /// Radius at any whole degree, mm, >= 0; rows beyond the grid repeat its border.
  [[nodiscard]] double r(int degree, int row) const;
  /// Radius at any place, mm, linear between the nodes.
  [[nodiscard]] double Radius(double theta, double z) const;
  [[nodiscard]] Eigen::Vector3d Point(int degree, int row) const;
  [[nodiscard]] double MeanRadius(int row) const;

 private:
  double top_;
  int rows_;
  std::vector<double> radius_;
};

/// A node of the grid.
struct GridPlace {
  int degree = 0;
  int row = 0;
};

/// How far below the surface's top a face can reach, hair and neck included, mm.
inline constexpr double kHeadDepth = 330.0;
/// A surface less high than this shows no head, mm.
inline constexpr double kLeastHead = 150.0;
/// Heights below the top of the head in which an adult's or child's nose tip lies, hair included, mm.
inline constexpr double kNoseHighest = 85.0;
inline constexpr double kNoseLowest = 210.0;

/// The row of the smallest mean radius below the face: the neck.
[[nodiscard]] int NeckRow(const HeadGrid& grid);

/// The nose's tip above the neck: forward (+y), and standing out by 4 mm or more from what is 15 degrees to either
/// side. Forehead and chin are too broad. Empty if nothing is, or where the section is wider than any head's.
[[nodiscard]] std::optional<GridPlace> FindNose(const HeadGrid& grid, int neck);

}  // namespace annulus
