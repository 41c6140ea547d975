#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "station/store/store.h"

namespace annulus {

/// What was found when everything in a store was opened.
struct StoreCheck {
  std::uint64_t customers = 0;
  std::uint64_t scans = 0;
  std::uint64_t recordings = 0;  ///< Read whole.
  std::uint64_t artefacts = 0;   ///< Read whole.
  std::uint64_t audit_lines = 0;
  std::string last_audit_hash;        ///< Empty if the chain is broken.
  std::vector<std::string> problems;  ///< One line each, by ids.
};

/// Opens every row, reads every file, follows the audit's chain. Takes as long as the disk needs to read all.
[[nodiscard]] StoreCheck CheckStore(Store& store);

}  // namespace annulus
