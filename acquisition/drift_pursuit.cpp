#include "acquisition/drift_pursuit.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "base/ensure.h"

namespace annulus {
namespace {

Eigen::Index IndexOf(std::size_t number) { return static_cast<Eigen::Index>(number); }

/// What drifts of all sensors do to all deviations: own 1, neighbours minus their weights.
Eigen::MatrixXd ResponseOf(const DriftHistory::Stencils& stencils) {
  const std::size_t n = stencils.size();
  Eigen::MatrixXd response = Eigen::MatrixXd::Identity(IndexOf(n), IndexOf(n));
  if (n <= 2 * kNeighbourReach) return response;
  for (std::size_t sensor = 0; sensor < n; ++sensor) {
    for (std::size_t k = 0; k < kNeighbours; ++k) {
      const std::size_t at = k < kNeighbourReach ? k : k + 1;
      response(IndexOf(sensor), IndexOf((sensor + n - kNeighbourReach + at) % n)) -= stencils[sensor][k];
    }
  }
  return response;
}

/// Correlation of the deviations that independent readings cause.
Eigen::MatrixXd CorrelationOf(const Eigen::MatrixXd& response) {
  const Eigen::MatrixXd product = response * response.transpose();
  const Eigen::VectorXd scale = product.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * product * scale.asDiagonal();
}

Eigen::MatrixXd CovarianceOf(const DriftEvidence& evidence, const Eigen::MatrixXd& correlation) {
  constexpr double kUnknown = 1e6;  // mm²; says nothing
  const std::size_t n = evidence.deviation.size();
  Eigen::VectorXd noise(IndexOf(n));
  Eigen::VectorXd own(IndexOf(n));
  for (std::size_t k = 0; k < n; ++k) {
    const bool known = std::isfinite(evidence.deviation[k]) && std::isfinite(evidence.noise_variance[k]) &&
                       std::isfinite(evidence.own_variance[k]);
    constexpr double kLeast = 1e-10;
    noise(IndexOf(k)) = known ? std::sqrt(evidence.noise_variance[k]) : 0.0;
    own(IndexOf(k)) = known ? evidence.own_variance[k] + kLeast : kUnknown;
  }
  Eigen::MatrixXd covariance = noise.asDiagonal() * correlation * noise.asDiagonal();
  covariance.diagonal() += own;
  return covariance;
}

}  // namespace

DriftPursuit::DriftPursuit(const DriftHistory::Stencils& stencils, std::vector<SensorBlock> blocks,
                           const std::vector<DriftEvidence>& evidence)
    : blocks_(std::move(blocks)), taken_(blocks_.size(), 0) {
  ENSURE(evidence.size() <= 2, "offsets and trends");
  const std::size_t n = stencils.size();
  const Eigen::MatrixXd response = ResponseOf(stencils);
  const Eigen::MatrixXd correlation = CorrelationOf(response);
  Eigen::MatrixXd patterns = Eigen::MatrixXd::Zero(IndexOf(n), IndexOf(blocks_.size()));
  for (std::size_t block = 0; block < blocks_.size(); ++block) {
    for (std::size_t k = 0; k < blocks_[block].count; ++k) {
      patterns.col(IndexOf(block)) += response.col(IndexOf((blocks_[block].first + k) % n));
    }
  }
  for (const DriftEvidence& one : evidence) {
    ENSURE(one.deviation.size() == n, "one deviation per sensor");
    const Eigen::LLT<Eigen::MatrixXd> root(CovarianceOf(one, correlation));
    Eigen::VectorXd deviation(IndexOf(n));
    for (std::size_t k = 0; k < n; ++k) {
      deviation(IndexOf(k)) = std::isfinite(one.deviation[k]) ? one.deviation[k] : 0.0;
    }
    White white;
    white.deviation = root.matrixL().solve(deviation);
    white.patterns = root.matrixL().solve(patterns);
    white.weight = white.patterns.colwise().squaredNorm().transpose();
    white_.push_back(std::move(white));
  }
}

DriftPursuit::Fit DriftPursuit::Best() const {
  Fit best;
  std::vector<Eigen::VectorXd> matches;
  for (const White& white : white_) matches.emplace_back(white.patterns.transpose() * white.deviation);
  for (std::size_t block = 0; block < blocks_.size(); ++block) {
    if (taken_[block] != 0) continue;
    Fit fit;
    fit.block = blocks_[block];
    fit.index = block;
    for (std::size_t e = 0; e < white_.size(); ++e) {
      const double match = matches[e](IndexOf(block));
      const double weight = white_[e].weight(IndexOf(block));
      fit.size[e] = match / weight;
      fit.variance[e] = 1.0 / weight;
      fit.gain += match * match / weight;
    }
    if (fit.gain > best.gain) best = fit;
  }
  return best;
}

void DriftPursuit::Subtract(const Fit& fit) {
  taken_[fit.index] = 1;
  for (std::size_t e = 0; e < white_.size(); ++e) {
    white_[e].deviation -= fit.size[e] * white_[e].patterns.col(IndexOf(fit.index));
  }
}

}  // namespace annulus
