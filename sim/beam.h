#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

#include "base/frames.h"
#include "sim/subject.h"

namespace annulus::sim {

/// What a point range sensor does to the truth. The reading is a mixture (after Thrun, Burgard and Fox, Probabilistic
/// Robotics, §6.3): with probability
/// - uniform_rate                 anything in [0, max_range] (stray light), whether the beam meets the subject or not;
/// - dropout_rate, raised by a weak signal: miss, no return;
/// - outlier_rate                 short or long by outlier_min_mm … outlier_max_mm, either sign alike;
/// - else                         hit: the true range plus Gaussian noise.
/// The signal is reflectance · cos(incidence) · (share of the spot on the surface), 1 at best. Noise is limited by the
/// number of photons: sigma = noise_sigma_mm / sqrt(signal).
struct BeamOptions {
  double noise_sigma_mm = 0.5;    ///< sd of one reading at signal 1, mm, >= 0.
  double dropout_rate = 0.01;     ///< Probability of no return at a strong signal, 0 … 1.
  double outlier_rate = 0.002;    ///< Probability of a wrong range, 0 … 1.
  double outlier_min_mm = 20.0;   ///< Smallest error of an outlier, mm.
  double outlier_max_mm = 200.0;  ///< Largest error of an outlier, mm.
  double uniform_rate = 0.0;      ///< Probability of a reading that has nothing to do with the subject, 0 … 1.
  double spot_diameter_mm = 2.0;  ///< Diameter of the collimated spot, mm; 0 is a mathematical ray.
  std::size_t spot_rays = 4;      ///< Rays beside the central one that sample the spot; 0 turns the spot off.
  double weak_signal = 0.15;      ///< Below it returns get lost: extra probability (1 - signal/weak_signal)².
};

/// One reading of one sensor.
struct BeamReading {
  double range_mm = 0.0;     ///< mm from the ray's origin; NaN: no return.
  std::uint8_t quality = 0;  ///< 0 (none) … 255 (best): 255 · signal.
};

/// The beam model; see BeamOptions. Reentrant: the only state is the engine that is passed in.
class BeamModel {
 public:
  /// Requires rates in [0, 1] and lengths >= 0, outlier_min_mm <= outlier_max_mm.
  explicit BeamModel(BeamOptions options);

  /// One reading along `ray` (station frame, unit direction) at `time_s`. Takes the same number of draws from `random`
  /// whatever happens, so that one beam's fate does not shift the noise of the next.
  [[nodiscard]] BeamReading Measure(const Subject& subject, const Ray& ray, double time_s, double max_range_mm,
                                    std::mt19937_64& random) const;

  [[nodiscard]] const BeamOptions& options() const { return options_; }

 private:
  BeamOptions options_;
};

}  // namespace annulus::sim
