#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "base/storage.h"
#include "station/config.h"
#include "station/scan_job.h"
#include "tests/support/folders.h"

namespace annulus::test {

/// A recording of 100 mm of somebody's waist, from the simulated booth; the same for all tests.
inline const std::vector<std::byte>& BeltRecording() {
  static const std::vector<std::byte> bytes = [] {
    Config config = SimulatedConfig();
    ProfileConfig belt;
    belt.z_top_mm = 1100.0;
    belt.z_bottom_mm = 1000.0;
    belt.pitch_mm = 5.0;
    belt.speed_mm_s = 100.0;
    config.profiles["belt"] = belt;
    PosixStorage storage;
    const std::string path = BinaryFolder() + "/console-routes-belt.mcap";
    const auto outcome = RunScanJob(config, {"belt", path, "p-1", "c-1"}, storage, {});
    EXPECT_TRUE(outcome) << outcome.error().Text();
    return storage.ReadAll(path, kMaxInputBytes).value();
  }();
  return bytes;
}

}  // namespace annulus::test
