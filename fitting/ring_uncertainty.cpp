#include "fitting/ring_uncertainty.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

using Kind = CalibrationTarget::Kind;

/// What the certificates of the edges' heights leave unknown of the scale: all sensors see the same edges. 0 if there
/// are none, where the tolerance says enough.
double EdgeVariance(const CalibrationSetup& setup) {
  double precision = 0.0;
  for (const CalibrationTarget& target : setup.targets) {
    if (target.kind != Kind::kStep || target.edges_mm.size() < 2) continue;
    double mean = 0.0;
    for (const double edge : target.edges_mm) mean += edge / static_cast<double>(target.edges_mm.size());
    double spread = 0.0;
    for (const double edge : target.edges_mm) spread += (edge - mean) * (edge - mean);
    precision += spread / std::pow(std::max(1e-6, 0.5 * target.expanded_u_mm), 2);
  }
  return precision > 0.0 ? 1.0 / precision : 0.0;
}

}  // namespace

EffectiveRadial EffectiveRadialAt(const RingCovariance& covariance, std::size_t sensors, double distance_mm) {
  const double u = (distance_mm - kWorkingDistance) / 100.0;
  SensorUnknowns own = SensorUnknowns::Zero();
  own[sensor_unknown::kRadial] = 1.0;
  own[sensor_unknown::kOffset] = -1.0;
  own[sensor_unknown::kScale] = -u;
  EffectiveRadial effective;
  effective.by_sensor.assign(sensors, own);
  effective.by_shared.setZero(static_cast<Eigen::Index>(sensors), covariance.shared());
  effective.by_shared.col(ring_unknown::kOffset).setConstant(-1.0);
  effective.by_shared.col(ring_unknown::kScale).setConstant(-u);
  effective.by_shared.col(ring_unknown::kQuadratic).setConstant(-u * u);
  return effective;
}

RingFunctional CommonRadialAt(const RingCovariance& covariance, std::size_t sensors, double distance_mm) {
  const EffectiveRadial effective = EffectiveRadialAt(covariance, sensors, distance_mm);
  RingFunctional f;
  f.by_sensor = effective.by_sensor;
  for (SensorUnknowns& by : f.by_sensor) by /= static_cast<double>(sensors);
  f.by_shared = effective.by_shared.colwise().mean().transpose();
  return f;
}

