/// The configuration reader. Beyond "no crash": messages are one line, and what is accepted is within bounds.
#include <cmath>
#include <cstdint>

#include "base/ensure.h"
#include "station/config.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace annulus;
  const auto config = ParseConfig({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
  if (!config) {
    ENSURE(config.error().Text().find('\n') == std::string::npos, "a message is one line");
    ENSURE(!config.error().seen.empty() && !config.error().advice.empty(), "a message has its parts");
    return 0;
  }
  ENSURE(std::isfinite(config->ring.radius_mm) && config->ring.radius_mm > 0.0, "a ring has a radius");
  ENSURE(std::isfinite(config->sim.noise_mm) && config->sim.noise_mm >= 0.0, "noise is a size");
  ENSURE(config->sim.dropout_rate >= 0.0 && config->sim.dropout_rate <= 1.0, "a rate is a share");
  ENSURE(config->sim.outlier_rate >= 0.0 && config->sim.outlier_rate <= 1.0, "a rate is a share");
  for (const auto& [name, profile] : config->profiles) {
    for (const auto& value : {profile.z_top_mm, profile.z_bottom_mm, profile.pitch_mm, profile.speed_mm_s}) {
      ENSURE(!value || std::isfinite(*value), "a profile's numbers are finite");
    }
  }
  return 0;
}
