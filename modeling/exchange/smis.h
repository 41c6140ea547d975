#pragma once

#include "modeling/exchange/pattern_file.h"

namespace annulus {

/// The two programs that read individual measurements in one structure with different roots.
enum class SewingDialect {
  kSeamly,     ///< `.smis`, root smis, version 0.3.4 (Seamly2D).
  kValentina,  ///< `.vit`, root vit, version 0.3.3 (Valentina).
};

/// The table's lengths as individual measurements of Seamly2D or Valentina, in mm to 0.01 mm. What these programs know
/// by name has their name; every other length is a custom one, "@annulus_" and our id, with our term as full name. Each
/// carries our definition and its sd as description. Angles, areas and volumes are left out: the format has one unit of
/// length. What was left out and why is listed in the file's notes too. No person's name is written.
[[nodiscard]] PatternFile MeasurementsToSmis(const MeasurementTable& table, SewingDialect dialect);

}  // namespace annulus
