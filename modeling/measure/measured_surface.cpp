#include "modeling/measure/measured_surface.h"

#include <cmath>
#include <limits>
#include <utility>

#include "fitting/paper_model.h"

namespace annulus {
namespace {

/// Mean of Σ (N_i N_j)² over the plane for uniform cubic B-splines: (∫N²)², ∫N² = 151/315.
constexpr double kSquaresOfSplines = (151.0 / 315.0) * (151.0 / 315.0);

}  // namespace

Result<MeasuredSurface> MeasuredSurface::FromModel(const SurfaceModel& model) {
  MeasuredSurface body(model.main());
  const Eigen::SparseMatrix<double>& precision = model.main().normal_matrix;
  if (precision.nonZeros() > 0) {
    auto covariance = model.main().hierarchy == nullptr
                          ? SurfaceCovariance::FromNormalMatrix(precision)
                          : SurfaceCovariance::FromNormalMatrix(precision, *model.main().hierarchy);
    if (!covariance) return Fail(covariance);
    body.covariance_ = std::make_shared<const SurfaceCovariance>(std::move(*covariance));
  }
  return body;
}

Uncertain MeasuredSurface::WithSigma(const Estimate& estimate) const {
  if (covariance_ == nullptr) return {estimate.value, std::numeric_limits<double>::quiet_NaN()};
  if (estimate.gradient.size() == 0) return {estimate.value, 0.0};
  const Eigen::VectorXd gradient = estimate.gradient;
  const double posterior =
      covariance_->Variance(segment_->hierarchy == nullptr ? gradient : segment_->hierarchy->ActiveGradient(gradient));
  const double detail = segment_->detail_sigma * segment_->detail_sigma * gradient.squaredNorm() / kSquaresOfSplines;
  return {estimate.value, std::sqrt(posterior + detail)};
}

double MeasuredSurface::RadiusSigma(double theta, double z) const {
  if (covariance_ == nullptr) return std::numeric_limits<double>::quiet_NaN();
  std::vector<CoefficientWeight> gradient;
  if (segment_->hierarchy == nullptr) {
    const RadiusRow row = surface().Row(theta, z);
    for (std::size_t k = 0; k < row.index.size(); ++k) gradient.push_back({row.index[k], row.value[k]});
  } else {
    gradient = segment_->hierarchy->ActiveRow(theta, z);
  }
  return std::sqrt(covariance_->LocalVariance(gradient) + segment_->detail_sigma * segment_->detail_sigma);
}

double MeasuredSurface::Radius(double theta, double z) const {
  return segment_->paper ? segment_->paper->surface.Radius(theta, z) : surface().Radius(theta, z);
}

Eigen::Vector3d MeasuredSurface::Point(double theta, double z) const {
  return segment_->paper ? segment_->paper->surface.Point(theta, z) : surface().Point(theta, z);
}

Eigen::Vector3d MeasuredSurface::Normal(double theta, double z) const {
  return segment_->paper ? segment_->paper->surface.Normal(theta, z) : surface().Normal(theta, z);
}

}  // namespace annulus
