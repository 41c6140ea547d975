#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "base/calibration_target.h"
#include "base/ring_calibration.h"
#include "sim/acting_subject.h"
#include "sim/subject.h"
#include "sim/target_subject.h"

namespace annulus {

/// [sim.target]: a calibration target that stands in the simulated booth instead of a person.
struct SimTarget {
  CalibrationTarget target;      ///< As certified.
  sim::TargetTruth truth;        ///< As it is, but for its out-of-roundness.
  double out_of_round_mm = 0.0;  ///< Largest error of its radius by out-of-roundness.
  std::uint64_t seed = 1;        ///< Of its shape: another seed is another artefact.
  sim::TargetPlacement placement;
  std::optional<sim::StepAside> moved;  ///< Somebody pushes it.
};

/// Why there cannot be such a target, in words; "" if there can.
[[nodiscard]] std::string SimTargetTrouble(const SimTarget& target);

/// The target as something that beams meet. Requires that SimTargetTrouble finds none.
[[nodiscard]] std::unique_ptr<sim::Subject> MakeSimTarget(const SimTarget& target);

/// [sim] ring_…: how far the simulated ring is from the ideal one.
struct SimRing {
  double errors = 0.0;                  ///< Times the errors of a ring as it leaves its assembly; 0 is none.
  std::optional<std::uint64_t> seed;    ///< Which ring it is; nothing: by the seed of all.
  double tilt_rad = 0.0;                ///< Its front is raised; rad.
  double bend_mm = 0.0;                 ///< Largest sideways error of the rails, mm.
  double position_scale = 1.0;          ///< True over reported height.
  double range_mm_per_c = 0.0;          ///< mm by which all offsets rise per degree over 20 degrees Celsius.
  std::optional<double> temperature_c;  ///< Of its boards; nothing: about 31.

  bool operator==(const SimRing&) const = default;
};

/// The true geometry of a simulated ring at its reference temperature, or nothing for an ideal ring. `seed` is that of
/// all, where the ring has none of its own.
[[nodiscard]] std::optional<RingCalibration> SimulatedRing(const SimRing& ring, double radius_mm, std::uint64_t seed);

}  // namespace annulus
