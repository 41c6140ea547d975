#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/measure/section.h"
#include "modeling/table/table.h"
#include "sim/parametric_body.h"

namespace annulus {

/// What a comparison is about.
enum class ComparisonGroup {
  kFoundLevel,  ///< Measured at a level that the program found, against the truth at the true level.
  kTrueLevel,   ///< Both at the true level: the surface alone is judged.
  kVolume,
};
[[nodiscard]] const char* ComparisonGroupName(ComparisonGroup group);

/// One number that was measured on a simulated subject, and its true value.
struct TruthComparison {
  ComparisonGroup group = ComparisonGroup::kFoundLevel;
  std::string term;
  std::string unit;  ///< "mm", "cm²", "dm³": of the three numbers.
  double measured = 0.0;
  double half95 = 0.0;  ///< Half width of the 95 % interval; NaN where it is not known.
  double truth = 0.0;
  bool girth = false;  ///< A girth taken as a tape does.
};

/// Everything in a measurement table whose truth is known, sections at the true levels, and a volume: from hip to
/// just below the armpits on a whole body, from neck to brow on a head. Levels that were not found are left out.
/// Fails if a section or the slab cannot be measured.
Result<std::vector<TruthComparison>> CompareWithTruth(const MeasuredSurface& surface, const MeasurementTable& table,
                                                      const sim::ParametricBody& truth);

/// The largest |measured − true| of the girths, mm; 0 without any.
[[nodiscard]] double LargestGirthError(const std::vector<TruthComparison>& comparisons);
/// The largest |measured / true − 1| of the volumes.
[[nodiscard]] double LargestVolumeError(const std::vector<TruthComparison>& comparisons);

/// The true outline of the torso or head at height z, station frame, mm.
[[nodiscard]] std::vector<Eigen::Vector2d> TrueOutline(const sim::ParametricBody& truth, double z);

/// `measured` with its distance from `truth` along the ray from the ring's axis multiplied by `factor`, so that small
/// differences can be seen. Both are outlines around the axis, mm.
[[nodiscard]] std::vector<Eigen::Vector2d> Exaggerated(const std::vector<Eigen::Vector2d>& measured,
                                                       const std::vector<Eigen::Vector2d>& truth, double factor);

}  // namespace annulus
