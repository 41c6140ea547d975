#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "base/result.h"
#include "modeling/measure/section.h"
#include "modeling/measure/section_sampler.h"
#include "modeling/measure/surface_path.h"
#include "modeling/table/measurement_list.h"

namespace annulus {

/// Which part of the tape around a section.
enum class ArcSide { kFront, kBack };

/// What is measured on the horizontal section at one level. Borrows body and sampler.
class LevelMeasures {
 public:
  /// `front`: the direction in which the subject stands, rad. Fails if the section cannot be measured (SectionAt).
  static Result<LevelMeasures> At(const MeasuredSurface& body, const SectionSampler& sampler, const Landmark& level,
                                  double front);

  [[nodiscard]] RawMeasurement Girth() const;  ///< Tape, mm.
  /// The same tape free to leave the plane (TautLoop), mm. Fails as that does.
  [[nodiscard]] Result<RawMeasurement> TautGirth() const;
  [[nodiscard]] RawMeasurement Perimeter() const;  ///< Along the skin, mm.
  [[nodiscard]] RawMeasurement Breadth() const;    ///< Extent across the front, mm.
  [[nodiscard]] RawMeasurement Depth() const;      ///< Extent along the front, mm.
  /// The part of the tape before or behind the plane halfway between the section's most forward and most rearward
  /// points, mm.
  [[nodiscard]] RawMeasurement Arc(ArcSide part) const;

  /// A point of a part of the tape: a corner of the hull, or where the edge that leaves a corner meets the plane.
  struct ArcPoint {
    Eigen::Vector2d point;
    std::size_t index = 0;  ///< Of the corner, among the sampler's directions.
    bool crossing = false;
  };

 private:
  LevelMeasures(const MeasuredSurface& body, const SectionSampler& sampler, const Landmark& level, double front)
      : body_(&body), sampler_(&sampler), level_(&level), front_(std::cos(front), std::sin(front)) {}
  [[nodiscard]] RawMeasurement Raw(const Estimate& estimate) const;
  /// Follows the level: `value` is the same measure of the sampler's section at a height.
  template <class Value>
  void FollowLevel(RawMeasurement& raw, Value value) const;
  [[nodiscard]] PathPoint OnArc(const ArcPoint& p) const;
  [[nodiscard]] RawMeasurement Extent(const Eigen::Vector2d& direction) const;

  const MeasuredSurface* body_;
  const SectionSampler* sampler_;
  const Landmark* level_;
  Eigen::Vector2d front_;  ///< Unit vector.
  SectionEstimates section_;
  std::vector<Eigen::Vector2d> points_;  ///< At the sampler's directions.
  std::vector<std::size_t> hull_;        ///< Indices of points_.
};

}  // namespace annulus
