#include "fitting/spline_system.h"

#include <algorithm>
#include <numeric>
#include <random>

#include "base/ensure.h"
#include "fitting/front_kernels.h"

namespace annulus {
namespace {

constexpr std::uint64_t kProbeSeed = 20'000'101;
/// Share of the mean data weight of a coefficient that keeps coefficients over holes determined.
constexpr double kRidge = 1e-9;

/// Places of items sorted by key: items of key k are order[first[k]] … order[first[k + 1] − 1], in their given order.
struct Buckets {
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> first;
};

Buckets SortByKey(const std::vector<std::uint32_t>& key, std::size_t keys) {
  Buckets buckets{std::vector<std::uint32_t>(key.size()), std::vector<std::uint32_t>(keys + 1, 0)};
  for (const std::uint32_t k : key) ++buckets.first[k + 1];
  std::partial_sum(buckets.first.begin(), buckets.first.end(), buckets.first.begin());
  std::vector<std::uint32_t> next(buckets.first.begin(), buckets.first.end() - 1);
  for (std::size_t n = 0; n < key.size(); ++n) buckets.order[next[key[n]]++] = static_cast<std::uint32_t>(n);
  return buckets;
}

}  // namespace

/// Makes the equations of one leaf after the other.
class SplineSystem::LeafEquations {
 public:
  LeafEquations(const SplineSystem& system, const RoughnessWeights& weights, std::span<const double> factors)
      : system_(system), weights_(weights), factors_(factors) {
    const CellGrid& cells = system.cells_;
    uu_scale_ = std::pow(cells.theta_step(), 4);
    vv_scale_ = std::pow(cells.z_step(), 4);
    uv_scale_ = std::pow(cells.theta_step() * cells.z_step(), 2);
    hole_theta_ = HoleWeight(cells.theta_step());
    hole_z_ = HoleWeight(cells.z_step());
    for (const SplineLevel& level : system.basis_.levels()) {
      std::vector<CubicBasis>& around = theta_bases_.emplace_back();
      for (std::size_t c = 0; c < cells.columns(); ++c) around.push_back(level.theta.At(cells.theta(c)));
      std::vector<CubicBasis>& up = z_bases_.emplace_back();
      for (std::size_t r = 0; r < cells.rows(); ++r) up.push_back(level.z.At(cells.z(r)));
    }
  }

  /// The leaf's matrix over its active coefficients; valid until the next call.
  FrontalCholesky::LeafView Matrix(std::size_t l) {
    const SplineLeaf& leaf = system_.basis_.leaves()[l];
    CollectRows(l, leaf);
    form_.fill(0.0);
    AddTensorRows(tensor_rows_, form_);
    for (std::size_t b = 0, pair = 0; b < 4; ++b) {
      for (std::size_t a = 0; a <= b; ++a, ++pair) {
        for (std::size_t k = 0; k < 4; ++k) {
          const double* from = form_.data() + 16 * pair + 4 * k;
          std::copy_n(from, 4, local_.data() + 16 * (4 * b + k) + 4 * a);
          std::copy_n(from, 4, local_.data() + 16 * (4 * a + k) + 4 * b);
        }
      }
    }
    if (leaf.plain) return {local_.data(), 16};
    const std::size_t stride = (leaf.count + kFrontLanes - 1) / kFrontLanes * kFrontLanes;
    matrix_.resize(std::max(matrix_.size(), stride * leaf.count));
    ProjectForm(local_.data(), system_.basis_.ExtractionOf(leaf).data(), leaf.count, matrix_.data(), stride);
    return {matrix_.data(), stride};
  }

 private:
  static double HoleWeight(double step) { return std::pow(step / kHoleSlope, 2); }

