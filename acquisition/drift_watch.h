#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "acquisition/neighbour_prediction.h"
#include "acquisition/scan.h"

namespace annulus {

/// What one scan says of one sensor against its neighbours.
struct SensorDrift {
  /// Radius seen less radius predicted from the neighbours, mm: > 0, the sensor reads too short. NaN: it saw too
  /// little.
  double offset_mm = std::numeric_limits<double>::quiet_NaN();
  double sigma_mm = std::numeric_limits<double>::infinity();     ///< sd of it, from the scan itself.
  double trend_mm_s = std::numeric_limits<double>::quiet_NaN();  ///< How the offset changed during the scan, mm/s.
  double trend_sigma_mm_s = std::numeric_limits<double>::infinity();
  std::uint32_t levels = 0;  ///< Levels on which it could be compared.
  /// How its neighbours were taken on the average: an error of that neighbour moves offset_mm by minus the weight.
  std::array<float, kNeighbours> neighbour_weight{};

  [[nodiscard]] bool known() const;
};

/// What one scan of anybody or anything smooth says of the ring.
struct DriftEstimate {
  std::string scan_hash;
  std::string calibration;  ///< RingCalibration::certificate of the scan; "" for an ideal ring.
  std::string ring_serial;
  std::int64_t wall_start_ns = 0;    ///< ns since 1970; 0 where unknown.
  double duration_s = 0.0;           ///< From the first to the last level.
  double residual_mm = 0.0;          ///< Median magnitude of all single comparisons: noise and the body's detail.
  std::vector<SensorDrift> sensors;  ///< By sensor number.
};

/// Fewest sensors of a ring whose neighbours can be compared.
inline constexpr std::size_t kFewestComparedSensors = 24;

/// Each sensor's offset against its neighbours, from one scan of a customer.
///
/// On each level a sensor's radius is held against the cubic in theta through its neighbours (three to either side);
/// where the body is rough (creases, edges, arms, cloth) a level counts little. The offset is the robust mean (Tukey's
/// biweight) over all levels of all sweeps, its sd comes from how its means over 50 mm of height scatter, so that
/// detail of the body that runs up and down counts as what it is. The trend compares sweeps at the same height: the
/// body's shape cancels, and sway is smooth in theta.
///
/// What all sensors have in common, and what changes slowly around the ring, cannot be seen this way: a reference check
/// with a known cylinder sees it. A sensor's own error also moves what is predicted for its neighbours
/// (neighbour_weight); FindDrift takes that apart. Rings with fewer than 24 sensors: all unknown. About 50 ms.
[[nodiscard]] DriftEstimate EstimateDrift(const Scan& scan);

}  // namespace annulus
