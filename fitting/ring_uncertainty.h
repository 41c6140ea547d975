#pragma once

#include <vector>

#include "fitting/calibrate_ring.h"
#include "fitting/ring_covariance.h"

namespace annulus {

/// The effective radial error of every sensor's points at a distance, as functionals: rows of the sensors' own part,
/// and of what they share.
struct EffectiveRadial {
  std::vector<SensorUnknowns> by_sensor;
  Eigen::MatrixXd by_shared;
};
[[nodiscard]] EffectiveRadial EffectiveRadialAt(const RingCovariance& covariance, std::size_t sensors,
                                                double distance_mm);
/// Its mean over all sensors: what a girth sees.
[[nodiscard]] RingFunctional CommonRadialAt(const RingCovariance& covariance, std::size_t sensors, double distance_mm);

/// Uncertainties of the solution: sensors, common term, the calibration's own CalibrationUncertainty, targets, budget.
void FillUncertainty(const CalibrationSetup& setup, const CalibrationState& state, const PriorSigmas& priors,
                     const RingCovariance& covariance, RingSolution& solution);

}  // namespace annulus