void FillUncertainty(const CalibrationSetup& setup, const CalibrationState& state, const PriorSigmas& priors,
                     const RingCovariance& covariance, RingSolution& solution) {
  const std::size_t sensors = setup.start.sensors.size();
  const auto n = static_cast<Eigen::Index>(sensors);
  solution.common_sigma_mm.resize(kCommonCount);
  for (int k = 0; k < kCommonCount; ++k) {
    solution.common_sigma_mm[k] =
        std::sqrt(covariance.Variance(CommonRadialAt(covariance, sensors, kCommonFrom + k * kCommonStep)));
  }
  // Effective radial errors, without the shift of the ring's centre, which is none of a section's own.
  const EffectiveRadial effective = EffectiveRadialAt(covariance, sensors, kWorkingDistance);
  Eigen::MatrixXd joint = covariance.Joint(effective.by_sensor, effective.by_shared);
  Eigen::MatrixXd shift(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double theta = setup.start.sensors[static_cast<std::size_t>(i)].theta;
    shift.row(i) << std::cos(theta), std::sin(theta);
  }
  const Eigen::MatrixXd without =
      Eigen::MatrixXd::Identity(n, n) - shift * (shift.transpose() * shift).inverse() * shift.transpose();
  joint = without * joint * without;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(joint);
  constexpr Eigen::Index kModes = 8;
  const Eigen::Index kept = std::min(kModes, n);
  CalibrationUncertainty uncertainty;
  uncertainty.together_mm =
      modes.eigenvectors().rightCols(kept) * modes.eigenvalues().tail(kept).cwiseMax(0.0).cwiseSqrt().asDiagonal();
  solution.sensor_sigma_mm = joint.diagonal().cwiseMax(0.0).cwiseSqrt();
  for (Eigen::Index i = 0; i < n; ++i) {
    uncertainty.own_mm.push_back(std::sqrt(std::max(0.0, joint(i, i) - uncertainty.together_mm.row(i).squaredNorm())));
  }
  uncertainty.distance_mm = kWorkingDistance;
  RingFunctional height = covariance.Zero();
  height.by_shared[ring_unknown::kHeightScale] = 1.0;
  uncertainty.height_scale_sigma = std::sqrt(covariance.Variance(height) + EdgeVariance(setup));
  uncertainty.height_offset_sigma_mm =
      0.0;  // heights are over the ring's own zero: its place over the floor is homing's
  solution.calibration.uncertainty = std::move(uncertainty);
  for (std::size_t i = 0; i < sensors; ++i) solution.sensor_covariance.push_back(covariance.OfSensor(i));

  const RingFunctional girth = CommonRadialAt(covariance, sensors, 600.0 - 900.0 / kTwoPi);
  const double girth_variance = covariance.Variance(girth);
  double by_targets = 0.0;
  for (std::size_t t = 0; t < setup.targets.size(); ++t) {
    TargetResult target;
    target.form = FormOf(state.forms[t]);
    for (int k = 0; k < kFormUnknowns; ++k) {
      RingFunctional f = covariance.Zero();
      f.by_shared[covariance.FormAt(t) + k] = 1.0;
      target.form_sigma[k] = std::sqrt(covariance.Variance(f));
    }
    double low = 0.0;
    double high = 0.0;
    for (int degree = 0; degree < 360; ++degree) {
      const double out = target.form.OutOfRound(RadiansFromDegrees(degree));
      low = std::min(low, out);
      high = std::max(high, out);
    }
    target.out_of_round_mm = high - low;
    target.certified_radius_mm = priors.forms[t][0];  // replaced by the caller, who knows the temperature
    target.certified_sigma_mm = priors.forms[t][0];
    if (setup.targets[t].kind != Kind::kPlane) {
      RingFunctional radius = covariance.Zero();
      radius.by_shared[covariance.FormAt(t)] = 1.0;
      const double prior = std::max(priors.forms[t][0], 1e-9);
      by_targets += std::pow(covariance.Covariance(girth, radius) / prior, 2);
    }
    solution.targets.push_back(std::move(target));
  }
  const auto line = [&](const char* name, double variance) {
    const double sigma = std::sqrt(std::max(0.0, variance));
    const double girth_mm = kTwoPi * sigma;
    solution.budget.push_back({name, girth_mm, 100.0 * 2.0 * sigma / (900.0 / kTwoPi)});
  };
  line("target radius (U/2 of the certificates)", by_targets);
  line("readings and sensors", girth_variance - by_targets);
  RingFunctional warm = covariance.Zero();
  warm.by_shared[ring_unknown::kTemperature] = 1.0;
  constexpr double kWarming = 3.0;  // degrees: sd of a ring's temperature against that of its calibration
  line("temperature of the ring, 3 degrees off", kWarming * kWarming * covariance.Variance(warm));
  double tilt = 0.0;
  for (const int axis : {ring_unknown::kTiltX, ring_unknown::kTiltY}) {
    RingFunctional f = covariance.Zero();
    f.by_shared[axis] = 1.0;
    tilt += covariance.Variance(f);
  }
  line("tilt of the ring's plane", std::pow(900.0 / kTwoPi * tilt / 4.0, 2));
  double total = 0.0;
  for (const BudgetLine& part : solution.budget) total += part.girth_mm * part.girth_mm;
  solution.budget.push_back({"all together", std::sqrt(total), 0.0});
  double volume = 0.0;
  for (const BudgetLine& part : solution.budget) volume += part.volume_percent * part.volume_percent;
  volume += std::pow(100.0 * solution.calibration.uncertainty->height_scale_sigma, 2);
  solution.budget.back().volume_percent = std::sqrt(volume);
  solution.budget.insert(solution.budget.end() - 1,
                         {"z scale", 0.0, 100.0 * solution.calibration.uncertainty->height_scale_sigma});
}

}  // namespace annulus
