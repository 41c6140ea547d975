#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "base/result.h"
#include "fitting/covariance.h"
#include "fitting/surface_model.h"

namespace annulus {

/// A number with its standard uncertainty (1 sd, same unit). sigma is NaN where the model carries no normal matrix.
struct Uncertain {
  double value = 0.0;
  double sigma = 0.0;
};

/// A measured surface ready for queries: the main segment of a model and, if the model has one, its covariance.
/// Borrows the model, which must outlive it. Reentrant.
class MeasuredSurface {
 public:
  /// Fails if the normal matrix is not positive definite. A model without one gives NaN sigmas.
  static Result<MeasuredSurface> FromModel(const SurfaceModel& model);

  [[nodiscard]] const SplineSurface& surface() const { return segment_->surface; }
  [[nodiscard]] const SurfaceSegment& segment() const { return *segment_; }
  /// Radius (mm), point (mm) and outward unit normal at one place, station frame: of the surface P(u, v) itself where
  /// the model has one (solved for theta), which `surface()` approximates; else of `surface()`.
  [[nodiscard]] double Radius(double theta, double z) const;
  [[nodiscard]] Eigen::Vector3d Point(double theta, double z) const;
  [[nodiscard]] Eigen::Vector3d Normal(double theta, double z) const;
  [[nodiscard]] Knowledge KnowledgeAt(double theta, double z) const { return segment_->knowledge.At(theta, z); }
  /// Value and sd of a quantity with this gradient with respect to the coefficients of surface(). Detail that the
  /// surface does not follow counts as independent errors of these coefficients, of such size that a radius has the sd
  /// SurfaceSegment::detail_sigma from them in the mean.
  [[nodiscard]] Uncertain WithSigma(double value, const Eigen::VectorXd& gradient) const;
  /// sd of the radius at one place, mm: the posterior's and the detail's.
  [[nodiscard]] double RadiusSigma(double theta, double z) const;

 private:
  explicit MeasuredSurface(const SurfaceSegment& segment) : segment_(&segment) {}
  const SurfaceSegment* segment_;
  std::shared_ptr<const SurfaceCovariance> covariance_;  ///< Shared by copies of this light value; null without matrix.
};

/// The section of the surface by a horizontal plane.
struct SectionMeasures {
  double z = 0.0;               ///< mm
  Uncertain perimeter;          ///< mm; length of the section's curve.
  Uncertain tape;               ///< mm; length of its convex hull: what a tape reads.
  Uncertain area;               ///< mm²
  double measured_share = 0.0;  ///< Share of the angles at which the section was seen and not inferred, 0 … 1.
};

/// Measures the section at `z`, mm. Perimeter and area by Gauss quadrature on every spline piece (error <= 1e-6
/// relative), tape from the hull of about 1440 points (<= 4e-6 relative below the truth), beside steps of the radius of
/// the sensors' directions only. Fails if z is outside the scanned range, or if part of the section is unknown.
[[nodiscard]] Result<SectionMeasures> MeasureSection(const MeasuredSurface& body, double z);

/// The section's curve as points in the plane, mm, counter-clockwise from theta = 0. Same failures as MeasureSection.
[[nodiscard]] Result<std::vector<Eigen::Vector2d>> SectionCurve(const MeasuredSurface& body, double z,
                                                                std::size_t points);

/// What lies between two horizontal planes.
struct SlabMeasures {
  double z_min = 0.0;  ///< mm
  double z_max = 0.0;  ///< mm
  Uncertain volume;    ///< mm³
  Uncertain area;      ///< mm², of the skin between the planes (no lids).
  double measured_share = 0.0;
};

/// Measures the slab z_min … z_max, mm: the volume exactly (∬ r²/2 is a polynomial on every patch), the area by 4 × 4
/// Gauss points per patch. Fails if z_min >= z_max, outside the scanned range, or over unknown cells.
[[nodiscard]] Result<SlabMeasures> MeasureSlab(const MeasuredSurface& body, double z_min, double z_max);

/// Length along the surface at constant theta (rad) from z_min to z_max, mm: "surface length" of the front, back or
/// side. Fails outside the scanned range or over unknown cells.
[[nodiscard]] Result<Uncertain> MeridianLength(const MeasuredSurface& body, double theta, double z_min, double z_max);

/// Length of a tape stretched over the same meridian: the convex chain over its hollows. Same failures.
[[nodiscard]] Result<Uncertain> MeridianTape(const MeasuredSurface& body, double theta, double z_min, double z_max);

}  // namespace annulus
