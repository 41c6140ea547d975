#include "fitting/spline_system.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr int kProbes = 6;
constexpr std::uint64_t kProbeSeed = 20'000'101;
constexpr double kRidge = 1e-10;

}  // namespace

void LeafForms::AddOuter(std::size_t leaf, const std::array<double, 4>& theta, const std::array<double, 4>& z,
                         double weight) {
  Eigen::Matrix<double, 16, 1> row;
  for (Eigen::Index j = 0; j < 4; ++j) {
    for (Eigen::Index i = 0; i < 4; ++i) {
      row[4 * j + i] = z[static_cast<std::size_t>(j)] * theta[static_cast<std::size_t>(i)];
    }
  }
  Block& block = blocks_[leaf];
  for (Eigen::Index column = 0; column < 16; ++column) {
    block.col(column).head(column + 1) += (weight * row[column]) * row.head(column + 1);
  }
}

void LeafForms::Add(const LeafForms& other, double factor) {
  ENSURE(other.blocks_.size() == blocks_.size(), "same basis");
  for (std::size_t k = 0; k < blocks_.size(); ++k) blocks_[k] += factor * other.blocks_[k];
}

Eigen::SparseMatrix<double> LeafForms::Assemble(const HierarchicalSpline& basis) const {
  std::vector<Eigen::Triplet<double>> triplets;
  Eigen::Matrix<double, Eigen::Dynamic, 16> half;
  Eigen::MatrixXd local;
  for (std::size_t k = 0; k < blocks_.size(); ++k) {
    const SplineLeaf& leaf = basis.leaves()[k];
    half = leaf.extraction * blocks_[k].selfadjointView<Eigen::Upper>();
    local.noalias() = half * leaf.extraction.transpose();
    for (std::size_t b = 0; b < leaf.active.size(); ++b) {
      for (std::size_t a = 0; a <= b; ++a) {  // `active` ascends: this is the upper triangle
        triplets.emplace_back(static_cast<int>(leaf.active[a]), static_cast<int>(leaf.active[b]),
                              local(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)));
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(basis.size());
  Eigen::SparseMatrix<double> upper(n, n);
  upper.setFromTriplets(triplets.begin(), triplets.end());
  return upper;
}

SplineSystem::SplineSystem(const HierarchicalSpline& basis, std::span<const SurfaceSample> samples,
                           const std::vector<char>& use, double noise_sigma)
    : basis_(basis), noise_sigma_(noise_sigma) {
  ENSURE(noise_sigma > 0.0, "the noise scale is positive");
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (use[k] == 0) continue;
    const SurfaceSample& s = samples[k];
    SampleRow row;
    row.leaf = static_cast<std::uint32_t>(basis.LeafAt(s.theta, s.z));
    const SplineLeaf& leaf = basis.leaves()[row.leaf];
    const SplineLevel& level = basis.levels()[leaf.level];
    row.theta = level.theta.InInterval(leaf.theta_cell, s.theta).value;
    row.z = level.z.InInterval(leaf.z_cell, s.z).value;
    row.radius = s.radius;
    row.weight = s.weight;
    row.sample = static_cast<std::uint32_t>(k);
    rows_.push_back(row);
  }
  std::stable_sort(rows_.begin(), rows_.end(), [](const SampleRow& a, const SampleRow& b) { return a.leaf < b.leaf; });
}

Eigen::VectorXd SplineSystem::Predict(const Eigen::VectorXd& coefficients) const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(rows_.size()));
  Eigen::Matrix<double, 16, 1> local = Eigen::Matrix<double, 16, 1>::Zero();
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const SampleRow& row = rows_[k];
    if (k == 0 || row.leaf != rows_[k - 1].leaf) {
      const SplineLeaf& leaf = basis_.leaves()[row.leaf];
      local.setZero();
      for (std::size_t a = 0; a < leaf.active.size(); ++a) {
        local += coefficients[static_cast<Eigen::Index>(leaf.active[a])] *
                 leaf.extraction.row(static_cast<Eigen::Index>(a)).transpose();
      }
    }
    double value = 0.0;
    for (std::size_t j = 0; j < 4; ++j) {
      const double* c = local.data() + 4 * j;
      value += row.z[j] * (row.theta[0] * c[0] + row.theta[1] * c[1] + row.theta[2] * c[2] + row.theta[3] * c[3]);
    }
    values[static_cast<Eigen::Index>(k)] = value;
  }
  return values;
}

