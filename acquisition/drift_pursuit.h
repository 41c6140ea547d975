#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "acquisition/drift_history.h"

namespace annulus {

/// Sensors side by side that may drift as one.
struct SensorBlock {
  std::size_t first = 0;
  std::size_t count = 1;
};

/// Deviations of all sensors, by sensor. NaN: unknown.
struct DriftEvidence {
  std::vector<double> deviation;
  std::vector<double> noise_variance;  ///< From readings, which neighbours share: correlated as their stencils say.
  std::vector<double> own_variance;    ///< From what each direction has for itself.
};

/// Takes deviations apart into few blocks' drifts: matching pursuit under the deviations' covariance. A drift of one
/// sensor moves its own deviation by as much, and those of its neighbours by minus its weight in their stencils.
class DriftPursuit {
 public:
  /// `evidence`: offsets, and for one scan trends too (at most two). `stencils` by sensor.
  DriftPursuit(const DriftHistory::Stencils& stencils, std::vector<SensorBlock> blocks,
               const std::vector<DriftEvidence>& evidence);

  /// What one block explains.
  struct Fit {
    SensorBlock block;
    std::array<double, 2> size{};      ///< By evidence.
    std::array<double, 2> variance{};  ///< Of the sizes.
    double gain = 0.0;                 ///< By how much chi-square falls.
    std::size_t index = 0;             ///< Of the block.
  };
  /// The block that explains most of what is left, of those that were not taken yet; gain 0: none.
  [[nodiscard]] Fit Best() const;
  /// Takes its share out of the deviations.
  void Subtract(const Fit& fit);

 private:
  /// One kind of evidence, whitened.
  struct White {
    Eigen::VectorXd deviation;
    Eigen::MatrixXd patterns;  ///< Column by block.
    Eigen::VectorXd weight;    ///< Squared length of the patterns.
  };

  std::vector<SensorBlock> blocks_;
  std::vector<White> white_;
  std::vector<char> taken_;
};

}  // namespace annulus
