#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "base/result.h"
#include "fitting/covariance.h"
#include "fitting/surface_model.h"
#include "modeling/measure/estimate.h"

namespace annulus {

/// A place on the surface: a surface cursor (paper 001, §3) in the parameters of SplineSurface.
struct SurfacePlace {
  double theta = 0.0;  ///< rad
  double z = 0.0;      ///< mm
};

/// A measured surface ready for queries: the main segment of a model and, if the model has one, its covariance.
/// Borrows the model, which must outlive it. Reentrant.
class MeasuredSurface {
 public:
  /// Fails if the normal matrix is not positive definite. A model without one gives NaN sigmas.
  static Result<MeasuredSurface> FromModel(const SurfaceModel& model);

  [[nodiscard]] const SplineSurface& surface() const { return segment_->surface; }
  [[nodiscard]] const SurfaceSegment& segment() const { return *segment_; }
  /// Errors that repeat over the scan; null where nothing is known of them.
  [[nodiscard]] const SystematicErrors* systematic() const { return systematic_; }
  /// Radius (mm), point (mm) and outward unit normal at one place, station frame: of the surface P(u, v) itself where
  /// the model has one (solved for theta), which `surface()` approximates; else of `surface()`.
  [[nodiscard]] double Radius(double theta, double z) const;
  [[nodiscard]] Eigen::Vector3d Point(double theta, double z) const;
  [[nodiscard]] Eigen::Vector3d Normal(double theta, double z) const;
  [[nodiscard]] Knowledge KnowledgeAt(double theta, double z) const { return segment_->knowledge.At(theta, z); }

  /// The number with its sd from noise and smoothing (the fit's covariance), and what is unresolved. Detail that the
  /// surface does not follow counts as independent errors of the coefficients, of such size that a radius has the sd
  /// SurfaceSegment::detail_sigma from them in the mean.
  [[nodiscard]] Uncertain WithSigma(const Estimate& estimate) const;
  /// WithSigma of several numbers, in less time than one by one.
  [[nodiscard]] std::vector<Uncertain> WithSigmas(const std::vector<Estimate>& estimates) const;
  /// Deviations of the coefficients of surface(), mm, as likely as the true surface's (the covariance and the detail);
  /// always the same ones, made at the first call; the mirrored ones are as likely. None without a normal matrix.
  [[nodiscard]] const std::vector<Eigen::VectorXd>& Deviations() const;
  /// sd of the radius at one place, mm: the posterior's and the detail's.
  [[nodiscard]] double RadiusSigma(double theta, double z) const;

 private:
  explicit MeasuredSurface(const SurfaceSegment& segment);
  [[nodiscard]] std::vector<Eigen::VectorXd> DrawDeviations() const;
  const SurfaceSegment* segment_;
  const SystematicErrors* systematic_ = nullptr;
  std::shared_ptr<const SurfaceCovariance> covariance_;  ///< Shared by copies of this light value; null without matrix.
  struct LazyDeviations;
  std::shared_ptr<LazyDeviations> deviations_;  ///< Shared likewise; never null.
};

}  // namespace annulus
