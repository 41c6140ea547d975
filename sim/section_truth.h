#pragma once

#include <string>

namespace annulus::sim {

/// The true measures of one closed loop of a horizontal section.
struct SectionTruth {
  double z_mm = 0.0;          ///< Height of the section, mm.
  double perimeter_mm = 0.0;  ///< Length of the curve, mm.
  double tape_mm = 0.0;       ///< Length of its convex hull, as a tape measures, mm.
  double area_mm2 = 0.0;      ///< Enclosed area, mm².
};

/// A level that has a name in the measurement table: "head", "neck", "chest", "waist", "hip".
struct NamedLevel {
  std::string id;
  double z_mm = 0.0;
};

}  // namespace annulus::sim
