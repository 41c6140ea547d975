#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/result.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// The section of the surface by a horizontal plane, in one kind of number.
template <class Number>
struct SectionNumbers {
  double z = 0.0;               ///< mm
  Number perimeter;             ///< mm; length of the section's curve.
  Number tape;                  ///< mm; length of its convex hull: what a tape reads.
  Number area;                  ///< mm²
  double measured_share = 0.0;  ///< Share of the angles at which the section was seen and not inferred, 0 … 1.
  /// Places where the outline runs along the rays (over 45 degrees): behind them may lie what no ring sees, and the
  /// section is not one visible loop. Each adds to the uncertainty that its edge lies between two directions.
  std::size_t steps = 0;
};
using SectionEstimates = SectionNumbers<Estimate>;  ///< To first order in the surface.
using SectionMeasures = SectionNumbers<Uncertain>;  ///< With standard uncertainties.

/// Measures the section at `z`, mm. Perimeter and area by Gauss quadrature on every spline piece (error <= 1e-6
/// relative), tape from the hull of about 1440 points and what the skin bulges over the hull's short chords (error
/// <= 1e-6 relative), beside steps of the radius from the sensors' directions only. Fails if z is outside the scanned
/// range, or if part of the section is unknown.
[[nodiscard]] Result<SectionEstimates> SectionAt(const MeasuredSurface& body, double z);

/// SectionAt with standard uncertainties. Same failures.
[[nodiscard]] Result<SectionMeasures> MeasureSection(const MeasuredSurface& body, double z);

/// The section's curve as points in the plane, mm, counter-clockwise from theta = 0. Same failures as MeasureSection.
[[nodiscard]] Result<std::vector<Eigen::Vector2d>> SectionCurve(const MeasuredSurface& body, double z,
                                                                std::size_t points);

/// Length along the surface at constant theta (rad) from z_min to z_max, mm: "surface length" of the front, back or
/// side. Fails outside the scanned range or over unknown cells.
[[nodiscard]] Result<Estimate> MeridianLength(const MeasuredSurface& body, double theta, double z_min, double z_max);

/// Length of a tape stretched over the same meridian: the convex chain over its hollows. Same failures.
[[nodiscard]] Result<Estimate> MeridianTape(const MeasuredSurface& body, double theta, double z_min, double z_max);

}  // namespace annulus
