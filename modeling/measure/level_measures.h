#pragma once

#include "base/result.h"
#include "modeling/measure/measurement_list.h"
#include "modeling/measure/section.h"
#include "modeling/measure/section_sampler.h"

namespace annulus {

/// Which part of the tape around a section.
enum class ArcSide { kFront, kBack };

/// What is measured on the horizontal section at one level. Borrows body and sampler.
class LevelMeasures {
 public:
  /// Fails if the section cannot be measured (SectionAt).
  static Result<LevelMeasures> At(const MeasuredSurface& body, const SectionSampler& sampler, const Landmark& level);

  [[nodiscard]] RawMeasurement Girth() const;      ///< Tape, mm.
  [[nodiscard]] RawMeasurement Perimeter() const;  ///< Along the skin, mm.
  [[nodiscard]] RawMeasurement Area() const;       ///< mm²
  [[nodiscard]] RawMeasurement Breadth() const;    ///< Extent along x, mm.
  [[nodiscard]] RawMeasurement Depth() const;      ///< Extent along y, mm.
  /// The part of the tape before or behind the plane halfway between the section's most forward and most rearward
  /// points, mm.
  [[nodiscard]] RawMeasurement Arc(ArcSide side) const;

 private:
  LevelMeasures(const MeasuredSurface& body, const SectionSampler& sampler, const Landmark& level)
      : body_(&body), sampler_(&sampler), level_(&level) {}
  [[nodiscard]] RawMeasurement Raw(const Estimate& estimate) const;
  /// Follows the level: `value` is the same measure of the sampler's section at a height.
  template <class Value>
  void FollowLevel(RawMeasurement& raw, Value value) const;
  [[nodiscard]] RawMeasurement Extent(const Eigen::Vector2d& direction) const;

  const MeasuredSurface* body_;
  const SectionSampler* sampler_;
  const Landmark* level_;
  SectionEstimates section_;
  std::vector<Eigen::Vector2d> points_;  ///< At the sampler's directions.
  std::vector<std::size_t> hull_;        ///< Indices of points_.
};

}  // namespace annulus
