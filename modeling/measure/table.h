#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "modeling/measure/landmark.h"
#include "modeling/measure/section.h"

namespace annulus {

/// What the uncertainty of a number is made of: standard deviations in its own unit.
struct UncertaintyBudget {
  double fit = 0.0;        ///< Noise, smoothing and detail not followed; landmarks moving with them included. NaN where
                           ///< the model carries no normal matrix.
  double landmarks = 0.0;  ///< Placing of the landmarks (Landmark::placing_across, placing_up).
  double sampling = 0.0;   ///< What lies between the rays of a ring.
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

/// A level found on the body.
struct BodyLevel {
  std::string id;  ///< "head", "neck", "chest", "waist", "hip".
  double z = 0.0;  ///< mm
  std::string definition;
};

/// What can be measured on a model, and what cannot.
struct MeasurementTable {
  std::vector<BodyLevel> levels;
  std::vector<Measurement> measurements;
  Landmarks landmarks{};
  std::vector<std::string> omitted{};  ///< One sentence for each level or measurement that was left out, and why.
};

/// Finds the levels of head, neck, chest, waist and hip from how the tape girth runs over the height, and measures
/// girths (tape and perimeter), heights and surface lengths there. A head scan gives head and neck only; a scan that
/// starts below the head gives no head. Fails only if not one section of the body is fully known.
[[nodiscard]] Result<MeasurementTable> MeasureTable(const MeasuredSurface& body, const TaskContext& context);

}  // namespace annulus
