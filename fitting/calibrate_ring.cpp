#include "fitting/calibrate_ring.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>

#include "base/ensure.h"
#include "fitting/placement_pose.h"
#include "fitting/ring_costs.h"
#include "fitting/ring_covariance.h"
#include "fitting/ring_exchange.h"
#include "fitting/ring_findings.h"
#include "fitting/ring_observability.h"
#include "fitting/ring_uncertainty.h"
#include "fitting/stopwatch.h"

namespace annulus {
namespace {

using Kind = CalibrationTarget::Kind;

/// Hands each iteration on as progress, and a stop request back.
class Watcher final : public ceres::IterationCallback {
 public:
  explicit Watcher(const TaskContext& context) : context_(context) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    context_.Report("solve", std::min(summary.iteration, kExpected), kExpected);
    return context_.stop.stop_requested() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  static constexpr int kExpected = 12;
  const TaskContext& context_;
};

/// One calibration from placements to solution.
class Calibrator {
 public:
  Calibrator(const RingCalibration& start, const std::vector<CalibrationTarget>& targets,
             const std::vector<TargetScan>& scans, const CalibrateOptions& options, const TaskContext& context)
      : start_(start),
        targets_(targets),
        scans_(scans),
        options_(options),
        context_(context),
        setup_{start_, targets_, scans_, placements_},
        priors_(PriorsOf(options.tolerances, targets, scans)) {}

  Result<RingSolution> Run();

 private:
  Status Prepare();
  void InitialState();
  void Hold();
  void AddBins(ceres::Problem& problem);
  void AddPriors(ceres::Problem& problem, ceres::ParameterBlockOrdering& ordering);
  Status Solve();
  void DropNeedlessTerms();
  void Residuals();
  void MissesOfRadii(const RingCovariance& covariance);
  void Describe();

