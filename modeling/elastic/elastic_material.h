#pragma once

namespace annulus {

/// An isotropic elastic material. Soft tissue over a firm core: 5 … 50 kPa, nearly incompressible.
struct ElasticMaterial {
  double young = 0.01;    ///< E, N/mm² (10 kPa); > 0.
  double poisson = 0.48;  ///< ν, 0 … 0.49.

  /// Lamé's constants, N/mm².
  [[nodiscard]] double lambda() const { return young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)); }
  [[nodiscard]] double mu() const { return 0.5 * young / (1.0 + poisson); }
};

}  // namespace annulus
