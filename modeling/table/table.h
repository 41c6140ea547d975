#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/landmarks/landmark.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// What the uncertainty of a number is made of: standard deviations in its own unit.
struct UncertaintyBudget {
  double fit = 0.0;        ///< Noise, smoothing and detail not followed; landmarks moving with them included. NaN where
                           ///< the model carries no normal matrix.
  double landmarks = 0.0;  ///< Placing of the landmarks (Landmark::placing_across, placing_up).
  double detail = 0.0;     ///< Length of detail that the surface does not follow (unresolved_length.h).
  double calibration = 0.0;  ///< Of the ring; 0 until a calibration says more.
  double sway = 0.0;         ///< The subject's movement; 0 until it is known.
};

/// One line of the measurement table.
struct Measurement {
  std::string id;          ///< Stable: "waist_girth".
  std::string term;        ///< The field's English term: "Waist girth".
  std::string definition;  ///< How it is taken, in one sentence.
  std::string unit;        ///< "mm", "mm2", "mm3" or "deg".
  Uncertain value;
  double measured_share = 0.0;         ///< Of its path, 0 … 1.
  double iso20685_limit_mm = 0.0;      ///< Class limit of ISO 20685-1 (4, 5, 9, 2 or 1 mm); 0 where none applies.
  std::vector<std::string> landmarks;  ///< Ids of the landmarks it uses: "level.waist", "pronasale".
  std::string method{};        ///< "tape, horizontal", "tape, taut over the skin", "straight line", "volume", …
  UncertaintyBudget budget{};  ///< value.sigma is the root of its sum of squares.
  /// Where it lies on the body, station frame, mm: polylines for pictures; empty for volumes and areas.
  std::vector<std::vector<Eigen::Vector3d>> paths{};
};

/// What can be measured on a model, and what cannot.
struct MeasurementTable {
  Landmarks landmarks;
  std::vector<Measurement> measurements;
  std::vector<std::string> omitted;  ///< One sentence for each landmark or measurement that was left out, and why.
};

/// Every measurement of the table that the landmarks allow (docs/measurements.md lists them), each with its
/// uncertainty. Fails if there is no landmark.
[[nodiscard]] Result<MeasurementTable> MeasureTable(const MeasuredSurface& body, Landmarks landmarks);

}  // namespace annulus
