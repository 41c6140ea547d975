#include "fitting/ring_costs.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <utility>

namespace annulus {
namespace {

/// One bin as Ceres sees it: sensor, ring, pose, form, the two knots of the carriage's path.
class BinCost final : public ceres::SizedCostFunction<1, sensor_unknown::kCount, ring_unknown::kCount, kPoseUnknowns,
                                                      kFormUnknowns, 2, 2> {
 public:
  BinCost(const CalibrationSetup& setup, const std::vector<double>& knots, std::size_t placement, const TargetBin& bin)
      : setup_(setup), knots_(knots), placement_(placement), bin_(bin) {}

  bool Evaluate(double const* const* u, double* residual, double** jacobians) const override {
    BinRow row;
    const bool met = EvaluateBin(setup_, placement_, bin_, knots_, {u[0], u[1], u[2], u[3], u[4], u[5]}, row);
    // A beam that misses the target in a trial state: as far off as its edge, so that the step is not believed.
    constexpr double kMissed = 1e3;
    residual[0] = met ? row.residual : kMissed;
    if (jacobians == nullptr) return true;
    const auto put = [&](int block, const auto& values) {
      if (jacobians[block] == nullptr) return;
      for (Eigen::Index k = 0; k < values.size(); ++k) jacobians[block][k] = values[k];
    };
    put(0, row.by_sensor);
    put(1, row.by_ring);
    put(2, row.by_pose);
    put(3, row.by_form);
    put(4, row.by_knot);
    put(5, row.by_next_knot);
    return true;
  }

 private:
  const CalibrationSetup& setup_;
  const std::vector<double>& knots_;
  std::size_t placement_;
  const TargetBin& bin_;
};

/// (value - mean) / sigma, number by number.
class PriorCost final : public ceres::CostFunction {
 public:
  PriorCost(Eigen::VectorXd mean, Eigen::VectorXd sigma) : mean_(std::move(mean)), sigma_(std::move(sigma)) {
    mutable_parameter_block_sizes()->push_back(static_cast<int>(mean_.size()));
    set_num_residuals(static_cast<int>(mean_.size()));
  }
  bool Evaluate(double const* const* u, double* residuals, double** jacobians) const override {
    const Eigen::Index n = mean_.size();
    for (Eigen::Index k = 0; k < n; ++k) residuals[k] = (u[0][k] - mean_[k]) / Sigma(k);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::MatrixXd>(jacobians[0], n, n).setZero();
      for (Eigen::Index k = 0; k < n; ++k) jacobians[0][k * n + k] = 1.0 / Sigma(k);
    }
    return true;
  }

 private:
  [[nodiscard]] double Sigma(Eigen::Index k) const { return std::max(sigma_[k], 1e-6); }
  Eigen::VectorXd mean_, sigma_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> MakeBinCost(const CalibrationSetup& setup, const std::vector<double>& knots_z_mm,
                                                 std::size_t placement, const TargetBin& bin) {
  return std::make_unique<BinCost>(setup, knots_z_mm, placement, bin);
}

std::unique_ptr<ceres::CostFunction> MakePriorCost(Eigen::VectorXd mean, Eigen::VectorXd sigma) {
  return std::make_unique<PriorCost>(std::move(mean), std::move(sigma));
}

}  // namespace annulus
