#include "station/section_output.h"

#include <fmt/format.h>

#include <cstddef>
#include <nlohmann/json.hpp>

#include "station/measurement_output.h"

namespace annulus {

std::string WhyNotOneLoop(const SurfaceModel& model, const SectionMeasures& section) {
  std::string why;
  for (std::size_t k = 1; k < model.segments.size(); ++k) {
    const SurfaceSegment& other = model.segments[k];
    if (section.z < other.surface.z_min() || section.z > other.surface.z_max()) continue;
    why += (why.empty() ? "the " : ", the ") + other.name;
  }
  if (!why.empty()) return why + " is beside it";
  if (section.measured_share < 1.0) return "part of it is inferred";
  if (section.steps == 0) return "";
  return fmt::format("its outline runs along the rays in {} place{}", section.steps, section.steps == 1 ? "" : "s");
}

nlohmann::ordered_json SectionToJson(const SurfaceModel& model, const SectionMeasures& section, const Uncertain& taut) {
  const std::string not_one_loop = WhyNotOneLoop(model, section);
  return {{"z_mm", section.z},
          {"perimeter_mm", section.perimeter.value},
          {"tape_mm", section.tape.value},
          {"area_mm2", section.area.value},
          {"perimeter_sigma_mm", JsonNumber(section.perimeter.sigma)},
          {"tape_sigma_mm", JsonNumber(section.tape.sigma)},
          {"area_sigma_mm2", JsonNumber(section.area.sigma)},
          {"taut_tape_mm", JsonNumber(taut.value)},
          {"taut_tape_sigma_mm", JsonNumber(taut.sigma)},
          {"measured_share", section.measured_share},
          {"one_visible_loop", not_one_loop.empty()},
          {"why_not_one_loop", not_one_loop}};
}

}  // namespace annulus
