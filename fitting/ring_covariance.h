#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <vector>

#include "fitting/ring_problem.h"

namespace annulus {

/// Which unknowns keep their values in the solve and its covariance.
struct HeldUnknowns {
  std::vector<bool> sensors;                           ///< By sensor.
  bool ring = false;                                   ///< Ring and carriage as a whole.
  std::vector<std::array<bool, kPoseUnknowns>> poses;  ///< By placement.
  /// Ring-wide unknowns that keep their values although nobody knows them better than their tolerance: what that does
  /// to all the others is in the covariance (consider parameters; Schmidt 1966).
  std::array<bool, ring_unknown::kCount> considered{};
};

/// sds of the unknowns before anything is measured. Zero: exactly known.
struct PriorSigmas {
  SensorUnknowns sensor;
  RingWideUnknowns ring;
  double path_mm = 1.0;
  std::vector<PoseUnknowns> poses;
  std::vector<FormUnknowns> forms;
};
[[nodiscard]] PriorSigmas PriorsOf(const RingTolerances& tolerances, const std::vector<CalibrationTarget>& targets,
                                   const std::vector<TargetScan>& scans);

/// A linear combination of unknowns: by_sensor[i] for sensor i (empty: none), and what all share, in the order ring,
/// path (x, y by knot), poses, forms.
struct RingFunctional {
  std::vector<SensorUnknowns> by_sensor;
  Eigen::VectorXd by_shared;
};

/// The posterior covariance of all unknowns near a state, by the sensors' Schur complement.
class RingCovariance {
 public:
  RingCovariance(const CalibrationSetup& setup, const CalibrationState& state, const PriorSigmas& priors,
                 const HeldUnknowns& held);

  [[nodiscard]] Eigen::Index shared() const { return shared_; }
  [[nodiscard]] Eigen::Index PathAt(std::size_t knot) const {
    return ring_unknown::kCount + 2 * static_cast<Eigen::Index>(knot);
  }
  [[nodiscard]] Eigen::Index PoseAt(std::size_t placement) const {
    return poses_at_ + kPoseUnknowns * static_cast<Eigen::Index>(placement);
  }
  [[nodiscard]] Eigen::Index FormAt(std::size_t target) const {
    return forms_at_ + kFormUnknowns * static_cast<Eigen::Index>(target);
  }
  /// A functional of zeros.
  [[nodiscard]] RingFunctional Zero() const;

  [[nodiscard]] double Variance(const RingFunctional& f) const { return Covariance(f, f); }
  [[nodiscard]] double Covariance(const RingFunctional& f, const RingFunctional& g) const;
  /// The part of a variance that comes of considered unknowns alone.
  [[nodiscard]] double ConsideredVariance(const RingFunctional& f) const;
  /// Before anything was measured.
  [[nodiscard]] double PriorVariance(const RingFunctional& f) const;
  /// Of one sensor's unknowns.
  [[nodiscard]] Eigen::Matrix<double, 7, 7> OfSensor(std::size_t sensor) const;
  /// Of g_i · unknowns of sensor i + shared · common unknowns, for all sensors: sensors x sensors. Row i of
  /// `by_shared` belongs to sensor i.
  [[nodiscard]] Eigen::MatrixXd Joint(const std::vector<SensorUnknowns>& by_sensor,
                                      const Eigen::MatrixXd& by_shared) const;

  [[nodiscard]] std::size_t sensors() const { return held_sensors_.size(); }
  [[nodiscard]] bool IsHeld(std::size_t sensor) const { return held_sensors_[sensor]; }
  [[nodiscard]] double path_prior_mm() const { return path_prior_mm_; }
  [[nodiscard]] double chi_square() const { return chi_square_; }  ///< Of the bins alone.
  [[nodiscard]] std::size_t bins() const { return bins_; }

 private:
  using Matrix7 = Eigen::Matrix<double, 7, 7>;
  /// The normal equations before the sensors are eliminated.
  struct Normal {
    std::vector<Matrix7> own;
    std::vector<Eigen::Matrix<double, 7, Eigen::Dynamic>> coupling;
    Eigen::MatrixXd common;  ///< Lower triangle.
  };
  void SetPriors(const CalibrationSetup& setup, const PriorSigmas& priors, const HeldUnknowns& held);
  [[nodiscard]] Normal PriorNormal() const;
  void AddBins(const CalibrationSetup& setup, const CalibrationState& state, Normal& normal);
  void Eliminate(Normal& normal, const HeldUnknowns& held);
  [[nodiscard]] Eigen::VectorXd Reduced(const RingFunctional& f) const;

  Eigen::Index poses_at_ = 0, forms_at_ = 0, shared_ = 0;
  std::vector<Eigen::LLT<Matrix7>> own_;
  std::vector<Eigen::Matrix<double, 7, Eigen::Dynamic>> coupling_;  ///< own^-1 times the coupling to the shared ones.
  Eigen::LLT<Eigen::MatrixXd> reduced_;
  /// How the shared unknowns follow one sd of each considered one: a column each.
  Eigen::MatrixXd followed_;
  SensorUnknowns sensor_prior_;
  double path_prior_mm_ = 0.0;
  std::vector<bool> held_sensors_;
  Eigen::VectorXd shared_prior_;  ///< sds
  double chi_square_ = 0.0;
  std::size_t bins_ = 0;
};

}  // namespace annulus
