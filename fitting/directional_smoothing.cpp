#include "fitting/directional_smoothing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "fitting/front_kernels.h"

namespace annulus {
namespace {

constexpr std::uint64_t kProbeSeed = 20'000'101;
constexpr double kStep = 2.5;      // factor between the points of a parabola
constexpr double kLargest = 64.0;  // of a factor, and its inverse

/// Where the parabola through three points, one step apart in the logarithm, is lowest; moves on while an end is
/// lowest.
double LowestFactor(const std::function<double(double)>& score, double at_one) {
  const double step = std::log(kStep);
  const double furthest = std::log(kLargest);
  double centre = 0.0;
  double middle = at_one;
  double low = score(std::exp(-step));
  double high = score(std::exp(step));
  while (std::min(low, high) < middle && std::abs(centre) + step < furthest) {
    const double direction = low < high ? -1.0 : 1.0;
    centre += direction * step;
    (direction < 0.0 ? high : low) = middle;
    middle = direction < 0.0 ? low : high;
    (direction < 0.0 ? low : high) = score(std::exp(centre + direction * step));
  }
  const double bend = low - 2.0 * middle + high;
  const double shift = bend > 0.0 && std::isfinite(bend) ? std::clamp(0.5 * (low - high) / bend, -1.0, 1.0) : 0.0;
  return std::exp(centre + shift * step);
}

}  // namespace

RoughnessWeights Scaled(const RoughnessWeights& weights, const DirectionalSmoothing& smoothing) {
  RoughnessWeights scaled = weights;
  const double mixed = std::sqrt(smoothing.theta * smoothing.z);
  for (CellBend& cell : scaled.cells) {
    cell.uu *= smoothing.theta;
    cell.vv *= smoothing.z;
    cell.uv *= mixed;
  }
  return scaled;
}

DirectionalGcv::DirectionalGcv(const SplineSystem& system, std::shared_ptr<const EliminationTree> tree,
                               const RoughnessWeights& weights, std::span<const double> factors)
    : system_(system), tree_(std::move(tree)), terms_(system.Terms(weights, factors)) {
  const Eigen::VectorXd radii = system.Radii();
  right_ = system.WeightedTranspose(radii, factors);
  const double scale = 1.0 / (system.noise_sigma() * system.noise_sigma());
  for (std::size_t k = 0; k < system.rows().size(); ++k) {
    const SampleRow& row = system.rows()[k];
    const double weight = static_cast<double>(row.weight) * (factors.empty() ? 1.0 : factors[k]);
    squares_ += scale * weight * row.radius * row.radius;
    if (weight > 0.0) total_weight_ += 1.0;
  }
  std::mt19937_64 engine(kProbeSeed);
  probes_.resize(right_.size(), 4);
  for (Eigen::Index k = 0; k < probes_.size(); ++k) probes_.data()[k] = (engine() & 1U) != 0U ? 1.0 : -1.0;
  data_times_probes_ = DataTimes(probes_);
}

FrontalCholesky::FourColumns DirectionalGcv::DataTimes(const FrontalCholesky::FourColumns& x) const {
  FrontalCholesky::FourColumns product = FrontalCholesky::FourColumns::Zero(x.rows(), 4);
  Eigen::Matrix<double, 16, 4, Eigen::RowMajor> local;
  for (std::size_t l = 0; l < terms_.size(); ++l) {
    const std::span<const std::uint32_t> active = system_.basis().Active(system_.basis().leaves()[l]);
    for (std::size_t k = 0; k < 16; ++k) local.row(static_cast<Eigen::Index>(k)) = x.row(active[k]);
    const auto form = Expanded(terms_[l].data);
    const Eigen::Map<const Eigen::Matrix<double, 16, 16>> matrix(form.data());
    const Eigen::Matrix<double, 16, 4, Eigen::RowMajor> result = matrix.lazyProduct(local);
    for (std::size_t k = 0; k < 16; ++k) product.row(active[k]) += result.row(static_cast<Eigen::Index>(k));
  }
  return product;
}

double DirectionalGcv::At(const DirectionalSmoothing& smoothing) const {
  const double mixed = std::sqrt(smoothing.theta * smoothing.z);
  std::array<double, 256> matrix{};
  const auto leaf_matrix = [&](std::size_t l) -> FrontalCholesky::LeafView {
    const SplineSystem::LeafTerms& terms = terms_[l];
    TensorForm sum;
    for (std::size_t k = 0; k < sum.size(); ++k) {
      sum[k] = terms.data[k] + terms.holes[k] + smoothing.theta * terms.uu[k] + smoothing.z * terms.vv[k] +
               mixed * terms.uv[k];
    }
    matrix = Expanded(sum);
    return {matrix.data(), 16};
  };
  const auto factor = FrontalCholesky::Factor(tree_, system_.basis(), leaf_matrix, system_.ridge());
  if (!factor) return std::numeric_limits<double>::infinity();

  // Twicing: c = h + A⁻¹(b − G h), h = A⁻¹ b. The first column carries the data, the others the products for traces.
  FrontalCholesky::FourColumns data = FrontalCholesky::FourColumns::Zero(right_.size(), 4);
  data.col(0) = factor->Solve(right_);
  FrontalCholesky::FourColumns twiced = data;
  twiced.col(0) += factor->Solve(Eigen::VectorXd(right_ - DataTimes(data).col(0)));
  const double squares = squares_ - 2.0 * right_.dot(twiced.col(0)) + twiced.col(0).dot(DataTimes(twiced).col(0));

  const FrontalCholesky::FourColumns once = factor->Solve(data_times_probes_);  // A⁻¹ G ε
  const FrontalCholesky::FourColumns twice = factor->Solve(DataTimes(once));    // A⁻¹ G A⁻¹ G ε
  const double trace = (probes_.array() * (2.0 * once.array() - twice.array())).sum() / 4.0;
  const double freedom = total_weight_ - trace;
  if (!(freedom > 0.0) || !std::isfinite(squares)) return std::numeric_limits<double>::infinity();
  return total_weight_ * squares / (freedom * freedom) * system_.noise_sigma() * system_.noise_sigma();
}

DirectionalSmoothing ChooseDirectionalSmoothing(const DirectionalGcv& score) {
  DirectionalSmoothing chosen;
  const double at_one = score.At(chosen);
  if (!std::isfinite(at_one)) return chosen;
  chosen.theta = LowestFactor([&](double factor) { return score.At({factor, 1.0}); }, at_one);
  const double at_theta = score.At(chosen);
  chosen.z = LowestFactor([&](double factor) { return score.At({chosen.theta, factor}); }, at_theta);
  return chosen;
}

}  // namespace annulus
