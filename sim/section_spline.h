#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace annulus::sim {

/// Shape of one horizontal section before bumps: an ellipse-like curve around its own centre.
/// With the ellipse's own angle t (tan t = half_width/half_depth · tan theta) its radius is
/// r = ellipse(theta) · (1 + squareness · sin²2t + egg · 2.598 · sin t · cos²t).
struct TubeRow {
  double z = 0.0;           ///< Height, mm.
  double half_width = 0.0;  ///< Half extent along x, mm.
  double front = 0.0;       ///< y of the front-most point, mm.
  double back = 0.0;        ///< y of the rear-most point, mm; < front.
  double x_centre = 0.0;    ///< mm.
  double squareness = 0.0;  ///< Relative growth of the four corners.
  double egg = 0.0;         ///< Relative growth of the two front corners and shrinking of the rear ones.
};

/// Natural cubic splines (C2) in z through the rows of a tube; constant beyond the ends.
class SectionSpline {
 public:
  /// Parameters in the order of kHalfWidth … kEgg.
  static constexpr std::size_t kParameterCount = 6;
  using Values = std::array<double, kParameterCount>;
  static constexpr std::size_t kHalfWidth = 0;
  static constexpr std::size_t kHalfDepth = 1;
  static constexpr std::size_t kXCentre = 2;
  static constexpr std::size_t kYCentre = 3;
  static constexpr std::size_t kSquareness = 4;
  static constexpr std::size_t kEgg = 5;

  /// Requires at least three rows with increasing z.
  explicit SectionSpline(const std::vector<TubeRow>& rows);

  /// All parameters at z, mm.
  [[nodiscard]] Values At(double z) const;
  /// Heights of the rows, increasing: between them the parameters are polynomials.
  [[nodiscard]] const std::vector<double>& knots() const { return knots_; }

 private:
  using Cubic = std::array<Values, 4>;  ///< Powers 0 … 3 of (z - knot).
  std::vector<double> knots_;
  std::vector<Cubic> pieces_;
};

}  // namespace annulus::sim
