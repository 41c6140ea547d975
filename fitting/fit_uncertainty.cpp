#include "fitting/fit_uncertainty.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/units.h"

namespace annulus {
namespace {

constexpr std::uint64_t kDrawSeed = 20'000'101;
constexpr int kSmoothings = kTwicings + 1;
constexpr Eigen::Index kDraws = 4;
/// The first draws tell where the surface averages, the others what noise makes of the residuals there: were they the
/// same, the places would be chosen by what is then counted.
constexpr Eigen::Index kPlacingDraws = 2;
constexpr Eigen::Index kCountingDraws = kDraws - kPlacingDraws;
/// Noise standard deviations; what is further from the surface is no noise but a step that it cannot follow.
constexpr double kOutlierLimit = 4.0;

/// Noise of a row in every draw, or what became of it.
using Draws = Eigen::Array<double, 1, kDraws>;

/// Four signs of a row, the same on every machine (SplitMix64's finaliser: Steele, Lea, Flood 2014).
Draws Signs(std::size_t row) {
  std::uint64_t x = kDrawSeed + 0x9E3779B97F4A7C15ULL * (row + 1);
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  x ^= x >> 31U;
  Draws signs;
  for (Eigen::Index k = 0; k < kDraws; ++k) signs[k] = ((x >> static_cast<unsigned>(k)) & 1U) != 0U ? 1.0 : -1.0;
  return signs;
}

/// Draws of noise, smoothed like the fit's radii.
class SmoothedNoise {
 public:
  explicit SmoothedNoise(const AdaptiveFit& fit) : system_(*fit.system), factors_(fit.factors()) {
    coefficients_ = FrontalCholesky::FourColumns::Zero(fit.factor->size(), kDraws);
    for (int step = 0; step < kSmoothings; ++step) coefficients_ += fit.factor->Solve(WeightedTransposeOfRest());
  }

  /// 1/variance of a row's noise, 1/mm².
  [[nodiscard]] double Weight(std::size_t row) const {
    const double factor = factors_.empty() ? 1.0 : factors_[row];
    return static_cast<double>(system_.rows()[row].weight) * factor / (system_.noise_sigma() * system_.noise_sigma());
  }

  /// Calls visit(row, noise, smoothed noise) for every row, mm.
  template <class Visit>
  void ForRows(Visit visit) const {
    const HierarchicalSpline& basis = system_.basis();
    Local local;
    for (std::size_t k = 0; k < system_.rows().size(); ++k) {
      const SampleRow& row = system_.rows()[k];
      const SplineLeaf& leaf = basis.leaves()[row.leaf];
      if (k == 0 || row.leaf != system_.rows()[k - 1].leaf) local = LocalOf(leaf);
      visit(k, Noise(k), Draws((BasisOf(row, leaf) * local).array()));
    }
  }

 private:
  using Local = Eigen::Matrix<double, 16, kDraws, Eigen::RowMajor>;
  using BasisRow = Eigen::Matrix<double, 1, 16>;

  [[nodiscard]] Draws Noise(std::size_t row) const {
    const double weight = Weight(row);
    return weight > 0.0 ? Draws(Signs(row) / std::sqrt(weight)) : Draws(Draws::Zero());
  }

  [[nodiscard]] BasisRow BasisOf(const SampleRow& row, const SplineLeaf& leaf) const {
    const SplineSystem::RowSplines splines = system_.SplinesAt(row, leaf);
    BasisRow basis;
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t i = 0; i < 4; ++i) basis[static_cast<Eigen::Index>(4 * j + i)] = splines.z[j] * splines.theta[i];
    }
    return basis;
  }

  [[nodiscard]] Local LocalOf(const SplineLeaf& leaf) const {
    const std::span<const std::uint32_t> active = system_.basis().Active(leaf);
    Local local = Local::Zero();
    if (leaf.plain) {
      for (std::size_t k = 0; k < 16; ++k) local.row(static_cast<Eigen::Index>(k)) = coefficients_.row(active[k]);
    }
    for (const ExtractionEntry& e : system_.basis().Extraction(leaf)) {
      local.row(e.local) += e.weight * coefficients_.row(active[e.active]);
    }
    return local;
  }

