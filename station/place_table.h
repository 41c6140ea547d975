#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace annulus {

/// A line of a table over the surface.
struct PlaceRow {
  double theta_deg = 0.0;
  double z = 0.0;      ///< mm
  double value = 0.0;  ///< nan where the field is empty or "nan"; 0 if no column of values was asked for.
};

/// Reads a CSV table with the columns theta_deg and z_mm, and the column `value_column` unless it is "". Columns may
/// stand in any order, others are ignored, lines that begin with # too. `name` of the file is for messages; they say
/// the line.
[[nodiscard]] Result<std::vector<PlaceRow>> ParsePlaceTable(std::string_view text, const std::string& name,
                                                            std::string_view value_column);

}  // namespace annulus
