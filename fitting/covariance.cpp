#include "fitting/covariance.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "fitting/elimination_tree.h"
#include "fitting/frontal_cholesky.h"
#include "fitting/frontal_inverse.h"

namespace annulus {
namespace {

using Ldlt = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Upper>;

/// The entries of A⁻¹ on the pattern of L (A = PᵀLDLᵀP), in the permuted order: lower triangle by columns.
/// Takahashi, Fagan, Chin (1973): Z_Si = −Z_SS L_Si, Z_ii = 1/d_i − L_Siᵀ Z_Si, for columns i from the last to the
/// first, where S are the rows of column i of L below the diagonal; all of Z_SS lies on the pattern.
class SelectedInverse {
 public:
  explicit SelectedInverse(const Ldlt& ldlt) {
    const Eigen::SparseMatrix<double>& l = ldlt.matrixL().nestedExpression();
    const Eigen::VectorXd d = ldlt.vectorD();
    const Eigen::Index n = l.cols();
    start_.assign(static_cast<std::size_t>(n) + 1, 0);
    std::vector<double> l_values;
    for (Eigen::Index column = 0; column < n; ++column) {
      for (Eigen::SparseMatrix<double>::InnerIterator entry(l, column); entry; ++entry) {
        if (entry.row() <= column) continue;
        rows_.push_back(entry.row());
        l_values.push_back(entry.value());
      }
      start_[static_cast<std::size_t>(column) + 1] = rows_.size();
    }
    values_.assign(rows_.size(), 0.0);
    diagonal_.assign(static_cast<std::size_t>(n), 0.0);
    std::vector<std::ptrdiff_t> position(static_cast<std::size_t>(n), -1);
    std::vector<double> product;
    for (Eigen::Index column = n - 1; column >= 0; --column) {
      const std::size_t first = start_[static_cast<std::size_t>(column)];
      const std::size_t last = start_[static_cast<std::size_t>(column) + 1];
      product.assign(last - first, 0.0);
      for (std::size_t k = first; k < last; ++k) {
        position[static_cast<std::size_t>(rows_[k])] = static_cast<std::ptrdiff_t>(k - first);
      }
      for (std::size_t k = first; k < last; ++k) {
        const auto j = static_cast<std::size_t>(rows_[k]);
        product[k - first] += diagonal_[j] * l_values[k];
        for (std::size_t m = start_[j]; m < start_[j + 1]; ++m) {
          const std::ptrdiff_t other = position[static_cast<std::size_t>(rows_[m])];
          if (other < 0) continue;
          product[static_cast<std::size_t>(other)] += values_[m] * l_values[k];
          product[k - first] += values_[m] * l_values[first + static_cast<std::size_t>(other)];
        }
      }
      double diagonal = 1.0 / d[column];
      for (std::size_t k = first; k < last; ++k) {
        values_[k] = -product[k - first];
        diagonal += l_values[k] * product[k - first];
        position[static_cast<std::size_t>(rows_[k])] = -1;
      }
      diagonal_[static_cast<std::size_t>(column)] = diagonal;
    }
  }

  /// Entry (a, b) of the permuted inverse, or nothing if it does not lie on the pattern.
  [[nodiscard]] std::optional<double> At(Eigen::Index a, Eigen::Index b) const {
    if (a == b) return diagonal_[static_cast<std::size_t>(a)];
    const auto column = static_cast<std::size_t>(std::min(a, b));
    const auto begin = rows_.begin() + static_cast<std::ptrdiff_t>(start_[column]);
    const auto end = rows_.begin() + static_cast<std::ptrdiff_t>(start_[column + 1]);
    const auto found = std::lower_bound(begin, end, std::max(a, b));
    if (found == end || *found != std::max(a, b)) return std::nullopt;
    return values_[static_cast<std::size_t>(found - rows_.begin())];
  }

 private:
  std::vector<std::size_t> start_;
  std::vector<Eigen::Index> rows_;
  std::vector<double> values_;
  std::vector<double> diagonal_;
};

}  // namespace

/// A factor of A, either of two kinds.
class SurfaceCovariance::Factor {
 public:
  Factor() = default;
  Factor(const Factor&) = delete;
  Factor& operator=(const Factor&) = delete;
  virtual ~Factor() = default;
  [[nodiscard]] virtual Eigen::Index size() const = 0;
  /// gᵀA⁻¹g for up to four gradients.
  using Four = std::array<double, 4>;
  [[nodiscard]] virtual Four Variances(std::span<const Eigen::VectorXd> gradients) const = 0;
  /// B·signs with B·Bᵀ = A⁻¹.
  [[nodiscard]] virtual Eigen::VectorXd Deviation(const Eigen::VectorXd& signs) const = 0;
  /// gᵀA⁻¹g from entries of A⁻¹; nothing if one that is needed lies off the pattern.
  [[nodiscard]] virtual std::optional<double> LocalVariance(std::span<const CoefficientWeight> gradient) = 0;
};

/// For any matrix.
class SurfaceCovariance::SimplicialFactor final : public Factor {
 public:
  explicit SimplicialFactor(const Eigen::SparseMatrix<double>& upper) { ldlt_.compute(upper); }