  void AddLocal(const SplineLeaf& leaf, const Local& local, FrontalCholesky::FourColumns& sum) const {
    const std::span<const std::uint32_t> active = system_.basis().Active(leaf);
    if (leaf.plain) {
      for (std::size_t k = 0; k < 16; ++k) sum.row(active[k]) += local.row(static_cast<Eigen::Index>(k));
    }
    for (const ExtractionEntry& e : system_.basis().Extraction(leaf)) {
      sum.row(active[e.active]) += e.weight * local.row(e.local);
    }
  }

  /// Σ weight_k (e_k − B_k C) B_kᵀ.
  [[nodiscard]] FrontalCholesky::FourColumns WeightedTransposeOfRest() const {
    const std::vector<SampleRow>& rows = system_.rows();
    FrontalCholesky::FourColumns sum = FrontalCholesky::FourColumns::Zero(coefficients_.rows(), kDraws);
    for (std::size_t first = 0, last = 0; first < rows.size(); first = last) {
      const SplineLeaf& leaf = system_.basis().leaves()[rows[first].leaf];
      const Local local = LocalOf(leaf);
      Local to = Local::Zero();
      for (; last < rows.size() && rows[last].leaf == rows[first].leaf; ++last) {
        const BasisRow basis = BasisOf(rows[last], leaf);
        const Draws rest = Noise(last) - Draws((basis * local).array());
        to.noalias() += basis.transpose() * (Weight(last) * rest).matrix();
      }
      AddLocal(leaf, to, sum);
    }
    return sum;
  }

  const SplineSystem& system_;
  std::span<const double> factors_;
  FrontalCholesky::FourColumns coefficients_;
};

/// Weighted means of the rows in a cell; a cell without rows has weight 0.
struct CellMeans {
  float weight = 0.0F;                       ///< Their sum, 1/mm².
  float residual = 0.0F;                     ///< mm
  float leverage = 0.0F;                     ///< Diagonal entry of S, as the placing draws show it.
  bool averaged = false;                     ///< Whether the surface there averages over more than four returns.
  std::array<float, kCountingDraws> rest{};  ///< Drawn noise less smoothed, mm.
  std::array<float, kCountingDraws> smoothed{};
};

/// The residuals and the draws by cell.
class ResidualStudy {
 public:
  ResidualStudy(const FitInput& input, const AdaptiveFit& fit) : grid_(input.cells) {
    const std::vector<Deviation> deviations =
        Collect(*fit.system, SmoothedNoise(fit), fit.system->Residuals(fit.coefficients));
    FindAveraged();
    noise_variance_ = drawn_variance_ * RelativeVariance(fit.system->rows(), deviations);
  }

  [[nodiscard]] FitUncertainty Result() const {
    const double detail = std::max(DetailVariance({1, 0}), DetailVariance({0, 1}));
    return {trace_, std::sqrt(noise_variance_), rms_, std::sqrt(detail)};
  }

 private:
  /// The way from a cell to its neighbour.
  struct Step {
    std::size_t columns = 0;
    std::size_t rows = 0;
  };

  /// A row's squared residual and what it would be on average, in units of the drawn variance.
  struct Deviation {
    float square = 0.0F;
    float expected = 0.0F;
  };

