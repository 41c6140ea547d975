#pragma once

#include <nlohmann/json_fwd.hpp>

#include "base/result.h"
#include "station/loaded_model.h"

namespace annulus {

/// The plane of a section: it crosses the ring's axis at z.
struct SectionQuestion {
  double z_mm = 0.0;
  double tilt_deg = 0.0;  ///< Falls to the front by so much, within ± 75.
  double lean_deg = 0.0;  ///< Falls to the subject's right by so much, within ± 75.
};

/// Numbers as `annulus section --json` gives them (without the taut tape, which takes longer than a hand waits), the
/// outlines `loops` (the trunk's first, then limbs beside it, level sections only), and `tape`: where a tape lies.
/// Fails outside the scanned range, and where part was not seen.
Result<nlohmann::ordered_json> AnswerSection(const LoadedModel& loaded, const SectionQuestion& question);

}  // namespace annulus