  const RingCalibration& start_;
  const std::vector<CalibrationTarget>& targets_;
  const std::vector<TargetScan>& scans_;
  const CalibrateOptions& options_;
  const TaskContext& context_;
  std::vector<PlacementBins> placements_;
  CalibrationSetup setup_;
  PriorSigmas priors_;
  CalibrationState state_, first_;
  HeldUnknowns held_;
  std::array<bool, ring_unknown::kCount> ring_held_{};
  RingSolution solution_;
};

double MeanTemperature(const std::vector<TargetScan>& scans, std::size_t target, double otherwise) {
  double sum = 0.0;
  double count = 0.0;
  for (const TargetScan& scan : scans) {
    if (scan.target != target) continue;
    sum += scan.temperature_c.value_or(otherwise);
    count += 1.0;
  }
  return count > 0.0 ? sum / count : otherwise;
}

Status Calibrator::Prepare() {
  double squares = 0.0;
  double weight = 0.0;
  for (std::size_t p = 0; p < scans_.size(); ++p) {
    context_.Report("placements", static_cast<double>(p), static_cast<double>(scans_.size()));
    if (context_.stop.stop_requested()) return Fail("calibrate the ring", "stopped on request", "start again");
    ENSURE(scans_[p].target < targets_.size(), "a scan's target is one of the targets");
    auto prepared = PreparePlacement(start_, targets_[scans_[p].target], scans_[p]);
    if (!prepared) return Fail(prepared);
    squares += prepared->noise_mm * prepared->noise_mm * static_cast<double>(prepared->readings);
    weight += static_cast<double>(prepared->readings);
    placements_.push_back(std::move(*prepared));
  }
  if (weight > 0.0) setup_.noise_mm = std::max(1e-3, std::sqrt(squares / weight));
  return {};
}

void Calibrator::InitialState() {
  state_.ring.sensors.assign(start_.sensors.size(), SensorUnknowns::Zero());
  state_.ring.knots_z_mm = PathKnots(placements_, options_.knot_spacing_mm);
  state_.ring.path.assign(state_.ring.knots_z_mm.size(), Eigen::Vector2d::Zero());
  setup_.knot_spacing_mm = options_.knot_spacing_mm;
  setup_.middle_z_mm = 0.5 * (state_.ring.knots_z_mm.front() + state_.ring.knots_z_mm.back());
  for (const PlacementBins& placement : placements_) state_.poses.push_back(UnknownsOf(placement.pose));
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    FormUnknowns form = FormUnknowns::Zero();
    form[0] = targets_[t].kind == Kind::kPlane
                  ? 9.0
                  : targets_[t].RadiusAt(MeanTemperature(scans_, t, targets_[t].certified_c));
    state_.forms.push_back(form);
  }
  first_ = state_;
}

void Calibrator::Hold() {
  held_.sensors.assign(start_.sensors.size(), false);
  for (std::size_t i = 0; i < std::min(options_.free_sensors.size(), held_.sensors.size()); ++i) {
    held_.sensors[i] = !options_.free_sensors[i];
  }
  held_.ring = std::find(held_.sensors.begin(), held_.sensors.end(), true) != held_.sensors.end();
  for (std::size_t p = 0; p < scans_.size(); ++p) {
    const Kind kind = targets_[scans_[p].target].kind;
    std::array<bool, kPoseUnknowns> held{};
    const std::array<bool, 6> freedom = PoseFreedom(kind);
    for (std::size_t k = 0; k < held.size(); ++k) held[k] = !freedom[k];
    if (kind == Kind::kStep) held[5] = false;
    if ((kind == Kind::kCylinder || kind == Kind::kStep) && scans_[p].turn) held[4] = false;
    held_.poses.push_back(held);
  }
  // What the readings do not tell well enough keeps its value: nothing is invented.
  ring_held_.fill(held_.ring);
  if (held_.ring) return;
  CalibrationSetup unsolved = setup_;
  unsolved.huber_sds = 1e9;  // residuals of a ring that is not calibrated yet are all large
  const RingCovariance covariance(unsolved, state_, priors_, held_);
  for (int k = 0; k < ring_unknown::kCount; ++k) {
    if (k == ring_unknown::kOffset || k == ring_unknown::kQuadratic) continue;  // the first rests on the radii
    ring_held_[static_cast<std::size_t>(k)] = !ObserveRingUnknown(covariance, k).observable;
  }
  // Their values are never computed: that they hardly show is known beforehand.
  ring_held_[ring_unknown::kPitch] = ring_held_[ring_unknown::kRoll] = true;
  held_.considered = ring_held_;
  solution_.height_scale = !ring_held_[ring_unknown::kHeightScale];
  if (options_.quadratic == QuadraticTerm::kNever) ring_held_[ring_unknown::kQuadratic] = true;
}

template <std::size_t N>
void HoldBlock(ceres::Problem& problem, double* block, const std::array<bool, N>& held) {
  std::vector<int> constant;
  for (std::size_t k = 0; k < N; ++k) {
    if (held[k]) constant.push_back(static_cast<int>(k));
  }
  if (constant.size() == N) {
    problem.SetParameterBlockConstant(block);
  } else if (!constant.empty()) {
    problem.SetManifold(block, new ceres::SubsetManifold(static_cast<int>(N), constant));
  }
}

void Calibrator::AddBins(ceres::Problem& problem) {
  RingUnknowns& ring = state_.ring;
  const auto loss = [&] { return new ceres::HuberLoss(setup_.huber_sds); };
  for (std::size_t p = 0; p < placements_.size(); ++p) {
    for (const TargetBin& bin : placements_[p].bins) {
      const std::size_t knot = KnotAt(ring.knots_z_mm, start_.carriage.position_scale * bin.z_mm).first;
      problem.AddResidualBlock(MakeBinCost(setup_, ring.knots_z_mm, p, bin).release(), loss(),
                               ring.sensors[bin.sensor].data(), ring.ring.data(), state_.poses[p].data(),
                               state_.forms[scans_[p].target].data(), ring.path[knot].data(),
                               ring.path[knot + 1].data());
    }
  }
}

void Calibrator::AddPriors(ceres::Problem& problem, ceres::ParameterBlockOrdering& ordering) {
  RingUnknowns& ring = state_.ring;
  // Within a group Ceres goes by addresses, which differ from run to run: a group for each block but the sensors',
  // which lie in one array.
  int group = 1;
  const auto prior = [&](double* block, const Eigen::VectorXd& mean, const Eigen::VectorXd& sigma) {
    problem.AddResidualBlock(MakePriorCost(mean, sigma).release(), nullptr, block);
    ordering.AddElementToGroup(block, group++);
  };
  for (std::size_t i = 0; i < ring.sensors.size(); ++i) {
    problem.AddResidualBlock(MakePriorCost(SensorUnknowns::Zero(), priors_.sensor).release(), nullptr,
                             ring.sensors[i].data());
    ordering.AddElementToGroup(ring.sensors[i].data(), 0);
    if (held_.sensors[i]) problem.SetParameterBlockConstant(ring.sensors[i].data());
  }
  prior(ring.ring.data(), RingWideUnknowns::Zero(), priors_.ring);
  HoldBlock(problem, ring.ring.data(), ring_held_);
  for (Eigen::Vector2d& knot : ring.path) {
    prior(knot.data(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Constant(priors_.path_mm));
    if (held_.ring) problem.SetParameterBlockConstant(knot.data());
  }
  for (std::size_t p = 0; p < state_.poses.size(); ++p) {
    prior(state_.poses[p].data(), first_.poses[p], priors_.poses[p]);
    HoldBlock(problem, state_.poses[p].data(), held_.poses[p]);
  }
  for (std::size_t t = 0; t < state_.forms.size(); ++t) {
    prior(state_.forms[t].data(), first_.forms[t], priors_.forms[t]);
  }
}

Status Calibrator::Solve() {
  ceres::Problem problem;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  AddBins(problem);
  AddPriors(problem, *ordering);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  options.num_threads = options_.threads;
  options.max_num_iterations = 40;
  options.initial_trust_region_radius = 1e8;  // nearly linear, and priors make it well posed
  options.function_tolerance = 1e-7;
  options.logging_type = ceres::SILENT;
  Watcher watcher(context_);
  options.callbacks.push_back(&watcher);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  solution_.iterations += static_cast<int>(summary.iterations.size());
  if (solution_.cost_start == 0.0) solution_.cost_start = summary.initial_cost;
  solution_.cost_end = summary.final_cost;
  solution_.termination = ceres::TerminationTypeToString(summary.termination_type);
  if (context_.stop.stop_requested()) return Fail("calibrate the ring", "stopped on request", "start again");
  if (!summary.IsSolutionUsable()) {
    return Fail("calibrate the ring", "the solver gave up: " + summary.message,
                "look at the placements' residuals; scan those that differ again");
  }
  return {};
}

void Calibrator::DropNeedlessTerms() {
  solution_.quadratic = false;
  if (ring_held_[ring_unknown::kQuadratic]) return;
  constexpr double kNeeded = 2.0;  // sds; what is left out wrongly is then within the uncertainty
  const RingCovariance covariance(setup_, state_, priors_, held_);
  RingFunctional f = covariance.Zero();
  f.by_shared[ring_unknown::kQuadratic] = 1.0;
  solution_.quadratic =
      std::abs(state_.ring.ring[ring_unknown::kQuadratic]) > kNeeded * std::sqrt(covariance.Variance(f));
  if (solution_.quadratic) return;
  ring_held_[ring_unknown::kQuadratic] = true;
  state_.ring.ring[ring_unknown::kQuadratic] = 0.0;
}

void Calibrator::Residuals() {
  BinRow row;
  BinRow before;
  solution_.residuals.clear();
  for (std::size_t p = 0; p < placements_.size(); ++p) {
    PlacementResult placement;
    placement.name = scans_[p].name;
    placement.target = scans_[p].target;
    placement.pose = PoseOf(state_.poses[p]);
    placement.noise_mm = placements_[p].noise_mm;
    placement.z_low_mm = placements_[p].z_low;
    placement.z_high_mm = placements_[p].z_high;
    placement.readings = placements_[p].readings;
    placement.rejected = placements_[p].rejected;
    placement.elsewhere = placements_[p].elsewhere;
    placement.motion = placements_[p].motion;
    const Kind kind = targets_[placement.target].kind;
    placement.off_centre_mm = kind == Kind::kPlane ? 0.0 : std::hypot(placement.pose.x, placement.pose.y);
    placement.tilt_rad = kind == Kind::kPlane ? std::atan(std::abs(placement.pose.slope_x))
                                              : std::atan(std::hypot(placement.pose.slope_x, placement.pose.slope_y));
    double squares_before = 0.0;
    double squares_after = 0.0;
    double count = 0.0;
    for (const TargetBin& bin : placements_[p].bins) {
      if (!EvaluateBin(setup_, state_, p, bin, row) || !EvaluateBin(setup_, first_, p, bin, before)) continue;
      if (bin.edge >= 0) continue;
      BinResidual residual;
      residual.placement = p;
      residual.sensor = bin.sensor;
      residual.z_mm = bin.z_mm;
      residual.sigma_mm = std::hypot(setup_.noise_mm / std::sqrt(bin.weight), 0.02);
      residual.after_mm = row.residual * residual.sigma_mm;
      residual.before_mm = before.residual * residual.sigma_mm;
      residual.distance_mm = row.distance;
      residual.cos_incidence = row.cos_incidence;
      residual.phi = row.phi;
      squares_before += residual.before_mm * residual.before_mm;
      squares_after += residual.after_mm * residual.after_mm;
      count += 1.0;
      solution_.residuals.push_back(residual);
    }
    if (count > 0.0) {
      placement.rms_before_mm = std::sqrt(squares_before / count);
      placement.rms_after_mm = std::sqrt(squares_after / count);
    }
    solution_.placements.push_back(std::move(placement));
  }
}

/// What the rest says of each radius: the certificate's share taken out of the estimate again.
void Calibrator::MissesOfRadii(const RingCovariance& covariance) {
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    TargetResult& target = solution_.targets[t];
    target.certified_radius_mm = first_.forms[t][0];
    target.certified_sigma_mm = priors_.forms[t][0];
    RingFunctional radius = covariance.Zero();
    radius.by_shared[covariance.FormAt(t)] = 1.0;
    const double considered = covariance.ConsideredVariance(radius);
    const double prior = std::max(target.certified_sigma_mm, 1e-6);
    // The certificate's leverage on its own radius; what is left to the rest.
    const double rest = 1.0 - (covariance.Variance(radius) - considered) / (prior * prior);
    target.radius_miss_mm = target.radius_miss_sigma_mm = std::numeric_limits<double>::quiet_NaN();
    if (targets_[t].kind == Kind::kPlane || rest < 1e-4) continue;
    target.radius_miss_mm = (state_.forms[t][0] - first_.forms[t][0]) / rest;
    target.radius_miss_sigma_mm = std::sqrt(prior * prior / rest + considered / (rest * rest));
  }
}

void Calibrator::Describe() {
  const RingCovariance covariance(setup_, state_, priors_, held_);
  solution_.noise_mm = setup_.noise_mm;
  const double freedom = static_cast<double>(covariance.bins()) -
                         static_cast<double>(sensor_unknown::kCount * start_.sensors.size()) -
                         static_cast<double>(covariance.shared());
  solution_.chi_square = covariance.chi_square() / std::max(1.0, freedom);
  Residuals();
  FillUncertainty(setup_, state_, priors_, covariance, solution_);
  MissesOfRadii(covariance);
  PriorSigmas uncertified = priors_;
  for (std::size_t t = 0; t < targets_.size(); ++t) uncertified.forms[t][0] = options_.tolerances.common_offset_mm;
  solution_.observability = ObserveRing(setup_, covariance, RingCovariance(setup_, state_, uncertified, held_));
  solution_.exchanges = FindExchanges(setup_, state_, priors_, options_.board_size);
  solution_.corrections = state_.ring;
  if (held_.ring) {
    // A replaced board is told against the ring around it: nothing of that changes.
    solution_.corrections.knots_z_mm.clear();
    solution_.corrections.path.clear();
  } else {
    FixGauge(start_, solution_.corrections);
  }
  const CalibrationUncertainty uncertainty = *solution_.calibration.uncertainty;
  solution_.calibration = Corrected(start_, solution_.corrections);
  solution_.calibration.uncertainty = uncertainty;
  solution_.calibration.certificate.clear();
  FindFaults(setup_, solution_);
}

Result<RingSolution> Calibrator::Run() {
  Stopwatch stopwatch;
  RETURN_IF_ERROR(Prepare());
  InitialState();
  Hold();
  RETURN_IF_ERROR(Solve());
  const bool had_quadratic = !ring_held_[ring_unknown::kQuadratic];
  DropNeedlessTerms();
  if (had_quadratic && !solution_.quadratic) RETURN_IF_ERROR(Solve());
  Describe();
  solution_.time_s = stopwatch.Lap();
  return std::move(solution_);
}

}  // namespace

bool RingSolution::failed() const {
  return std::any_of(findings.begin(), findings.end(), [](const CalibrationFinding& finding) {
    return finding.grade == CalibrationFinding::Grade::kFailure;
  });
}

std::string RingSolution::BriefReport() const {
  char text[300];
  std::snprintf(text, sizeof text,
                "%zu placements, noise %.3f mm, chi-square %.3f, girth of 900 mm: sd %.2f mm, %d iterations, %.1f s",
                placements.size(), noise_mm, chi_square, budget.empty() ? 0.0 : budget.back().girth_mm, iterations,
                time_s);
  return text;
}

Result<RingSolution> CalibrateRing(const RingCalibration& start, const std::vector<CalibrationTarget>& targets,
                                   const std::vector<TargetScan>& scans, const CalibrateOptions& options,
                                   const TaskContext& context) {
  if (scans.empty()) {
    return Fail("calibrate the ring", "there is no scan of a target", "scan a target in at least six places");
  }
  return Calibrator(start, targets, scans, options, context).Run();
}

}  // namespace annulus
