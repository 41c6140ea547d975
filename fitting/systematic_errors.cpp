#include "fitting/systematic_errors.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <string>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr double kRounding = 1e-9;  // share of the largest variance that counts as rounding

bool IsSigma(double value) { return std::isfinite(value) && value >= 0.0; }

/// What is wrong with a covariance called `name` whose entries are called `entry`, "" if nothing.
std::string CovarianceFault(const Eigen::MatrixXd& c, const std::string& name, const std::string& entry) {
  if (!c.allFinite()) return name + " holds a number that is not finite";
  for (Eigen::Index i = 0; i < c.rows(); ++i) {
    if (c(i, i) < 0.0) return "the variance of " + entry + " " + std::to_string(i) + " is negative";
  }
  // As correlations: entries may have several units, and the largest finite variances must not overflow.
  const Eigen::VectorXd sigma = c.diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse = sigma.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 1.0; });
  const Eigen::MatrixXd unit = inverse.asDiagonal() * c * inverse.asDiagonal();
  if (!((unit - unit.transpose()).cwiseAbs().maxCoeff() <= kRounding)) return name + " is not symmetric";
  for (Eigen::Index i = 0; i < c.rows(); ++i) {
    if (sigma[i] == 0.0 && !c.row(i).isZero(0.0)) return name + " is not positive semi-definite";
  }
  // A semi-definite matrix plus rounding on its diagonal has a Cholesky factor, another one has none.
  Eigen::MatrixXd lifted = unit;
  lifted.diagonal().array() += kRounding * static_cast<double>(c.rows());
  const bool factored = Eigen::LLT<Eigen::MatrixXd>(lifted).info() == Eigen::Success;
  return factored ? "" : name + " is not positive semi-definite";
}

std::string SizeText(const Eigen::MatrixXd& c) { return std::to_string(c.rows()) + " by " + std::to_string(c.cols()); }

std::string OffsetFault(const Eigen::MatrixXd& c) {
  const std::string name = "the covariance of the offsets";
  if (c.rows() != c.cols()) return name + " is " + SizeText(c);
  if (c.rows() < 1 || c.rows() > static_cast<Eigen::Index>(CalibrationErrors::kMaxDirections)) {
    return name + " has " + std::to_string(c.rows()) + " directions";
  }
  return CovarianceFault(c, name, "direction");
}

/// What is wrong with the full form of a sway, "" if nothing or if it has none.
std::string FullSwayFault(const SwayErrors& sway) {
  const std::string name = "the covariance of the sway";
  const std::size_t n = sway.heights.size();
  if (n == 0) return sway.covariance.size() == 0 ? "" : name + " has no heights";
  if (n < 2 || n > SwayErrors::kMostHeights) return "the sway has " + std::to_string(n) + " heights";
  for (std::size_t k = 0; k < n; ++k) {
    if (!std::isfinite(sway.heights[k])) return "a height of the sway is not finite";
    if (k > 0 && !(sway.heights[k] > sway.heights[k - 1])) return "the heights of the sway do not ascend";
  }
  const auto size = static_cast<Eigen::Index>(3 * n);
  if (sway.covariance.rows() != size || sway.covariance.cols() != size) {
    return name + " is " + SizeText(sway.covariance) + " for " + std::to_string(n) + " heights";
  }
  return CovarianceFault(sway.covariance, name, "displacement");
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
    const std::string fault = OffsetFault(errors.calibration->offset_covariance);
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
    const std::string fault = FullSwayFault(*errors.sway);
    if (!fault.empty()) return Fail(attempted, fault, "fit the scan again");
  }
  return {};
}

}  // namespace annulus
