#pragma once

#include <cstddef>
#include <vector>

#include "base/progress.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// mm between the sections that a girth profile looks at.
inline constexpr double kGirthStep = 5.0;

/// One section of a body, known all around.
struct Girth {
  double z = 0.0;
  double tape = 0.0;     ///< mm, smoothed over 10 mm.
  double hollow = 0.0;   ///< Share by which the skin is longer than the tape.
  bool bridged = false;  ///< Not seen: between seen neighbours.
};

/// Girths from the top down, kGirthStep apart, without a gap.
using GirthRun = std::vector<Girth>;

/// All sections that are known all around, in runs from the top down; short gaps (hands before the hips, armpits) are
/// bridged in a straight line, which makes no extreme. Where an arm hides a stretch of the section, the tape spans it.
[[nodiscard]] std::vector<GirthRun> GirthRuns(const MeasuredSurface& body, const TaskContext& context);

/// The index of the section `distance` mm below the one at `from`, or the last.
[[nodiscard]] std::size_t IndexBelow(const GirthRun& run, std::size_t from, double distance);

/// The directions of `count` even ones, rad, in which every section from z - half to z + half was measured; all of them
/// where fewer than three in five were, or where a gap of a third of a turn would be left.
[[nodiscard]] std::vector<double> SeenDirections(const MeasuredSurface& body, double z, double half, std::size_t count);

}  // namespace annulus
