#pragma once

#include <span>

#include "modeling/table/measurement_list.h"

namespace annulus {

// The groups of the measurement table (docs/measurements.md), in its order. Each adds what the landmarks allow, and a
// sentence for what cannot be measured although its landmarks were found.

void AddLevels(MeasurementList& list);    ///< Girths, extents and arcs of horizontal sections, tilted neck base.
void AddHeights(MeasurementList& list);   ///< Over the floor, and between levels.
void AddLines(MeasurementList& list);     ///< Along the skin of front, back and sides; shoulders, bust points.
void AddHead(MeasurementList& list);      ///< Head and face.
void AddSegments(MeasurementList& list);  ///< Volumes and skin areas between levels.

/// A straight distance of two landmarks.
struct DistanceRow {
  const char* a;
  const char* b;
  const char* id;
  const char* term;
  double limit;
};
/// Adds those of which both landmarks were found.
void AddDistances(MeasurementList& list, std::span<const DistanceRow> rows);

// Class limits of ISO 20685-1, mm.
inline constexpr double kLargeGirthLimit = 9.0;
inline constexpr double kSmallGirthLimit = 4.0;
inline constexpr double kHeightLimit = 4.0;
inline constexpr double kBreadthLimit = 4.0;
inline constexpr double kDepthLimit = 5.0;
inline constexpr double kSegmentLengthLimit = 5.0;
inline constexpr double kHeadOverHairLimit = 2.0;
inline constexpr double kFaceLimit = 1.0;

}  // namespace annulus
