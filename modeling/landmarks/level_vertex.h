#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "modeling/measure/estimate.h"
#include "modeling/measure/section_sampler.h"

namespace annulus {

/// A length that a section has, as a function of its height.
struct HeightFunction {
  /// At height z, mm.
  std::function<double(double z)> value;
  /// Adds weight · (its derivatives with respect to the coefficients) at height z.
  std::function<void(double z, double weight, GradientSum& sum)> add_gradient;
};

/// Length of the convex hull of the section's points at fixed directions, mm. Shares nothing with the caller but the
/// surface.
[[nodiscard]] HeightFunction TapeOver(const SectionSampler& sampler);

/// How far the section reaches along the horizontal direction at angle `toward`, rad, mm: its outline as seen from the
/// side. Only the sampler's directions within `half_sector`, rad, of `toward` count; at least one must.
[[nodiscard]] HeightFunction ReachOver(const SectionSampler& sampler, double toward, double half_sector);

/// The sum of two functions.
[[nodiscard]] HeightFunction SumOf(const HeightFunction& a, const HeightFunction& b);

/// The slope over heights z ± half, mm/mm, of the straight line fitted to the function by least squares.
[[nodiscard]] HeightFunction SlopeOf(const HeightFunction& function, double half);

/// The slope at z of the cubic fitted to the function by least squares over heights z ± half, mm/mm.
[[nodiscard]] HeightFunction TangentOf(const HeightFunction& function, double half);

/// The second derivative over heights z ± half, 1/mm, of the parabola fitted to the function by least squares.
[[nodiscard]] HeightFunction BendOf(const HeightFunction& function, double half);

/// Where a function goes through a value.
enum class Crossing { kRising, kFalling, kEither };

/// What is sought along the height. Heights between which it is looked for must keep clear of the surface's ends by
/// what SlopeOf and BendOf reach out.
struct LevelQuery {
  double from = 0.0;  ///< mm; where the search begins.
  double to = 0.0;    ///< mm; where it ends; may lie below.
  double value = 0.0;
  Crossing crossing = Crossing::kEither;  ///< With rising z, whatever the direction of the search.
};

/// The first height from query.from to query.to at which the function goes through query.value, to 1e-9 mm, with its
/// gradient by implicit differentiation. Looks every 2.5 mm. Null if there is none.
[[nodiscard]] std::optional<Estimate> FindCrossing(const SplineSurface& surface, const HeightFunction& function,
                                                   const LevelQuery& query);

/// Which extremum.
enum class Extremum { kLargest, kSmallest };

/// The extremum of a function nearest to `start`, mm: where the cubic fitted by least squares over z ± half is level at
/// the middle of its own window. (A parabola's vertex is drawn towards the flatter side.) Looked for within 2·half of
/// the start. Null if there is none, or if its window would leave the surface.
[[nodiscard]] std::optional<Estimate> FindLevelVertex(const SplineSurface& surface, const HeightFunction& function,
                                                      double start, double half, Extremum which);

}  // namespace annulus