  void CollectRows(std::size_t l, const SplineLeaf& leaf) {
    tensor_rows_.clear();
    const double scale = 1.0 / (system_.noise_sigma_ * system_.noise_sigma_);
    for (std::uint32_t k = system_.row_first_[l]; k < system_.row_first_[l + 1]; ++k) {
      const SampleRow& row = system_.rows_[k];
      const double factor = factors_.empty() ? 1.0 : factors_[k];
      tensor_rows_.push_back({row.theta, row.z, scale * static_cast<double>(row.weight) * factor});
    }
    const CellGrid& cells = system_.cells_;
    for (std::uint32_t k = system_.cell_first_[l]; k < system_.cell_first_[l + 1]; ++k) {
      const std::uint32_t cell = system_.cell_order_[k];
      const std::size_t column = cell % cells.columns();
      const std::size_t row = cell / cells.columns();
      const CubicBasis& theta = theta_bases_[leaf.level][column];
      const CubicBasis& z = z_bases_[leaf.level][row];
      const CellBend& w = weights_.cells[cell];
      tensor_rows_.push_back({theta.second, z.value, w.uu * uu_scale_});
      tensor_rows_.push_back({theta.value, z.second, w.vv * vv_scale_});
      tensor_rows_.push_back({theta.first, z.first, w.uv * uv_scale_});
      if (cells.count(column, row) > 0) continue;
      tensor_rows_.push_back({theta.first, z.value, hole_theta_});
      tensor_rows_.push_back({theta.value, z.first, hole_z_});
    }
  }

  const SplineSystem& system_;
  const RoughnessWeights& weights_;
  std::span<const double> factors_;
  double uu_scale_ = 0.0, vv_scale_ = 0.0, uv_scale_ = 0.0, hole_theta_ = 0.0, hole_z_ = 0.0;
  std::vector<std::vector<CubicBasis>> theta_bases_;  ///< By level and column of cells.
  std::vector<std::vector<CubicBasis>> z_bases_;      ///< By level and row of cells.
  std::vector<TensorRow> tensor_rows_;
  TensorForm form_{};
  std::array<double, 256> local_{};  ///< 16 × 16
  std::vector<double> matrix_;
};

SplineSystem::SplineSystem(const HierarchicalSpline& basis, const UsedSamples& used, const CellGrid& cells)
    : basis_(basis), cells_(cells), noise_sigma_(used.noise_sigma) {
  ENSURE(used.noise_sigma > 0.0, "the noise scale is positive");
  std::vector<std::uint32_t> samples;
  std::vector<std::uint32_t> leaf_of;
  for (std::size_t k = 0; k < used.samples.size(); ++k) {
    if (used.use[k] == 0) continue;
    samples.push_back(static_cast<std::uint32_t>(k));
    leaf_of.push_back(static_cast<std::uint32_t>(basis.LeafAt(used.samples[k].theta, used.samples[k].z)));
  }
  Buckets buckets = SortByKey(leaf_of, basis.leaves().size());
  row_first_ = std::move(buckets.first);
  rows_.resize(samples.size());
  for (std::size_t n = 0; n < rows_.size(); ++n) {
    SampleRow& row = rows_[n];
    row.sample = samples[buckets.order[n]];
    row.leaf = leaf_of[buckets.order[n]];
    const SurfaceSample& s = used.samples[row.sample];
    const SplineLeaf& leaf = basis.leaves()[row.leaf];
    const SplineLevel& level = basis.levels()[leaf.level];
    row.theta = level.theta.InInterval(leaf.theta_cell, s.theta).value;
    row.z = level.z.InInterval(leaf.z_cell, s.z).value;
    row.radius = s.radius;
    row.weight = s.weight;
  }

  std::vector<std::uint32_t> leaf_of_cell(cells.columns() * cells.rows());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      leaf_of_cell[cells.Index(column, row)] =
          static_cast<std::uint32_t>(basis.LeafAt(cells.theta(column), cells.z(row)));
    }
  }
  Buckets by_leaf = SortByKey(leaf_of_cell, basis.leaves().size());
  cell_order_ = std::move(by_leaf.order);
  cell_first_ = std::move(by_leaf.first);
}

Eigen::VectorXd SplineSystem::Predict(const Eigen::VectorXd& coefficients) const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t l = 0; l + 1 < row_first_.size(); ++l) {
    if (row_first_[l] == row_first_[l + 1]) continue;
    const Eigen::Matrix<double, 16, 1> local = basis_.Local(basis_.leaves()[l], coefficients);
    for (std::uint32_t k = row_first_[l]; k < row_first_[l + 1]; ++k) {
      const SampleRow& row = rows_[k];
      double value = 0.0;
      for (std::size_t j = 0; j < 4; ++j) {
        const double* c = local.data() + 4 * j;
        value += row.z[j] * (row.theta[0] * c[0] + row.theta[1] * c[1] + row.theta[2] * c[2] + row.theta[3] * c[3]);
      }
      values[static_cast<Eigen::Index>(k)] = value;
    }
  }
  return values;
}

Eigen::VectorXd SplineSystem::Radii() const {
  Eigen::VectorXd radii(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t k = 0; k < rows_.size(); ++k) radii[static_cast<Eigen::Index>(k)] = rows_[k].radius;
  return radii;
}