Eigen::VectorXd SplineSystem::Residuals(const Eigen::VectorXd& coefficients) const {
  Eigen::VectorXd residuals = -Predict(coefficients);
  for (std::size_t k = 0; k < rows_.size(); ++k) residuals[static_cast<Eigen::Index>(k)] += rows_[k].radius;
  return residuals;
}

Eigen::VectorXd SplineSystem::Transpose(const Eigen::VectorXd& values) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(basis_.size()));
  Eigen::Matrix<double, 16, 1> local = Eigen::Matrix<double, 16, 1>::Zero();
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const SampleRow& row = rows_[k];
    for (std::size_t j = 0; j < 4; ++j) {
      const double left = values[static_cast<Eigen::Index>(k)] * row.z[j];
      for (std::size_t i = 0; i < 4; ++i) local[static_cast<Eigen::Index>(4 * j + i)] += left * row.theta[i];
    }
    if (k + 1 == rows_.size() || row.leaf != rows_[k + 1].leaf) {
      const SplineLeaf& leaf = basis_.leaves()[row.leaf];
      const Eigen::VectorXd spread = leaf.extraction * local;
      for (std::size_t a = 0; a < leaf.active.size(); ++a) {
        sum[static_cast<Eigen::Index>(leaf.active[a])] += spread[static_cast<Eigen::Index>(a)];
      }
      local.setZero();
    }
  }
  return sum;
}

LeafForms SplineSystem::DataForms(std::span<const double> factors) const {
  LeafForms forms(basis_);
  const double scale = 1.0 / (noise_sigma_ * noise_sigma_);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const SampleRow& row = rows_[k];
    const double weight = scale * static_cast<double>(row.weight) * (factors.empty() ? 1.0 : factors[k]);
    forms.AddOuter(row.leaf, row.theta, row.z, weight);
  }
  return forms;
}

Eigen::VectorXd SplineSystem::DataVector() const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(rows_.size()));
  const double scale = 1.0 / (noise_sigma_ * noise_sigma_);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    values[static_cast<Eigen::Index>(k)] = scale * static_cast<double>(rows_[k].weight) * rows_[k].radius;
  }
  return Transpose(values);
}

void AddRidge(Eigen::SparseMatrix<double>& upper) {
  const double ridge = kRidge * upper.diagonal().mean();
  for (Eigen::Index k = 0; k < upper.cols(); ++k) upper.coeffRef(k, k) += ridge;
}

double EffectiveParameters(const SparseFactor& factor, const Eigen::SparseMatrix<double>& data_upper) {
  std::mt19937_64 engine(kProbeSeed);
  double sum = 0.0;
  for (int probe = 0; probe < kProbes; ++probe) {
    Eigen::VectorXd signs(data_upper.rows());
    for (Eigen::Index k = 0; k < signs.size(); ++k) signs[k] = (engine() & 1U) != 0U ? 1.0 : -1.0;
    const Eigen::VectorXd data_times_signs = data_upper.selfadjointView<Eigen::Upper>() * signs;
    sum += factor.solve(signs).dot(data_times_signs);
  }
  return sum / kProbes;
}

namespace {

/// The GCV score as a function of log λ. Keeps what it has tried, and the analysis of the pattern.
class GcvScore {
 public:
  GcvScore(const SplineSystem& system, const LeafForms& fixed, const LeafForms& penalty)
      : system_(system),
        data_(system.DataForms({}).Assemble(system.basis())),
        prior_(fixed.Assemble(system.basis())),
        rough_(penalty.Assemble(system.basis())),
        right_(system.DataVector()) {}

