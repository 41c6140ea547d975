#pragma once

#include <malloc.h>

#include <fstream>
#include <string>

namespace annulus::bench {

/// Gives free memory back and makes the process' peak of resident memory its present size (Linux,
/// /proc/self/clear_refs).
inline void ResetPeakMemory() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << 5;
}

/// Largest resident memory since the last reset, bytes; 0 where the system does not tell.
inline double PeakMemory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0.0;
    if (word == "VmHWM:" && status >> kilobytes) return 1024.0 * kilobytes;
  }
  return 0.0;
}

}  // namespace annulus::bench
