#pragma once

#include <Eigen/Core>
#include <vector>

#include "fitting/spline_surface.h"

namespace annulus {

/// A distance from the head and its derivative by the point's place; at the skin that is the outward unit normal.
struct HeadGap {
  double distance = 0.0;  ///< mm, negative inside.
  Eigen::Vector3d gradient = Eigen::Vector3d::UnitY();
};

/// The nearest place of a head to a point.
struct NearestOnHead {
  double distance = 0.0;                               ///< Signed, mm; negative inside.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< On the head, station frame, mm.
  double theta = 0.0;                                  ///< rad
  double z = 0.0;                                      ///< mm
};

/// Signed distances from one head for thousands of points: the surface's polynomials made ready once. Above the
/// surface's top and below its end nothing is in the way. Borrows the surface. Immutable; reentrant.
class HeadDistance {
 public:
  /// Samples the part between two heights (mm, clipped to the surface): Nearest searches there only.
  HeadDistance(const SplineSurface& head, double z_low, double z_high);

  [[nodiscard]] const SplineSurface& surface() const { return *surface_; }
  /// The radial gap divided by the length of its gradient: exact to first order. Station frame, mm.
  [[nodiscard]] HeadGap FirstOrder(const Eigen::Vector3d& p) const;
  /// The true distance: the nearest of the samples within the radial gap, then Newton's rule. Station frame, mm.
  [[nodiscard]] NearestOnHead Nearest(const Eigen::Vector3d& p) const;

 private:
  struct Column {
    double cosine;
    double sine;
  };
  /// The polynomials of one interval of z, and its start and length.
  struct HeightInterval {
    double start;
    double length;
    IntervalCubics cubics;
  };
  [[nodiscard]] RadiusJet Jet(double theta, double z) const;
  [[nodiscard]] const HeightInterval& IntervalAt(double z) const;
  [[nodiscard]] Eigen::Vector2d NearestSample(const Eigen::Vector3d& p, double theta, double reach) const;

  const SplineSurface* surface_;
  double z_low_;
  int rows_ = 0;
  std::vector<Column> columns_;
  std::vector<double> radius_;  ///< Row by row.
  std::vector<HeightInterval> heights_;
  std::vector<std::size_t> first_interval_;  ///< For every mm above the surface's end: the interval there.
};

}  // namespace annulus
