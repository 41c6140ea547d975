#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "fitting/surface_model.h"
#include "modeling/measure/measured_surface.h"
#include "modeling/measure/section.h"

namespace annulus {

/// Why a section is not one loop that the ring saw from all sides, in words; empty if it is.
[[nodiscard]] std::string WhyNotOneLoop(const SurfaceModel& model, const SectionMeasures& section);

/// A level section with the keys of DESIGN.md §3 and taut_tape_mm, taut_tape_sigma_mm, one_visible_loop,
/// why_not_one_loop. `taut`: the shortest tape round it, mm; nan where there is none.
[[nodiscard]] nlohmann::ordered_json SectionToJson(const SurfaceModel& model, const SectionMeasures& section,
                                                   const Uncertain& taut);

}  // namespace annulus
