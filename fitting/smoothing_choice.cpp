#include "fitting/smoothing_choice.h"

#include <cmath>
#include <limits>
#include <map>

namespace annulus {
namespace {

/// The GCV score as a function of log λ. Keeps what it has tried.
class GcvScore {
 public:
  GcvScore(const SplineSystem& system, const CellGrid& cells, double mean_radius)
      : system_(system),
        cells_(cells),
        mean_radius_(mean_radius),
        tree_(std::make_shared<const EliminationTree>(system.basis())),
        right_(system.WeightedTranspose(system.Radii(), {})) {}

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
    const auto factor = system_.Factor(tree_, ThinPlateWeights(cells_, mean_radius_, lambda), {});
    if (!factor) return choice;
    choice.coefficients = factor->Solve(right_);
    choice.effective_parameters = EffectiveParameters(system_, *factor, {});
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
  const CellGrid& cells_;
  double mean_radius_;
  std::shared_ptr<const EliminationTree> tree_;
  Eigen::VectorXd right_;
  std::map<double, SmoothingChoice> tried_;
};

}  // namespace

Result<SmoothingChoice> ChooseSmoothing(const SplineSystem& system, const CellGrid& cells, double mean_radius) {
  // A walk downhill in decades, then golden section inside the bracket.
  constexpr int kDecades = 8;
  constexpr int kSections = 4;
  GcvScore score(system, cells, mean_radius);
  const double decade = std::log(10.0);
  const double centre = std::log(100.0);  // mm²: about what skin needs
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
