#pragma once

#include <Eigen/Core>
#include <vector>

#include "fitting/fit_input.h"
#include "fitting/spline_system.h"

namespace annulus {

/// Residuals collected by cell of the input's grid.
struct ResidualMaps {
  std::vector<double> sum;  ///< mm
  std::vector<double> squares;
  std::vector<double> count;
};

[[nodiscard]] ResidualMaps CollectResiduals(const FitInput& input, const SplineSystem& system,
                                            const Eigen::VectorXd& residuals);

/// Local scale of the residuals over the noise, >= 1, one per row of the system: RMS over the 5 × 5 cells around
/// without the worst of them, so that a loss widens where the surface is rough, but not for the one outlier that it
/// should catch.
[[nodiscard]] std::vector<double> LocalScales(const FitInput& input, const SplineSystem& system,
                                              const Eigen::VectorXd& residuals);

/// Samples (indices into the input's) that stand alone against a fitted surface: more than 5 mm and 8 local scales off.
/// The screening by neighbourhood cannot see these on steep ground, where the neighbours' radii differ by more.
[[nodiscard]] std::vector<std::uint32_t> LoneSamples(const FitInput& input, const SplineSystem& system,
                                                     const Eigen::VectorXd& residuals);

/// Flags of cells in which the residuals are not noise: in some window around (1 × 1 to 5 × 5 cells) that has data
/// their sum is more than 3.8 standard deviations; and from there on as long as it is more than 2 in a window about the
/// cell (hysteresis: Canny 1986), since detail hangs together and noise does not. More on scans of very many cells.
/// Cells without data are never flagged: nothing is resolved in a hole.
[[nodiscard]] std::vector<char> UnresolvedCells(const FitInput& input, const ResidualMaps& residuals);

}  // namespace annulus