Eigen::VectorXd SplineSystem::Residuals(const Eigen::VectorXd& coefficients) const {
  return Radii() - Predict(coefficients);
}

Eigen::VectorXd SplineSystem::Transpose(const Eigen::VectorXd& values) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(basis_.size()));
  for (std::size_t l = 0; l + 1 < row_first_.size(); ++l) {
    if (row_first_[l] == row_first_[l + 1]) continue;
    Eigen::Matrix<double, 16, 1> local = Eigen::Matrix<double, 16, 1>::Zero();
    for (std::uint32_t k = row_first_[l]; k < row_first_[l + 1]; ++k) {
      const SampleRow& row = rows_[k];
      for (std::size_t j = 0; j < 4; ++j) {
        const double left = values[static_cast<Eigen::Index>(k)] * row.z[j];
        for (std::size_t i = 0; i < 4; ++i) local[static_cast<Eigen::Index>(4 * j + i)] += left * row.theta[i];
      }
    }
    const SplineLeaf& leaf = basis_.leaves()[l];
    const std::span<const std::uint32_t> active = basis_.Active(leaf);
    for (std::size_t a = 0; a < active.size(); ++a) {
      const auto index = static_cast<Eigen::Index>(a);
      sum[static_cast<Eigen::Index>(active[a])] +=
          leaf.plain ? local[index] : basis_.ExtractionOf(leaf).col(index).dot(local);
    }
  }
  return sum;
}

Eigen::VectorXd SplineSystem::WeightedTranspose(const Eigen::VectorXd& values, std::span<const double> factors) const {
  Eigen::VectorXd weighted(values.size());
  const double scale = 1.0 / (noise_sigma_ * noise_sigma_);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const double factor = factors.empty() ? 1.0 : factors[k];
    const auto index = static_cast<Eigen::Index>(k);
    weighted[index] = scale * static_cast<double>(rows_[k].weight) * factor * values[index];
  }
  return Transpose(weighted);
}

std::optional<FrontalCholesky> SplineSystem::Factor(std::shared_ptr<const EliminationTree> tree,
                                                    const RoughnessWeights& weights,
                                                    std::span<const double> factors) const {
  LeafEquations equations(*this, weights, factors);
  const double ridge =
      kRidge * static_cast<double>(rows_.size()) / static_cast<double>(basis_.size()) / (noise_sigma_ * noise_sigma_);
  return FrontalCholesky::Factor(
      std::move(tree), basis_, [&](std::size_t l) { return equations.Matrix(l); }, ridge);
}

Eigen::SparseMatrix<double> SplineSystem::NormalMatrix(const RoughnessWeights& weights,
                                                       std::span<const double> factors) const {
  LeafEquations equations(*this, weights, factors);
  std::vector<Eigen::Triplet<double>> triplets;
  for (std::size_t l = 0; l < basis_.leaves().size(); ++l) {
    const FrontalCholesky::LeafView matrix = equations.Matrix(l);
    const std::span<const std::uint32_t> active = basis_.Active(basis_.leaves()[l]);
    for (std::size_t b = 0; b < active.size(); ++b) {
      for (std::size_t a = 0; a < active.size(); ++a) {
        if (active[a] > active[b]) continue;
        triplets.emplace_back(static_cast<int>(active[a]), static_cast<int>(active[b]),
                              matrix.data[b * matrix.stride + a]);
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(basis_.size());
  Eigen::SparseMatrix<double> upper(n, n);
  upper.setFromTriplets(triplets.begin(), triplets.end());
  return upper;
}

double EffectiveParameters(const SplineSystem& system, const FrontalCholesky& factor, std::span<const double> factors) {
  std::mt19937_64 engine(kProbeSeed);
  FrontalCholesky::FourColumns signs(factor.size(), 4);
  for (Eigen::Index k = 0; k < signs.size(); ++k) signs.data()[k] = (engine() & 1U) != 0U ? 1.0 : -1.0;
  const FrontalCholesky::FourColumns solved = factor.Solve(signs);
  double sum = 0.0;
  for (Eigen::Index probe = 0; probe < 4; ++probe) {
    const Eigen::VectorXd column = signs.col(probe);
    sum += solved.col(probe).dot(system.WeightedTranspose(system.Predict(column), factors));
  }
  return sum / 4.0;
}

}  // namespace annulus
