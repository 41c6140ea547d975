#include "modeling/elastic/elastic_solver.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "modeling/elastic/elastic_system.h"

namespace annulus {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr const char* kAttempted = "find the shape of an elastic body";
constexpr int kMostHalvings = 30;
constexpr double kTightness = 30.0;    ///< Of a thread of given length, over the body's own stiffness.
constexpr double kLengthError = 1e-3;  ///< mm, of a thread of given length.
constexpr int kMostTightenings = 12;
constexpr double kNearEnd = 1e-4;  ///< Below this residual a factor is used again …
constexpr double kQuick =
    0.1;  ///< … if the step before left no more than this of the residual, and as long as it does.
constexpr double kSlope = 1e-4;  ///< Armijo's share of the expected descent.

/// Newton's method with line search on one potential energy.
class Descent {
 public:
  Descent(ElasticSystem& system, const ElasticOptions& options, ElasticState start)
      : system_(system), options_(options), state_(std::move(start)) {
    potential_.push_back(state_.potential);
  }

  /// Empty if it may go on.
  Result<std::string> Run(const TaskContext& task) {
    for (;;) {
      residual_ = system_.Residual(state_);
      task.Report("equilibrium",
                  std::min(1.0, std::log10(std::max(residual_, options_.tolerance)) / std::log10(options_.tolerance)),
                  1.0);
      if (residual_ <= options_.tolerance) return std::string("converged");
      if (steps_ >= options_.most_steps) return std::string("most steps taken");
      if (task.stop.stop_requested()) return Fail(kAttempted, "it was stopped", "start it again");
      if (!Descend()) return std::string("no lower energy found");
    }
  }

  [[nodiscard]] const ElasticState& state() const { return state_; }
  [[nodiscard]] const std::vector<double>& potential() const { return potential_; }
  [[nodiscard]] int steps() const { return steps_; }
  [[nodiscard]] double residual() const { return residual_; }
  /// Goes on from the same shape with other threads.
  void Restart() {
    state_ = system_.At(state_.displacement, options_.method);
    potential_.assign(1, state_.potential);
    residual_before_ = 0.0;
  }

 private:
  bool Descend() {
    if (options_.method == ElasticMethod::kLinear) return Search(system_.Step(state_, ElasticTangent::kUnturned));
    // Near the end the second derivatives hardly change.
    if (residual_ < kNearEnd && residual_ < kQuick * residual_before_ && SearchAgain()) return true;
    return Search(system_.Step(state_, ElasticTangent::kFull)) ||
           Search(system_.Step(state_, ElasticTangent::kGaussNewton));
  }

  /// A step by the factor at hand, if it is about as good as a new one's.
  bool SearchAgain() {
    const VectorXd step = system_.StepAgain(state_);
    auto next = Try(step, 1.0, step.dot(state_.gradient));
    if (!next || system_.Residual(*next) > std::max(options_.tolerance, kQuick * residual_)) return false;
    Take(std::move(*next));
    return true;
  }

  bool Search(const std::optional<VectorXd>& step) {
    if (!step) return false;
    const double slope = step->dot(state_.gradient);  // the step is 0 on held components
    double share = 1.0;
    for (int n = 0; n < kMostHalvings; ++n, share *= 0.5) {
      auto next = Try(*step, share, slope);
      if (!next) continue;
      Take(std::move(*next));
      return true;
    }
    return false;
  }

  /// The shape after a share of a step, if its energy is lower.
  std::optional<ElasticState> Try(const VectorXd& step, double share, double slope) {
    if (!(slope < 0.0)) return std::nullopt;
    ElasticState next = system_.At(state_.displacement + share * step, options_.method);
    // Near the bottom the descent is below the rounding of the energy itself: forces decide there.
    const double rounding = 1e-13 * (std::abs(state_.potential) + state_.strain_energy);
    const bool lower = next.potential <= state_.potential + kSlope * share * slope;
    const bool level = share == 1.0 && next.potential <= state_.potential + rounding && -slope <= 1e3 * rounding &&
                       system_.Residual(next) < 0.5 * system_.Residual(state_);
    if (!lower && !level) return std::nullopt;
    return next;
  }

