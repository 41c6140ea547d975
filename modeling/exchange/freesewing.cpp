#include "modeling/exchange/freesewing.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace annulus {
namespace {

/// FreeSewing's names and how its documentation defines them: neck where a shirt's collar sits, hips at the top of the
/// hip bones, seat at the fullest part; waistToSeat and waistToFloor vertically, at the side; shoulderSlope one angle
/// for both shoulders.
constexpr std::array kRecipes{
    MeasurementRecipe{"head", {{{"head_girth"}, {}}}},
    MeasurementRecipe{"neck", {{{"neck_girth"}, {}}}},
    MeasurementRecipe{"highBust", {{{"axilla_girth"}, {}}}},
    MeasurementRecipe{"highBustFront", {{{"across_chest"}, {}}}},
    MeasurementRecipe{"chest", {{{"chest_girth"}, {}}}},
    MeasurementRecipe{"bustFront", {{{"chest_front_arc"}, {}}}},
    MeasurementRecipe{"bustSpan", {{{"bust_point_to_bust_point"}, {}}}},
    MeasurementRecipe{"underbust", {{{"under_bust_girth"}, {}}}},
    MeasurementRecipe{"waist", {{{"waist_girth"}, {}}}},
    MeasurementRecipe{"waistBack", {{{"waist_back_arc"}, {}}}},
    MeasurementRecipe{"hips", {{{"top_hip_girth"}, {}}}},
    MeasurementRecipe{"seat", {{{"hip_girth"}, {}}}},
    MeasurementRecipe{"seatBack", {{{"hip_back_arc"}, {}}}},
    MeasurementRecipe{"shoulderSlope", {{{"shoulder_slope_left", 0.5}, {"shoulder_slope_right", 0.5}}}},
    MeasurementRecipe{"waistToHips", {{{"waist_height"}, {"top_hip_height", -1.0}}}},
    MeasurementRecipe{"waistToSeat", {{{"waist_to_hip_drop"}, {}}}},
    MeasurementRecipe{"waistToArmpit", {{{"side_seam_upper_tape"}, {}}}},
    MeasurementRecipe{"waistToFloor", {{{"waist_height"}, {}}}},
    MeasurementRecipe{"inseam", {{{"crotch_height"}, {}}}},
};

/// Names that the table has nothing for: limbs, the high point of the shoulder, and widths over the back.
constexpr std::array<std::string_view, 19> kNever{"ankle",
                                                  "biceps",
                                                  "bustPointToUnderbust",
                                                  "crossSeam",
                                                  "crossSeamFront",
                                                  "crotchDepth",
                                                  "heel",
                                                  "hpsToBust",
                                                  "hpsToWaistBack",
                                                  "hpsToWaistFront",
                                                  "knee",
                                                  "shoulderToElbow",
                                                  "shoulderToShoulder",
                                                  "shoulderToWrist",
                                                  "upperLeg",
                                                  "waistToKnee",
                                                  "waistToUnderbust",
                                                  "waistToUpperLeg",
                                                  "wrist"};

}  // namespace

PatternFile MeasurementsToFreeSewing(const MeasurementTable& table) {
  PatternFile file;
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const MeasurementRecipe& recipe : kRecipes) {
    if (const auto value = Follow(recipe, table)) {
      json[std::string(recipe.name)] = std::round(100.0 * value->value) / 100.0;
    } else {
      file.left_out.push_back(MissingSentence(recipe));
    }
  }
  for (const std::string_view name : kNever) file.left_out.push_back(std::string(name) + ": not measured.");
  file.text = json.dump(1) + "\n";
  return file;
}

}  // namespace annulus
