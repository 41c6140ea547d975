#include "fitting/spline_system.h"

#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr int kProbes = 6;
constexpr std::uint64_t kProbeSeed = 20'000'101;

/// Share of the mean diagonal added to every diagonal entry, so that coefficients over holes stay determined.
constexpr double kRidge = 1e-10;

}  // namespace

SplineSystem::SplineSystem(PeriodicCubicBasis theta, ClampedCubicBasis z, std::vector<SampleRow> rows,
                           double noise_sigma)
    : theta_(theta), z_(std::move(z)), rows_(std::move(rows)), noise_sigma_(noise_sigma) {
  ENSURE(noise_sigma > 0.0, "the noise scale is positive");
}

Eigen::VectorXd SplineSystem::Predict(const Eigen::VectorXd& coefficients) const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const SampleRow& row = rows_[k];
    double value = 0.0;
    for (std::size_t j = 0; j < 4; ++j) {
      const double* c = coefficients.data() + row.z.index[j] * theta_.count();
      double sum = 0.0;
      for (std::size_t i = 0; i < 4; ++i) sum += row.theta.value[i] * c[row.theta.index[i]];
      value += row.z.value[j] * sum;
    }
    values[static_cast<Eigen::Index>(k)] = value;
  }
  return values;
}

Eigen::VectorXd SplineSystem::Transpose(const Eigen::VectorXd& values) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(size()));
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const SampleRow& row = rows_[k];
    for (std::size_t j = 0; j < 4; ++j) {
      double* c = sum.data() + row.z.index[j] * theta_.count();
      const double left = values[static_cast<Eigen::Index>(k)] * row.z.value[j];
      for (std::size_t i = 0; i < 4; ++i) c[row.theta.index[i]] += left * row.theta.value[i];
    }
  }
  return sum;
}

StencilMatrix SplineSystem::DataMatrix(std::span<const double> factors) const {
  StencilMatrix matrix(theta_.count(), z_.count());
  const double scale = 1.0 / (noise_sigma_ * noise_sigma_);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const SampleRow& row = rows_[k];
    const double weight = scale * row.weight * (factors.empty() ? 1.0 : factors[k]);
    matrix.AddOuter(row.theta, row.theta.value, row.z, row.z.value, weight);
  }
  return matrix;
}

Eigen::VectorXd SplineSystem::DataVector(std::span<const double> factors) const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(rows_.size()));
  const double scale = 1.0 / (noise_sigma_ * noise_sigma_);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    values[static_cast<Eigen::Index>(k)] =
        scale * rows_[k].weight * (factors.empty() ? 1.0 : factors[k]) * rows_[k].radius;
  }
  return Transpose(values);
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

Result<SmoothingChoice> ChooseSmoothing(const SplineSystem& system, const StencilMatrix& fixed,
                                        const StencilMatrix& penalty) {
  const StencilMatrix data = system.DataMatrix({});
  const Eigen::SparseMatrix<double> data_upper = data.UpperTriangle();
  const Eigen::VectorXd right = system.DataVector({});
  const double ridge = kRidge * data.MeanDiagonal();
  const auto n = static_cast<double>(system.rows().size());
  SparseFactor factor;
  bool analysed = false;

  const auto evaluate = [&](double log_lambda) {
    SmoothingChoice choice;
    choice.lambda = std::exp(log_lambda);
    choice.gcv = std::numeric_limits<double>::infinity();
    StencilMatrix total = data;
    total.Add(fixed, 1.0);
    total.Add(penalty, choice.lambda);
    total.AddDiagonal(ridge);
    const Eigen::SparseMatrix<double> upper = total.UpperTriangle();
    if (!analysed) factor.analyzePattern(upper);
    analysed = true;
    factor.factorize(upper);
    if (factor.info() != Eigen::Success) return choice;
    choice.coefficients = factor.solve(right);
    choice.effective_parameters = EffectiveParameters(factor, data_upper);
    const Eigen::VectorXd prediction = system.Predict(choice.coefficients);
    double squares = 0.0;
    for (std::size_t k = 0; k < system.rows().size(); ++k) {
      const SampleRow& row = system.rows()[k];
      const double residual = row.radius - prediction[static_cast<Eigen::Index>(k)];
      squares += row.weight * residual * residual;
    }
    const double freedom = n - choice.effective_parameters;
    if (freedom > 0.0 && std::isfinite(squares)) choice.gcv = n * squares / (freedom * freedom);
    return choice;
  };

  // A coarse walk downhill in decades, then golden section inside the bracket.
  std::map<double, SmoothingChoice> tried;
  const auto at = [&](double log_lambda) -> const SmoothingChoice& {
    auto found = tried.find(log_lambda);
    if (found == tried.end()) found = tried.emplace(log_lambda, evaluate(log_lambda)).first;
    return found->second;
  };
  const double decade = std::log(10.0);
  const double centre = std::log(data.MeanDiagonal() / penalty.MeanDiagonal());
  constexpr int kDecades = 8;
  int best = 0;
  while (best > -kDecades && at(centre + (best - 1) * decade).gcv < at(centre + best * decade).gcv) --best;
  while (best < kDecades && at(centre + (best + 1) * decade).gcv < at(centre + best * decade).gcv) ++best;
  double low = centre + (best - 1) * decade;
  double high = centre + (best + 1) * decade;
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  double left = high - golden * (high - low);
  double right_point = low + golden * (high - low);
  for (int step = 0; step < 4; ++step) {
    if (at(left).gcv < at(right_point).gcv) {
      high = right_point;
      right_point = left;
      left = high - golden * (high - low);
    } else {
      low = left;
      left = right_point;
      right_point = low + golden * (high - low);
    }
  }
  const SmoothingChoice* chosen = nullptr;
  for (const auto& [log_lambda, choice] : tried) {
    if (std::isfinite(choice.gcv) && (chosen == nullptr || choice.gcv < chosen->gcv)) chosen = &choice;
  }
  if (chosen == nullptr) {
    return Fail("fit a surface", "the samples do not determine it at any smoothing",
                "scan again: too few returns, or all in one place");
  }
  return *chosen;
}

}  // namespace annulus
