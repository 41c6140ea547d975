#include "fitting/systematic_errors.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <string>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr double kRounding = 1e-9;  // share of the largest variance that counts as rounding

bool IsSigma(double value) { return std::isfinite(value) && value >= 0.0; }

/// What is wrong with a covariance, "" if nothing.
std::string CovarianceFault(const Eigen::MatrixXd& c) {
  if (c.rows() != c.cols()) {
    return "the covariance of the offsets is " + std::to_string(c.rows()) + " by " + std::to_string(c.cols());
  }
  if (c.rows() < 1 || c.rows() > static_cast<Eigen::Index>(CalibrationErrors::kMaxDirections)) {
    return "the covariance of the offsets has " + std::to_string(c.rows()) + " directions";
  }
  if (!c.allFinite()) return "the covariance of the offsets holds a number that is not finite";
  for (Eigen::Index i = 0; i < c.rows(); ++i) {
    if (c(i, i) < 0.0) return "the variance of direction " + std::to_string(i) + " is negative";
  }
  const double scale = c.diagonal().maxCoeff();
  if (scale == 0.0) return c.isZero(0.0) ? "" : "the covariance of the offsets is not positive semi-definite";
  // Divided first: the largest finite variances must not overflow.
  const Eigen::MatrixXd unit = c / scale;
  if (!((unit - unit.transpose()).cwiseAbs().maxCoeff() <= kRounding)) {
    return "the covariance of the offsets is not symmetric";
  }
  // A semi-definite matrix plus rounding on its diagonal has a Cholesky factor, another one has none.
  Eigen::MatrixXd lifted = unit;
  lifted.diagonal().array() += kRounding * static_cast<double>(c.rows());
  const bool factored = Eigen::LLT<Eigen::MatrixXd>(lifted).info() == Eigen::Success;
  return factored ? "" : "the covariance of the offsets is not positive semi-definite";
}

}  // namespace

Eigen::MatrixXd OffsetCovariance(std::size_t directions, double common_sigma, double independent_sigma) {
  ENSURE(directions >= 1, "a ring looks in at least one direction");
  const auto n = static_cast<Eigen::Index>(directions);
  Eigen::MatrixXd c = Eigen::MatrixXd::Constant(n, n, common_sigma * common_sigma);
  c.diagonal().array() += independent_sigma * independent_sigma;
  return c;
}

Status CheckSystematicErrors(const SystematicErrors& errors) {
  const std::string attempted = "take systematic errors into account";
  if (errors.calibration) {
    const std::string fault = CovarianceFault(errors.calibration->offset_covariance);
    if (!fault.empty()) return Fail(attempted, fault, "calibrate the ring again");
    if (!IsSigma(errors.calibration->height_scale_sigma) || !IsSigma(errors.calibration->height_offset_sigma)) {
      return Fail(attempted, "a standard deviation of the heights is negative or not finite",
                  "calibrate the axis again");
    }
  }
  if (errors.sway) {
    if (!IsSigma(errors.sway->sigma_x) || !IsSigma(errors.sway->sigma_y)) {
      return Fail(attempted, "a standard deviation of the sway is negative or not finite", "give it in mm, 0 or more");
    }
    if (!std::isfinite(errors.sway->correlation_length) || !(errors.sway->correlation_length > 0.0)) {
      return Fail(attempted, "the correlation length of the sway is not a positive number", "give it in mm");
    }
  }
  return {};
}

}  // namespace annulus
