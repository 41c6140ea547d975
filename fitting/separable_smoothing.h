#pragma once

#include <Eigen/Core>

namespace annulus {

/// One direction of a tensor spline on a regular grid: BᵀB of its basis B at the grid's places, and DᵀD of the second
/// differences D there. Both symmetric, `gram` positive definite.
struct AxisForms {
  Eigen::MatrixXd gram;
  Eigen::MatrixXd bend;
};

/// The coordinates in which both forms of an axis are diagonal (Demmler, Reinsch 1975): shapesᵀ·gram·shapes = I and
/// shapesᵀ·bend·shapes = diag(bends), bends ascending from 0.
struct AxisModes {
  Eigen::MatrixXd shapes;
  Eigen::VectorXd bends;
};

/// The modes of an axis. Requires a positive definite `gram`.
[[nodiscard]] AxisModes FindModes(const AxisForms& forms);

/// The same for an axis that reads the same from both ends (basis function i mirrors n − 1 − i): even and odd modes are
/// found apart, in a quarter of the time. Bends do not ascend across the two.
[[nodiscard]] AxisModes FindMirroredModes(const AxisForms& forms);

/// What is to be smoothed on a complete grid.
struct GridData {
  Eigen::MatrixXd projected;  ///< B_thetaᵀ Y B_z, mm: data against every pair of basis functions, theta along rows.
  double squares = 0.0;       ///< Σ Y², mm².
  double cells = 0.0;         ///< Number of cells.
};

/// Smoothing weights of both directions, as multiples of the weight of a cell, and what they do on the complete grid.
struct SmoothingWeights {
  double theta = 0.0;
  double z = 0.0;
  double effective_parameters = 0.0;  ///< Trace of the hat matrix H: exact.
  double residual_parameters = 0.0;   ///< Trace of 2H − HHᵀ: what the residuals' mean square lacks of the noise's.
  double residual_sd = 0.0;           ///< sqrt(RSS/(cells − residual parameters)), mm.
  int scores = 0;                     ///< How many pairs were tried.
};

/// Chooses the weights of  min Σ (Y − BcB)² + theta·Σ(f_thetatheta)² + z·Σ(f_zz)²  by generalised cross-validation:
/// the least of RSS/(cells − trace H)². In the modes' coordinates all is diagonal, so a score is one pass over the
/// coefficients and its trace is exact. A compass search in the logarithms, from where data and penalty balance; within
/// 1e-8 … 1e8 of that.
[[nodiscard]] SmoothingWeights ChooseSeparableSmoothing(const AxisModes& theta, const AxisModes& z,
                                                        const GridData& data);

}  // namespace annulus
