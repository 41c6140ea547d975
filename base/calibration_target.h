#pragma once

#include <string>
#include <vector>

namespace annulus {

/// An artefact of known shape that a ring is calibrated with. In its own frame the target's axis is z, its foot is at
/// z = 0, mm.
struct CalibrationTarget {
  enum class Kind {
    kCylinder,  ///< A round column.
    kSphere,    ///< A sphere on a thin rod.
    kPlane,     ///< A flat board that stands upright: y = 0, of width `width_mm`.
    kStep,  ///< A round column of `radius_mm` whose radius is larger by `step_mm` in every second interval of edges.
  };

  Kind kind = Kind::kCylinder;
  std::string serial;              ///< Of the artefact; "" where it has none.
  std::string certificate_number;  ///< "" if nobody has certified it: what rests on it is not traceable then.
  double radius_mm = 0.0;          ///< Certified, at certified_c. Not for planes.
  double expanded_u_mm = 0.0;      ///< U of the radius (k = 2); of a step target, of the edges' heights too.
  double certified_c = 20.0;       ///< Temperature of the certificate, degrees Celsius.
  double expansion_per_c = 0.0;    ///< Relative expansion of the material per degree, e.g. 23e-6 for aluminium.
  double height_mm = 1000.0;       ///< From foot to top; of a sphere: of its centre over the floor.
  double width_mm = 800.0;         ///< Of a plane.
  double step_mm = 0.0;            ///< Of a step target, > 0.
  std::vector<double> edges_mm;    ///< Heights over the foot of a step target's edges, ascending; the first rises.

  /// The radius at a temperature, mm.
  [[nodiscard]] double RadiusAt(double temperature_c) const {
    return radius_mm * (1.0 + expansion_per_c * (temperature_c - certified_c));
  }
  bool operator==(const CalibrationTarget&) const = default;
};

}  // namespace annulus