  std::vector<Deviation> Collect(const SplineSystem& system, const SmoothedNoise& noise,
                                 const Eigen::VectorXd& residuals) {
    cells_.resize(grid_.columns() * grid_.rows());
    std::vector<Deviation> deviations;
    deviations.reserve(system.rows().size());
    noise.ForRows([&](std::size_t k, const Draws& drawn, const Draws& smoothed) {
      const double weight = noise.Weight(k);
      const double residual = residuals[static_cast<Eigen::Index>(k)];
      const Draws leverage = weight * drawn * smoothed;
      const auto counted = [](const Draws& draws) { return draws.tail<kCountingDraws>().mean(); };
      trace_ += leverage.mean();
      deviations.push_back({static_cast<float>(weight * residual * residual),
                            static_cast<float>(1.0 - 2.0 * counted(leverage) + weight * counted(smoothed.square()))});
      CellMeans& cell = cells_[system.rows()[k].cell];
      cell.weight += static_cast<float>(weight);
      cell.residual += static_cast<float>(weight * residual);
      cell.leverage += static_cast<float>(weight * leverage.head<kPlacingDraws>().mean());
      for (std::size_t d = 0; d < kCountingDraws; ++d) {
        const auto draw = kPlacingDraws + static_cast<Eigen::Index>(d);
        cell.rest[d] += static_cast<float>(weight * (drawn[draw] - smoothed[draw]));
        cell.smoothed[d] += static_cast<float>(weight * smoothed[draw]);
      }
    });
    for (CellMeans& cell : cells_) {
      if (!(cell.weight > 0.0F)) continue;
      for (float* sum : {&cell.residual, &cell.leverage}) *sum /= cell.weight;
      for (float& sum : cell.rest) sum /= cell.weight;
      for (float& sum : cell.smoothed) sum /= cell.weight;
    }
    rms_ = std::sqrt(residuals.squaredNorm() / static_cast<double>(residuals.size()));
    drawn_variance_ = system.noise_sigma() * system.noise_sigma();
    return deviations;
  }

  /// Noise variance over the drawn one: squares over their expectation, without those beyond the outlier limit and,
  /// unless little else is left, without those where the surface follows single returns (edges, folds).
  [[nodiscard]] double RelativeVariance(const std::vector<SampleRow>& rows,
                                        const std::vector<Deviation>& deviations) const {
    constexpr int kRounds = 6;
    constexpr double kEnough = 0.1;  // of the rows
    const auto averaged = static_cast<double>(
        std::count_if(rows.begin(), rows.end(), [&](const SampleRow& row) { return cells_[row.cell].averaged; }));
    const bool all = averaged < kEnough * static_cast<double>(rows.size());
    double variance = 1.0;
    for (int round = 0; round < kRounds; ++round) {
      const double limit = kOutlierLimit * kOutlierLimit * variance;
      double squares = 0.0;
      double freedom = 0.0;
      for (std::size_t k = 0; k < rows.size(); ++k) {
        if (!all && !cells_[rows[k].cell].averaged) continue;
        if (static_cast<double>(deviations[k].square) > limit) continue;
        squares += static_cast<double>(deviations[k].square);
        freedom += static_cast<double>(deviations[k].expected);
      }
      if (!(freedom > 0.0)) break;
      variance = squares / freedom;
    }
    return variance;
  }

  /// Marks the cells where the leverage, a mean over the 5 × 5 cells around, is low.
  void FindAveraged() {
    constexpr std::size_t kHalf = 2;
    constexpr double kMostLeverage = 0.25;
    for (std::size_t row = 0; row < grid_.rows(); ++row) {
      for (std::size_t column = 0; column < grid_.columns(); ++column) {
        double sum = 0.0;
        double count = 0.0;
        const std::size_t last = std::min(grid_.rows() - 1, row + kHalf);
        for (std::size_t r = row - std::min(row, kHalf); r <= last; ++r) {
          for (std::size_t k = 0; k <= 2 * kHalf; ++k) {
            const std::size_t c = (column + k + grid_.columns() - kHalf) % grid_.columns();
            const CellMeans& other = cells_[grid_.Index(c, r)];
            if (!(other.weight > 0.0F)) continue;
            sum += static_cast<double>(other.leverage);
            count += 1.0;
          }
        }
        CellMeans& cell = cells_[grid_.Index(column, row)];
        cell.averaged = cell.weight > 0.0F && sum < kMostLeverage * count;
      }
    }
  }