  [[nodiscard]] bool sound() const { return ldlt_.info() == Eigen::Success && (ldlt_.vectorD().array() > 0.0).all(); }
  [[nodiscard]] Eigen::Index size() const override { return ldlt_.rows(); }
  [[nodiscard]] Four Variances(std::span<const Eigen::VectorXd> gradients) const override {
    Four variances{};
    for (std::size_t k = 0; k < gradients.size(); ++k) variances[k] = gradients[k].dot(ldlt_.solve(gradients[k]));
    return variances;
  }
  [[nodiscard]] Eigen::VectorXd Deviation(const Eigen::VectorXd& signs) const override {
    const Eigen::VectorXd scaled = signs.array() / ldlt_.vectorD().array().sqrt();
    return ldlt_.permutationPinv() * Eigen::VectorXd(ldlt_.matrixU().solve(scaled));
  }
  [[nodiscard]] std::optional<double> LocalVariance(std::span<const CoefficientWeight> gradient) override {
    if (!inverse_) inverse_.emplace(ldlt_);
    const auto& order = ldlt_.permutationP().indices();
    double variance = 0.0;
    for (const CoefficientWeight& a : gradient) {
      for (const CoefficientWeight& b : gradient) {
        if (a.weight == 0.0 || b.weight == 0.0) continue;
        const auto entry =
            inverse_->At(order[static_cast<Eigen::Index>(a.index)], order[static_cast<Eigen::Index>(b.index)]);
        if (!entry) return std::nullopt;
        variance += a.weight * b.weight * *entry;
      }
    }
    return std::max(variance, 0.0);
  }

 private:
  Ldlt ldlt_;
  std::optional<SelectedInverse> inverse_;
};

/// For the active coefficients of a hierarchical spline.
class SurfaceCovariance::FrontFactor final : public Factor {
 public:
  explicit FrontFactor(FrontalCholesky factor) : factor_(std::move(factor)) {}

  [[nodiscard]] Eigen::Index size() const override { return factor_.size(); }
  [[nodiscard]] Four Variances(std::span<const Eigen::VectorXd> gradients) const override {
    FrontalCholesky::FourColumns columns = FrontalCholesky::FourColumns::Zero(factor_.size(), 4);
    for (std::size_t k = 0; k < gradients.size(); ++k) columns.col(static_cast<Eigen::Index>(k)) = gradients[k];
    const Eigen::RowVector4d sums = factor_.SolveLower(columns).colwise().squaredNorm();
    return {sums[0], sums[1], sums[2], sums[3]};
  }
  [[nodiscard]] Eigen::VectorXd Deviation(const Eigen::VectorXd& signs) const override {
    return factor_.SolveUpper(signs);
  }
  [[nodiscard]] std::optional<double> LocalVariance(std::span<const CoefficientWeight> gradient) override {
    if (!inverse_) inverse_.emplace(factor_);
    return inverse_->Variance(gradient);
  }

 private:
  FrontalCholesky factor_;
  std::optional<FrontalInverse> inverse_;
};

SurfaceCovariance::SurfaceCovariance(std::unique_ptr<Factor> factor) : factor_(std::move(factor)) {}
SurfaceCovariance::SurfaceCovariance(SurfaceCovariance&&) noexcept = default;
SurfaceCovariance& SurfaceCovariance::operator=(SurfaceCovariance&&) noexcept = default;
SurfaceCovariance::~SurfaceCovariance() = default;

Result<SurfaceCovariance> SurfaceCovariance::FromNormalMatrix(const Eigen::SparseMatrix<double>& upper) {
  auto factor = std::make_unique<SimplicialFactor>(upper);
  if (!factor->sound()) {
    return Fail("compute the model's uncertainty", "its normal matrix is not positive definite", "fit the scan again");
  }
  return SurfaceCovariance(std::move(factor));
}

Result<SurfaceCovariance> SurfaceCovariance::FromNormalMatrix(const Eigen::SparseMatrix<double>& upper,
                                                              const HierarchicalSpline& basis) {
  if (upper.cols() != static_cast<Eigen::Index>(basis.size())) {
    return Fail("compute the model's uncertainty", "its normal matrix has another size than its surface",
                "fit the scan again");
  }
  auto factor = FrontalCholesky::Factor(std::make_shared<const EliminationTree>(basis), upper);
  if (!factor) return FromNormalMatrix(upper);  // it has entries of its own, or says what is wrong
  return SurfaceCovariance(std::make_unique<FrontFactor>(std::move(*factor)));
}

double SurfaceCovariance::Variance(const Eigen::VectorXd& gradient) const {
  return factor_->Variances(std::span(&gradient, 1)).front();
}

std::vector<double> SurfaceCovariance::Variances(std::span<const Eigen::VectorXd> gradients) const {
  std::vector<double> variances;
  for (std::size_t first = 0; first < gradients.size(); first += 4) {
    const auto part = gradients.subspan(first, std::min<std::size_t>(4, gradients.size() - first));
    const Factor::Four four = factor_->Variances(part);
    variances.insert(variances.end(), four.begin(), four.begin() + static_cast<std::ptrdiff_t>(part.size()));
  }
  return variances;
}

Eigen::VectorXd SurfaceCovariance::Deviation(const Eigen::VectorXd& signs) const { return factor_->Deviation(signs); }

double SurfaceCovariance::LocalVariance(std::span<const CoefficientWeight> gradient) const {
  if (const std::optional<double> variance = factor_->LocalVariance(gradient)) return *variance;
  // A matrix from a file may have fewer entries than the surface couples: then A⁻¹g is solved for.
  Eigen::VectorXd dense = Eigen::VectorXd::Zero(factor_->size());
  for (const CoefficientWeight& entry : gradient) dense[static_cast<Eigen::Index>(entry.index)] += entry.weight;
  return Variance(dense);
}

}  // namespace annulus
