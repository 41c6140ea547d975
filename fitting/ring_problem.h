#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "base/calibration_target.h"
#include "base/ring_calibration.h"
#include "fitting/placement_bins.h"
#include "fitting/ring_unknowns.h"
#include "fitting/target_shape.h"

namespace annulus {

inline constexpr int kPoseUnknowns = 6;  ///< x, y, slope_x, slope_y, turn, z
inline constexpr int kFormUnknowns = 2 + 2 * static_cast<int>(TargetForm::kOrders);  ///< radius, taper, cosine, sine …
using PoseUnknowns = Eigen::Matrix<double, kPoseUnknowns, 1>;
using FormUnknowns = Eigen::Matrix<double, kFormUnknowns, 1>;

/// How far a ring may be from its drawings: sds of the unknowns before anything is measured. Wide, so that readings
/// decide wherever they can.
struct RingTolerances {
  double offset_mm = 4.0;              ///< Of one sensor's range, at the working distance.
  double scale = 0.006;                ///< Of one sensor.
  double position_mm = 1.5;            ///< Radial, tangential, height: each.
  double aim_rad = 0.026;              ///< 1.5 degrees, either angle.
  double common_offset_mm = 20.0;      ///< Of all sensors together.
  double common_scale = 0.02;          ///< Likewise.
  double quadratic_per_mm = 2e-5;      ///< Likewise.
  double ring_tilt_rad = 0.035;        ///< 2 degrees, either way.
  double height_scale = 0.003;         ///< Of the drive.
  double temperature_mm_per_c = 0.05;  ///< Of all sensors together.
  double pitch_rad_per_mm = 1.7e-6;    ///< Tilt of the carriage along its way: 0.1 degrees per metre.
  double path_mm = 1.0;                ///< Of the carriage's way from a straight line.
  double out_of_round_mm = 0.3;        ///< Each harmonic of a target.
  double taper = 2e-4;                 ///< Of a target's radius, mm/mm.
  double turn_rad = 0.05;              ///< Of a target's turn that was read off: 3 degrees.
};

/// The values of everything unknown.
struct CalibrationState {
  RingUnknowns ring;
  std::vector<PoseUnknowns> poses;  ///< One per placement; as TargetPose, absolute.
  std::vector<FormUnknowns> forms;  ///< One per target; radius absolute in mm, taper in mm per 500 mm, then mm.
};

/// A bin's residual and its derivatives, both divided by the sd of its distance.
struct BinRow {
  double residual = 0.0;
  Eigen::Matrix<double, 1, sensor_unknown::kCount> by_sensor = Eigen::Matrix<double, 1, sensor_unknown::kCount>::Zero();
  Eigen::Matrix<double, 1, ring_unknown::kCount> by_ring = Eigen::Matrix<double, 1, ring_unknown::kCount>::Zero();
  Eigen::Matrix<double, 1, kPoseUnknowns> by_pose = Eigen::Matrix<double, 1, kPoseUnknowns>::Zero();
  Eigen::Matrix<double, 1, kFormUnknowns> by_form = Eigen::Matrix<double, 1, kFormUnknowns>::Zero();
  std::size_t knot = 0;                                          ///< The path's knot below; the next is above.
  Eigen::RowVector2d by_knot = Eigen::RowVector2d::Zero();       ///< By x and y of that knot.
  Eigen::RowVector2d by_next_knot = Eigen::RowVector2d::Zero();  ///< And of the next; zero beyond the ends.
  double distance = 0.0;                                         ///< mm, expected.
  double cos_incidence = 0.0;
  double phi = 0.0;  ///< rad, the target's own angle.
};

/// What is the same in every evaluation. Borrows.
struct CalibrationSetup {
  const RingCalibration& start;
  const std::vector<CalibrationTarget>& targets;
  const std::vector<TargetScan>& scans;
  const std::vector<PlacementBins>& placements;
  double noise_mm = 0.5;     ///< sd of one full return.
  double middle_z_mm = 0.0;  ///< Height about which pitch and roll turn.
  double knot_spacing_mm = 150.0;
  double huber_sds = 3.0;  ///< Residuals beyond it count less.
};

/// The form of a target in the state, and the pose of a placement.
[[nodiscard]] TargetForm FormOf(const FormUnknowns& unknowns);
[[nodiscard]] TargetPose PoseOf(const PoseUnknowns& unknowns);
[[nodiscard]] PoseUnknowns UnknownsOf(const TargetPose& pose);

/// Measured less expected distance of one bin, in sds, with derivatives. False if the beam misses the target in this
/// state; then the row is all zero. `unknowns` point at the blocks that matter (knots: below, above).
struct BinUnknowns {
  const double* sensor;
  const double* ring;
  const double* pose;
  const double* form;
  const double* knot;
  const double* next_knot;
};
[[nodiscard]] bool EvaluateBin(const CalibrationSetup& setup, std::size_t placement, const TargetBin& bin,
                               const std::vector<double>& knots_z_mm, const BinUnknowns& unknowns, BinRow& row);

/// The same in a whole state.
[[nodiscard]] bool EvaluateBin(const CalibrationSetup& setup, const CalibrationState& state, std::size_t placement,
                               const TargetBin& bin, BinRow& row);

/// Knots of the carriage's path over the heights of all placements, `spacing_mm` apart or a little less.
[[nodiscard]] std::vector<double> PathKnots(const std::vector<PlacementBins>& placements, double spacing_mm);

/// Index of the knot below a height (station frame), 0 … knots - 2, and the share of the next one.
[[nodiscard]] std::pair<std::size_t, double> KnotAt(const std::vector<double>& knots_z_mm, double z);

}  // namespace annulus