  void Take(ElasticState next) {
    potential_.push_back(next.potential);
    state_ = std::move(next);
    residual_before_ = residual_;
    ++steps_;
  }

  ElasticSystem& system_;
  ElasticOptions options_;
  ElasticState state_;
  std::vector<double> potential_;
  int steps_ = 0;
  double residual_ = 0.0;
  double residual_before_ = 0.0;  ///< Of the step before; 0: there was none.
};

/// The first shape in which held components are where they belong: the others follow as in linear elasticity.
Result<VectorXd> Admissible(ElasticSystem& system) {
  VectorXd start = system.given();
  if (start.isZero(0.0)) return start;
  const ElasticState moved = system.At(start, ElasticMethod::kLinear);
  const auto step = system.Step(moved, ElasticTangent::kUnturned);
  if (!step) {
    return Fail(kAttempted, "nothing holds it", "hold the inner surface or the rim of the region");
  }
  return VectorXd(start + *step);
}

/// Threads of given length become stiff ones.
void StiffenTargets(ElasticSystem& system) {
  for (BandFibre& fibre : system.fibres()) {
    if (!fibre.target) continue;
    fibre.rest_length = *fibre.target;
    const FibreState state = Stretch(fibre, system.PositionsOf(fibre, system.given()));
    fibre.stiffness = kTightness * *fibre.target * system.StiffnessAlong(system.WeightOf(fibre, state));
  }
}

/// Shortens stiff threads by what they are too long (method of multipliers). False: they are right.
bool Tighten(ElasticSystem& system, const ElasticState& state) {
  bool changed = false;
  for (std::size_t f = 0; f < system.fibres().size(); ++f) {
    BandFibre& fibre = system.fibres()[f];
    if (!fibre.target || !(state.fibres[f].tension > 0.0)) continue;
    const double over = state.fibres[f].length - *fibre.target;
    if (std::abs(over) <= kLengthError) continue;
    fibre.rest_length -= over;
    changed = true;
  }
  return changed;
}

/// Whether something moved further than any held body would.
bool Lost(const ElasticProblem& problem, const ElasticState& state) {
  double size = 0.0;
  for (const Vector3d& node : problem.grid.nodes) size = std::max(size, (node - problem.grid.nodes.front()).norm());
  return !(state.displacement.cwiseAbs().maxCoeff() <= 100.0 * size);
}

ElasticSolution SolutionOf(const Descent& descent, std::string termination) {
  const ElasticState& state = descent.state();
  ElasticSolution solution;
  for (Index n = 0; n < state.displacement.size() / 3; ++n) {
    solution.displacement.emplace_back(state.displacement.segment<3>(3 * n));
    solution.inner.emplace_back(state.inner.segment<3>(3 * n));
  }
  for (const TurnedElement& element : state.elements) solution.rotation.push_back(element.rotation);
  solution.strain_energy = state.strain_energy;
  solution.potential = descent.potential();
  solution.steps = descent.steps();
  solution.residual = descent.residual();
  solution.termination = std::move(termination);
  solution.fibres = state.fibres;
  solution.pull_force.assign(state.pull_force.begin(), state.pull_force.end());
  solution.pull_movement.assign(state.pull_movement.begin(), state.pull_movement.end());
  return solution;
}

}  // namespace

Result<ElasticSolution> SolveElastic(const ElasticProblem& problem, const ElasticOptions& options,
                                     const TaskContext& task) {
  auto system = ElasticSystem::Make(problem);
  if (!system) return Fail(system);
  StiffenTargets(*system);
  const auto start = Admissible(*system);
  if (!start) return Fail(start);
  Descent descent(*system, options, system->At(*start, options.method));
  auto termination = descent.Run(task);
  for (int n = 0; termination && n < kMostTightenings && Tighten(*system, descent.state()); ++n) {
    descent.Restart();
    termination = descent.Run(task);
  }
  if (!termination) return Fail(termination);
  if ((descent.steps() == 0 && *termination == "no lower energy found") || Lost(problem, descent.state())) {
    return Fail(kAttempted, "nothing holds it, or what acts on it is too much",
                "hold the inner surface or the rim of the region, or give smaller loads");
  }
  return SolutionOf(descent, *termination);
}

}  // namespace annulus
