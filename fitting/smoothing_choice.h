#pragma once

#include <Eigen/Core>

#include "base/result.h"
#include "fitting/spline_system.h"

namespace annulus {

/// What generalised cross-validation chose.
struct SmoothingChoice {
  double lambda = 0.0;  ///< mm², see ThinPlateWeights.
  double gcv = 0.0;     ///< Score at lambda: n·RSS/(n − edf)².
  double effective_parameters = 0.0;
  Eigen::VectorXd coefficients;
};

/// Minimises the GCV score over log λ of the thin plate by a walk in decades and golden section. `mean_radius` in mm.
/// Fails if no λ gives a positive definite system.
[[nodiscard]] Result<SmoothingChoice> ChooseSmoothing(const SplineSystem& system, const CellGrid& cells,
                                                      double mean_radius);

}  // namespace annulus