  /// The residual of a cell, at most the outlier limit.
  [[nodiscard]] double Residual(const CellMeans& cell) const {
    const double limit = kOutlierLimit * std::sqrt(noise_variance_);
    return std::clamp(static_cast<double>(cell.residual), -limit, limit);
  }

  /// Variance of detail as neighbours one step apart show it, mm²; 0 if they show none.
  [[nodiscard]] double DetailVariance(const Step& step) const {
    constexpr double kFewestPairs = 100.0;
    constexpr double kLeastCorrelation = 0.25;  // neighbours that have less in common tell nothing
    double pairs = 0.0, products = 0.0, squared_products = 0.0, of_noise = 0.0, bias = 0.0, bias_of_neighbours = 0.0;
    for (std::size_t row = 0; row + step.rows < grid_.rows(); ++row) {
      for (std::size_t column = 0; column < grid_.columns(); ++column) {
        const CellMeans& a = cells_[grid_.Index(column, row)];
        const CellMeans& b = cells_[grid_.Index((column + step.columns) % grid_.columns(), row + step.rows)];
        if (!a.averaged || !b.averaged) continue;
        const double product = Residual(a) * Residual(b);
        pairs += 1.0;
        products += product;
        squared_products += product * product;
        for (std::size_t d = 0; d < kCountingDraws; ++d) {
          const auto rest_a = static_cast<double>(a.rest[d]);
          const auto rest_b = static_cast<double>(b.rest[d]);
          const auto smoothed_a = static_cast<double>(a.smoothed[d]);
          const auto smoothed_b = static_cast<double>(b.smoothed[d]);
          // (e − s)(e' − s') less e e', which is 0 in the mean and would only add its scatter.
          of_noise -= rest_a * smoothed_b + smoothed_a * rest_b + smoothed_a * smoothed_b;
          bias += 0.5 * (rest_a * smoothed_a + rest_b * smoothed_b);
          bias_of_neighbours += 0.5 * (rest_a * smoothed_b + smoothed_a * rest_b);
        }
      }
    }
    if (pairs < kFewestPairs || !(bias_of_neighbours > kLeastCorrelation * bias)) return 0.0;
    const double correlation = std::min(1.0, bias_of_neighbours / bias);
    const double scale = noise_variance_ / (drawn_variance_ * static_cast<double>(kCountingDraws));
    const double variance = (products - scale * of_noise) / (pairs * correlation);
    const double error = std::sqrt(squared_products) / (pairs * correlation);
    return variance > error ? variance - error * error / variance : 0.0;
  }

  const CellGrid& grid_;
  std::vector<CellMeans> cells_;
  double trace_ = 0.0;           ///< Of S.
  double rms_ = 0.0;             ///< Of the residuals, mm.
  double drawn_variance_ = 0.0;  ///< Of the draws, mm².
  double noise_variance_ = 0.0;  ///< Of a return, mm².
};

}  // namespace

FitUncertainty AssessUncertainty(const FitInput& input, const AdaptiveFit& fit) {
  return ResidualStudy(input, fit).Result();
}

Eigen::SparseMatrix<double> PosteriorPrecision(const AdaptiveFit& fit, double noise_sigma) {
  constexpr double kSteps = kSmoothings;
  const double ratio = 2.0 * std::tgamma(kSteps + 0.5) / (std::sqrt(kPi * kSteps) * std::tgamma(kSteps));
  const double noise = std::max(noise_sigma, kSmallestNoise) / fit.system->noise_sigma();
  Eigen::SparseMatrix<double> precision =
      fit.system->NormalMatrix(Scaled(fit.weights, {1.0 / kSteps, 1.0 / kSteps}), fit.factors());
  precision *= 1.0 / (ratio * noise * noise);
  return precision;
}

}  // namespace annulus
