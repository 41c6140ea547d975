#include "modeling/exchange/smis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/markup_text.h"

namespace annulus {
namespace {

/// Names that Valentina 0.7.52 of Debian 12 knows. Each was looked up in the list built into its program, with the
/// description there, and a test lets that program read all of them: it refuses a file with a name it does not know.
/// Our levels are horizontal, so that a level's height is the same at front, side and back; what these programs have
/// once for both sides of the body is the mean of ours. Our across_chest and across_back are arcs of the armpits' level
/// up to the sides: their highbust arcs, not their across_chest_f and across_back_b, which end at the armscyes.
constexpr std::array kRecipes{
    MeasurementRecipe{"height", {{{"vertex_height"}, {}}}},
    MeasurementRecipe{"height_neck_back", {{{"cervicale_height"}, {}}}},
    MeasurementRecipe{"height_neck_front", {{{"front_neck_height"}, {}}}},
    MeasurementRecipe{"height_neck_side", {{{"side_neck_height_right", 0.5}, {"side_neck_height_left", 0.5}}}},
    MeasurementRecipe{"height_shoulder_tip", {{{"shoulder_height_right", 0.5}, {"shoulder_height_left", 0.5}}}},
    MeasurementRecipe{"height_armpit", {{{"axilla_height"}, {}}}},
    MeasurementRecipe{"height_bustpoint", {{{"bust_point_height"}, {}}}},
    MeasurementRecipe{"height_waist_front", {{{"waist_height"}, {}}}},
    MeasurementRecipe{"height_waist_side", {{{"waist_height"}, {}}}},
    MeasurementRecipe{"height_waist_back", {{{"waist_height"}, {}}}},
    MeasurementRecipe{"height_highhip", {{{"top_hip_height"}, {}}}},
    MeasurementRecipe{"height_hip", {{{"hip_height"}, {}}}},
    MeasurementRecipe{"leg_crotch_to_floor", {{{"crotch_height"}, {}}}},
    MeasurementRecipe{"height_neck_back_to_waist_side", {{{"cervicale_to_waist_drop"}, {}}}},
    MeasurementRecipe{"width_shoulder", {{{"shoulder_breadth"}, {}}}},
    MeasurementRecipe{"width_bust", {{{"chest_breadth"}, {}}}},
    MeasurementRecipe{"width_waist", {{{"waist_breadth"}, {}}}},
    MeasurementRecipe{"width_hip", {{{"hip_breadth"}, {}}}},
    MeasurementRecipe{"head_circ", {{{"head_girth"}, {}}}},
    MeasurementRecipe{"head_depth", {{{"head_length"}, {}}}},
    MeasurementRecipe{"head_width", {{{"head_breadth"}, {}}}},
    MeasurementRecipe{"neck_mid_circ", {{{"neck_girth"}, {}}}},
    MeasurementRecipe{"neck_circ", {{{"neck_base_girth"}, {}}}},
    MeasurementRecipe{"highbust_circ", {{{"axilla_girth"}, {}}}},
    MeasurementRecipe{"bust_circ", {{{"chest_girth"}, {}}}},
    MeasurementRecipe{"lowbust_circ", {{{"under_bust_girth"}, {}}}},
    MeasurementRecipe{"waist_circ", {{{"waist_girth"}, {}}}},
    MeasurementRecipe{"highhip_circ", {{{"top_hip_girth"}, {}}}},
    MeasurementRecipe{"hip_circ", {{{"hip_girth"}, {}}}},
    MeasurementRecipe{"highbust_arc_f", {{{"across_chest"}, {}}}},
    MeasurementRecipe{"highbust_arc_b", {{{"across_back"}, {}}}},
    MeasurementRecipe{"bust_arc_f", {{{"chest_front_arc"}, {}}}},
    MeasurementRecipe{"bust_arc_b", {{{"chest_back_arc"}, {}}}},
    MeasurementRecipe{"waist_arc_f", {{{"waist_front_arc"}, {}}}},
    MeasurementRecipe{"waist_arc_b", {{{"waist_back_arc"}, {}}}},
    MeasurementRecipe{"hip_arc_f", {{{"hip_front_arc"}, {}}}},
    MeasurementRecipe{"hip_arc_b", {{{"hip_back_arc"}, {}}}},
    MeasurementRecipe{"bustpoint_to_bustpoint", {{{"bust_point_to_bust_point"}, {}}}},
    MeasurementRecipe{"shoulder_length", {{{"shoulder_length_right", 0.5}, {"shoulder_length_left", 0.5}}}},
    MeasurementRecipe{"neck_front_to_waist_f", {{{"neck_to_waist_front_tape"}, {}}}},
    MeasurementRecipe{"neck_front_to_waist_flat_f", {{{"neck_to_waist_front"}, {}}}},
    MeasurementRecipe{"neck_back_to_waist_b", {{{"neck_to_waist_back_tape"}, {}}}},
    MeasurementRecipe{"neck_back_to_highbust_b", {{{"scye_depth_tape"}, {}}}},
    MeasurementRecipe{"armpit_to_waist_side", {{{"side_seam_upper_tape"}, {}}}},
    MeasurementRecipe{"waist_to_highhip_side", {{{"waist_to_top_hip_tape"}, {}}}},
    MeasurementRecipe{"waist_to_hip_f", {{{"waist_to_hip_front_tape"}, {}}}},
    MeasurementRecipe{"waist_to_hip_b", {{{"waist_to_hip_back_tape"}, {}}}},
    MeasurementRecipe{"waist_to_hip_side", {{{"waist_to_hip_right_tape", 0.5}, {"waist_to_hip_left_tape", 0.5}}}},
};

constexpr std::string_view kCustomPrefix = "@annulus_";

std::string Description(const Measurement& m) {
  const std::string sd =
      std::isfinite(m.value.sigma) ? fmt::format("± {:.2f} mm (1 sd)", m.value.sigma) : std::string("sd not known");
  return fmt::format("{} {}", m.definition, sd);
}

std::string Entry(std::string_view name, double value_mm, const Measurement& m) {
  return fmt::format("        <m name=\"{}\" value=\"{:.2f}\" full_name=\"{}\" description=\"{}\"/>\n",
                     MarkupText(name), value_mm, MarkupText(m.term), MarkupText(Description(m)));
}

/// What precedes the measurements. Both programs write 998 for "no pattern making system", and a birth date of 1800
/// for an unknown one.
std::string Head(SewingDialect dialect, const std::vector<std::string>& left_out) {
  const bool seamly = dialect == SewingDialect::kSeamly;
  std::string notes;
  for (const std::string& sentence : left_out) notes += (notes.empty() ? "Left out: " : " ") + sentence;
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<{}>\n    <version>{}</version>\n    <read-only>false</read-only>\n"
      "    <notes>{}</notes>\n    <unit>mm</unit>\n    <pm_system>998</pm_system>\n    <personal>\n"
      "        <family-name/>\n        <given-name/>\n        <birth-date>1800-01-01</birth-date>\n"
      "        <gender>unknown</gender>\n        <email/>\n    </personal>\n    <body-measurements>\n",
      seamly ? "smis" : "vit", seamly ? "0.3.4" : "0.3.3", MarkupText(notes));
}

}  // namespace

PatternFile MeasurementsToSmis(const MeasurementTable& table, SewingDialect dialect) {
  PatternFile file;
  std::string entries;
  std::set<std::string_view> named;
  for (const MeasurementRecipe& recipe : kRecipes) {
    const auto value = Follow(recipe, table);
    if (!value) {
      file.left_out.push_back(MissingSentence(recipe));
      continue;
    }
    entries += Entry(recipe.name, value->value, *value->sources.front());
    if (value->sources.size() == 1) named.insert(value->sources.front()->id);
  }
  for (const Measurement& m : table.measurements) {
    if (named.contains(m.id)) continue;
    if (m.unit != "mm" || !std::isfinite(m.value.value)) {
      file.left_out.push_back(m.id + ": not a length.");
      continue;
    }
    entries += Entry(std::string(kCustomPrefix) + m.id, m.value.value, m);
  }
  file.text = Head(dialect, file.left_out) + entries + "    </body-measurements>\n</" +
              (dialect == SewingDialect::kSeamly ? "smis" : "vit") + ">\n";
  return file;
}

}  // namespace annulus
