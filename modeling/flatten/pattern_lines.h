#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/result.h"
#include "modeling/flatten/pattern.h"

namespace annulus {

/// A line of a pattern on a body, in steps of at most one element. Both pieces beside it have the same steps.
struct SampledLine {
  std::vector<Eigen::Vector2d> places;  ///< theta (rad, not wrapped) and z (mm).
  std::vector<double> shares;           ///< Of the line's length up to each place, 0 … 1.
  double length_mm = 0.0;
};

/// All lines of a pattern; places where darts begin and divisions end are steps. Fails on places that the body has not,
/// lines shorter than a hundredth of an element, and lines of over 100,000 steps.
[[nodiscard]] Result<std::vector<SampledLine>> SampleLines(const Pattern& pattern, const PatternBody& body);

}  // namespace annulus
