#pragma once

#include <string>

#include "modeling/table/table.h"

namespace annulus::test {

/// A measurement with an sd of 0.25 of its unit, for tests of file formats.
inline Measurement Measured(const std::string& id, double value, const std::string& unit = "mm") {
  Measurement m;
  m.id = id;
  m.term = "Term of " + id;
  m.definition = "Definition of " + id + ".";
  m.unit = unit;
  m.value = {value, 0.25};
  m.measured_share = 1.0;
  return m;
}

}  // namespace annulus::test
