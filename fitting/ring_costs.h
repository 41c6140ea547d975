#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "fitting/ring_problem.h"

namespace ceres {
class CostFunction;
}  // namespace ceres

namespace annulus {

/// One bin as Ceres sees it. Parameter blocks: sensor, ring, pose, form, the two knots of the carriage's path. Borrows
/// everything.
[[nodiscard]] std::unique_ptr<ceres::CostFunction> MakeBinCost(const CalibrationSetup& setup,
                                                               const std::vector<double>& knots_z_mm,
                                                               std::size_t placement, const TargetBin& bin);

/// (value - mean) / sigma, number by number, of one parameter block.
[[nodiscard]] std::unique_ptr<ceres::CostFunction> MakePriorCost(Eigen::VectorXd mean, Eigen::VectorXd sigma);

}  // namespace annulus