  /// Where data and penalty have the same mean diagonal: the middle of the search.
  [[nodiscard]] double balanced_log_lambda() const {
    return std::log(data_.diagonal().mean() / rough_.diagonal().mean());
  }

  const SmoothingChoice& At(double log_lambda) {
    auto found = tried_.find(log_lambda);
    if (found == tried_.end()) found = tried_.emplace(log_lambda, Evaluate(std::exp(log_lambda))).first;
    return found->second;
  }

  /// The best that was tried, or null if no λ gave a finite score.
  [[nodiscard]] const SmoothingChoice* best() const {
    const SmoothingChoice* chosen = nullptr;
    for (const auto& [log_lambda, choice] : tried_) {
      if (std::isfinite(choice.gcv) && (chosen == nullptr || choice.gcv < chosen->gcv)) chosen = &choice;
    }
    return chosen;
  }

 private:
  SmoothingChoice Evaluate(double lambda) {
    SmoothingChoice choice;
    choice.lambda = lambda;
    choice.gcv = std::numeric_limits<double>::infinity();
    Eigen::SparseMatrix<double> upper = data_ + prior_ + lambda * rough_;
    AddRidge(upper);
    if (tried_.empty()) factor_.analyzePattern(upper);
    factor_.factorize(upper);
    if (factor_.info() != Eigen::Success) return choice;
    choice.coefficients = factor_.solve(right_);
    choice.effective_parameters = EffectiveParameters(factor_, data_);
    const Eigen::VectorXd residuals = system_.Residuals(choice.coefficients);
    double squares = 0.0;
    for (std::size_t k = 0; k < system_.rows().size(); ++k) {
      const double residual = residuals[static_cast<Eigen::Index>(k)];
      squares += static_cast<double>(system_.rows()[k].weight) * residual * residual;
    }
    const auto n = static_cast<double>(system_.rows().size());
    const double freedom = n - choice.effective_parameters;
    if (freedom > 0.0 && std::isfinite(squares)) choice.gcv = n * squares / (freedom * freedom);
    return choice;
  }

  const SplineSystem& system_;
  Eigen::SparseMatrix<double> data_;
  Eigen::SparseMatrix<double> prior_;
  Eigen::SparseMatrix<double> rough_;
  Eigen::VectorXd right_;
  SparseFactor factor_;
  std::map<double, SmoothingChoice> tried_;
};

}  // namespace

Result<SmoothingChoice> ChooseSmoothing(const SplineSystem& system, const LeafForms& fixed, const LeafForms& penalty) {
  // A walk downhill in decades, then golden section inside the bracket.
  constexpr int kDecades = 8;
  constexpr int kSections = 4;
  GcvScore score(system, fixed, penalty);
  const double decade = std::log(10.0);
  const double centre = score.balanced_log_lambda();
  const auto at = [&](int step) { return score.At(centre + step * decade).gcv; };
  int best = 0;
  while (best > -kDecades && at(best - 1) < at(best)) --best;
  while (best < kDecades && at(best + 1) < at(best)) ++best;
  double low = centre + (best - 1) * decade;
  double high = centre + (best + 1) * decade;
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  double left = high - golden * (high - low);
  double right = low + golden * (high - low);
  for (int step = 0; step < kSections; ++step) {
    if (score.At(left).gcv < score.At(right).gcv) {
      high = right;
      right = left;
      left = high - golden * (high - low);
    } else {
      low = left;
      left = right;
      right = low + golden * (high - low);
    }
  }
  const SmoothingChoice* chosen = score.best();
  if (chosen == nullptr) {
    return Fail("fit a surface", "the samples do not determine it at any smoothing",
                "scan again: too few returns, or all in one place");
  }
  return *chosen;
}

}  // namespace annulus
