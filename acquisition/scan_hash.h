#pragma once

#include <string>

#include "acquisition/scan.h"
#include "base/sha256.h"

namespace annulus {

/// ScanHash taken level by level, while a scan is recorded. Bytes hashed, little-endian: sensor count (u32), ring
/// radius, the seven numbers of every sensor in their order in SensorCalibration, and where a calibration has more (not
/// IsPlain) quadratic terms, pose and carriage in the order of their members; then per level sweep (u16), index
/// (u32), time (i64 ns), and per reading z, range (one NaN for every missing return) and quality (u8). Only with
/// reference sensors: their number (u32) and of each theta, distance, height and aim after the ring's calibration;
/// their time (i64 ns) and readings after a level's.
class ScanHasher {
 public:
  explicit ScanHasher(const ScanHeader& header);
  void Add(const ScanLevel& level);
  /// "sha256:" + hex. Once only.
  [[nodiscard]] std::string Finish();

 private:
  Sha256 hash_;
};

}  // namespace annulus
