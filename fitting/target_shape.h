#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>

#include "base/calibration_target.h"
#include "base/frames.h"

namespace annulus {

/// What a target really is like, beside its nominal shape: the mean radius, and the deviations that are estimated with
/// it. Of a plane, `radius_mm` is half the thickness of the board.
struct TargetForm {
  static constexpr std::size_t kFirstOrder = 2;  ///< Order 0 is the radius, order 1 the place of the axis.
  static constexpr std::size_t kOrders = 7;      ///< Orders 2 … 8.

  double radius_mm = 0.0;
  double taper = 0.0;                       ///< mm/mm; growth of the radius along the axis, from the pose's point on.
  std::array<double, kOrders> cosine_mm{};  ///< Out-of-roundness: amplitudes of cos(k phi), k = 2 … 8.
  std::array<double, kOrders> sine_mm{};    ///< And of sin(k phi); phi turns with the target.

  /// Out-of-roundness at an angle, mm.
  [[nodiscard]] double OutOfRound(double phi) const;
  /// Its derivative, mm/rad.
  [[nodiscard]] double OutOfRoundSlope(double phi) const;
};

/// Where a target stands. A cylinder's axis passes through (x, y, z) in the direction (slope_x, slope_y, 1); its angle
/// phi is counted from x, less `turn`. A step target likewise, with its foot at (x, y, z). A sphere's centre is (x, y,
/// z). A plane passes through (x, y, z) with the normal (cos turn, sin turn, slope_x), not of unit length.
struct TargetPose {
  double x = 0.0, y = 0.0, z = 0.0;     ///< mm, station frame
  double slope_x = 0.0, slope_y = 0.0;  ///< mm/mm
  double turn = 0.0;                    ///< rad
};

/// Where a beam meets a placed target.
struct TargetHit {
  double distance = 0.0;     ///< mm along the beam.
  Eigen::Vector3d gradient;  ///< Of the target's implicit function, outwards; nearly of unit length.
  double phi = 0.0;          ///< rad, the target's own angle there; 0 for planes.
  double cos_phi = 1.0, sin_phi = 0.0;
  double along = 0.0;  ///< mm along the axis from the pose's point.
  double cos_incidence = 0.0;
};

/// Exact to 1e-9 mm: the nominal shape in closed form, then Newton's method. Ends (top, foot, edges of a board) are not
/// looked at. Nothing if the beam passes by.
[[nodiscard]] std::optional<TargetHit> MeetTarget(const CalibrationTarget& target, const TargetForm& form,
                                                  const TargetPose& pose, const Ray& ray);

/// Derivatives of TargetHit::distance by the pose (x, y, slope_x, slope_y, turn, z), mm per mm or per 1.
[[nodiscard]] Eigen::Matrix<double, 6, 1> DistanceByPose(const CalibrationTarget& target, const TargetForm& form,
                                                         const TargetPose& pose, const Ray& ray, const TargetHit& hit);

/// Derivatives by the form: radius, taper, then cosine and sine by turns from order 2.
[[nodiscard]] Eigen::Matrix<double, 2 + 2 * static_cast<int>(TargetForm::kOrders), 1> DistanceByForm(
    const CalibrationTarget& target, const Ray& ray, const TargetHit& hit);

}  // namespace annulus
