#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "base/surface_sample.h"
#include "modeling/measure/estimate.h"

namespace annulus {

/// A girth at one time.
struct GirthPoint {
  double time_s = 0.0;    ///< s
  double girth_mm = 0.0;  ///< mm; of the convex hull: what a tape reads.
};

/// How the girth at one height changes while a person breathes. "A breath" goes from one smallest girth (breathed out)
/// to the next.
struct BreathMeasures {
  double z_mm = 0.0;               ///< Height of the section, mm.
  bool breathing = false;          ///< Whether the girth rises and falls with a period, by more than chance does.
  std::size_t breaths = 0;         ///< Whole ones; 0 without breathing.
  double period_s = 0.0;           ///< Mean length of a breath, s; 0 without breathing.
  Uncertain min_mm;                ///< Of the mean breath; without breathing of the whole time.
  Uncertain mean_mm;               ///< Likewise, over time.
  Uncertain max_mm;                ///< Likewise.
  Uncertain amplitude_mm;          ///< max - min; what is wrong with both alike is not in its sigma.
  double lowest_mm = 0.0;          ///< Of the whole time, mm.
  double highest_mm = 0.0;         ///< Of the whole time, mm.
  double measured_share = 0.0;     ///< Share of the directions in which the section was seen, 0 … 1.
  std::vector<GirthPoint> curve;   ///< The mean breath, from 0 s to period_s; empty without breathing.
  std::vector<GirthPoint> course;  ///< The whole time, every 0.1 s, from the scan's start.
};

/// Measures the girth over time from a scan whose ring stood still. One surface r(theta, t) is fitted to all returns
/// (FitBody, time taken for a height): smooth around and in time, with arms and wild returns left out; a girth at a
/// time is the tape of its section. A sway moves sections, which changes no girth. Fails with less than 3 s, if the
/// ring moved, or as FitBody and SectionAt fail.
[[nodiscard]] Result<BreathMeasures> MeasureBreath(std::span<const SurfaceSample> samples, const TaskContext& context);

}  // namespace annulus
