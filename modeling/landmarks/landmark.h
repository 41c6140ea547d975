#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/units.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// How a landmark was found.
enum class LandmarkSource {
  kDetected,    ///< The feature was found on the surface.
  kProportion,  ///< The feature was not found or cannot be seen by a ring; placed by proportion. Say so where it is
                ///< used.
  kGiven,       ///< Set by a person.
};
/// "detected", "proportion", "given".
[[nodiscard]] std::string_view LandmarkSourceName(LandmarkSource source);

/// What a landmark is: a point of the surface, or a height at which the body is cut.
enum class LandmarkKind { kPoint, kLevel };

/// A named place of the body.
struct Landmark {
  std::string id;          ///< Stable: "pronasale", "tragion_left", "waist_level". left and right are the subject's.
  std::string term;        ///< The field's English term: "Pronasale", "Natural waist level".
  std::string definition;  ///< How it is defined on a ring scan, in one sentence.
  LandmarkKind kind = LandmarkKind::kPoint;
  LandmarkSource source = LandmarkSource::kDetected;
  double confidence = 0.0;                             ///< 0 … 1: how clearly the feature showed.
  Estimate theta;                                      ///< rad; of a point only.
  Estimate z;                                          ///< mm
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< Station frame, mm; on a level's height on the ring's axis.
  /// sd of placing beyond what the gradients say, along the surface, mm: how well the rule finds what a person would
  /// call the landmark on the scanned shape, or how well it was set by hand.
  double placing_across = 0.0;  ///< Horizontally; of a point only.
  double placing_up = 0.0;      ///< Vertically.
};

/// Landmarks in the order in which they are listed, and what was not found.
struct Landmarks {
  std::vector<Landmark> found;
  std::vector<std::string> omitted;  ///< One sentence each.
  double front = kPi / 2.0;          ///< rad: the direction in which the subject stands, as the trunk or the eyes say.

  /// Null if it was not found.
  [[nodiscard]] const Landmark* Find(std::string_view id) const;
};

}  // namespace annulus
