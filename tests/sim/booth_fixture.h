#pragma once

#include <memory>
#include <utility>

#include "firmware_iface/range_ring.h"
#include "firmware_iface/scan_axis.h"
#include "sim/booth.h"
#include "tests/sim/cylinder_subject.h"

namespace annulus::sim {

inline constexpr double kCylinderRadiusMm = 150.0;
inline constexpr double kCylinderTopMm = 1700.0;

/// A beam that tells the truth.
inline BeamOptions ExactBeam() {
  BeamOptions options;
  options.noise_sigma_mm = 0.0;
  options.dropout_rate = 0.0;
  options.outlier_rate = 0.0;
  options.spot_diameter_mm = 0.0;
  options.spot_rays = 0;
  return options;
}

/// A booth with a cylinder in it.
inline BoothOptions CylinderBooth(BeamOptions beam = ExactBeam()) {
  BoothOptions options;
  options.subject = std::make_unique<CylinderSubject>(kCylinderRadiusMm, kCylinderTopMm);
  options.beam = beam;
  return options;
}

}  // namespace annulus::sim
