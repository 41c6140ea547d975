#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "acquisition/scan.h"
#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// Reads a table of ranges (docs/formats.md), plain or gzip by its first bytes:
/// `level,z_mm,sensor,theta_deg,range_mm[,t_s][,sweep][,weight]` in any order, comment lines with `R_mm=…`.
/// The levels come sorted by sweep and level; rows that are missing become missing returns.
/// Every error is one line with the line number. At most kMaxInputBytes packed and unpacked.
Result<Scan> ReadCsvScan(Storage& storage, const std::string& path);

/// The same from text in memory; `name` is what messages call it.
Result<Scan> ParseCsvScan(std::string_view text, const std::string& name);

/// Writes `scan` as such a table, gzip if `path` ends in ".gz", with calibrated points (`x_cal_mm,y_cal_mm,z_cal_mm`)
/// and weights added. The comment line carries the header without the subject and consent references, so that
/// ReadCsvScan gives the same scan back (a missing return comes back with quality 0). On failure nothing is left.
Status WriteCsvScan(Storage& storage, const std::string& path, const Scan& scan);

}  // namespace annulus
