#include "fitting/directional_smoothing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace annulus {
namespace {

constexpr std::uint64_t kProbeSeed = 20'000'101;
constexpr double kStep = 2.5;      // factor between the points of a parabola
constexpr double kLargest = 64.0;  // of a factor, and its inverse

/// A factor and the score there, as far as known.
struct Lowest {
  double factor = 1.0;
  double score = 0.0;
};

/// Where the parabola through three points, one step apart in the logarithm, is lowest, and how low; moves on while an
/// end is lowest.
Lowest FindLowest(const std::function<double(double)>& score, double at_one) {
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
  if (!(bend > 0.0) || !std::isfinite(bend)) return {std::exp(centre), middle};
  const double shift = std::clamp(0.5 * (low - high) / bend, std::max(-1.0, (-furthest - centre) / step),
                                  std::min(1.0, (furthest - centre) / step));
  return {std::exp(centre + shift * step), middle + 0.5 * shift * (high - low) + 0.5 * shift * shift * bend};
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
    : system_(system), tree_(std::move(tree)), weights_(weights), factors_(factors), data_(system.DataForms(factors)) {
  const double scale = 1.0 / (system.noise_sigma() * system.noise_sigma());
  for (std::size_t k = 0; k < system.rows().size(); ++k) {
    const SampleRow& row = system.rows()[k];
    const double weight = static_cast<double>(row.weight) * (factors.empty() ? 1.0 : factors[k]);
    squares_ += scale * weight * row.radius * row.radius;
    if (weight > 0.0) total_weight_ += 1.0;
  }
  std::mt19937_64 engine(kProbeSeed);
  probes_.resize(static_cast<Eigen::Index>(system.basis().size()), 4);
  for (Eigen::Index k = 0; k < probes_.size(); ++k) probes_.data()[k] = (engine() & 1U) != 0U ? 1.0 : -1.0;
  right_ = DataTimes(probes_);
  right_.col(0) = system.WeightedTranspose(system.Radii(), factors);
}

FrontalCholesky::FourColumns DirectionalGcv::DataTimes(const FrontalCholesky::FourColumns& x) const {
  FrontalCholesky::FourColumns product = FrontalCholesky::FourColumns::Zero(x.rows(), 4);
  for (std::size_t l = 0; l < data_.size(); ++l) {
    const std::span<const std::uint32_t> active = system_.basis().Active(system_.basis().leaves()[l]);
    const double* block = data_[l].data();
    for (std::size_t b = 0; b < 4; ++b) {
      for (std::size_t a = 0; a <= b; ++a, block += 16) {
        for (std::size_t k = 0; k < 16; ++k) {
          product.row(active[4 * a + k % 4]) += block[k] * x.row(active[4 * b + k / 4]);
          if (a != b) product.row(active[4 * b + k % 4]) += block[k] * x.row(active[4 * a + k / 4]);
        }
      }
    }
  }
  return product;
}

double DirectionalGcv::At(const DirectionalSmoothing& smoothing) const {
  const auto factor = system_.Factor(tree_, Scaled(weights_, smoothing), factors_);
  if (!factor) return std::numeric_limits<double>::infinity();
  // The first column is the data, b; the others are G ε with probes ε. Twicing: c = (2A⁻¹ − A⁻¹GA⁻¹) b, and the trace
  // of A⁻¹G(2 − A⁻¹G) is the mean of ε·(the same operator on Gε).
  const FrontalCholesky::FourColumns once = factor->Solve(right_);
  const FrontalCholesky::FourColumns twiced = 2.0 * once - factor->Solve(DataTimes(once));
  const double squares =
      squares_ - 2.0 * right_.col(0).dot(twiced.col(0)) + twiced.col(0).dot(DataTimes(twiced).col(0));
  const double trace = (probes_.rightCols<3>().array() * twiced.rightCols<3>().array()).sum() / 3.0;
  const double freedom = total_weight_ - trace;
  if (!(freedom > 0.0) || !std::isfinite(squares)) return std::numeric_limits<double>::infinity();
  return total_weight_ * squares / (freedom * freedom) * system_.noise_sigma() * system_.noise_sigma();
}

DirectionalSmoothing ChooseDirectionalSmoothing(const DirectionalGcv& score) {
  const double at_one = score.At({});
  if (!std::isfinite(at_one)) return {};
  const Lowest theta = FindLowest([&](double factor) { return score.At({factor, 1.0}); }, at_one);
  const Lowest z = FindLowest([&](double factor) { return score.At({theta.factor, factor}); }, theta.score);
  return {theta.factor, z.factor};
}

}  // namespace annulus
