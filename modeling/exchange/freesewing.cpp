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
    MeasurementRecipe{"chest", {{{"bust_girth"}, {}}}, "chest_girth"},
    MeasurementRecipe{"bustFront", {{{"bust_front_arc"}, {}}}, "chest_front_arc"},
    MeasurementRecipe{"bustSpan", {{{"bust_point_to_bust_point"}, {}}}},
    MeasurementRecipe{"underbust", {{{"under_bust_girth"}, {}}}},
    MeasurementRecipe{"waist", {{{"waist_girth"}, {}}}},
    MeasurementRecipe{"waistBack", {{{"waist_back_arc"}, {}}}},
    MeasurementRecipe{"hips", {{{"top_hip_girth"}, {}}}},
    MeasurementRecipe{"seat", {{{"hip_girth"}, {}}}},
    MeasurementRecipe{"seatBack", {{{"hip_back_arc"}, {}}}},
    MeasurementRecipe{"shoulderToShoulder", {{{"shoulder_breadth"}, {}}}},
    MeasurementRecipe{"shoulderSlope", {{{"shoulder_slope_left", 0.5}, {"shoulder_slope_right", 0.5}}}},
    MeasurementRecipe{"waistToHips", {{{"waist_height"}, {"top_hip_height", -1.0}}}},
    MeasurementRecipe{"waistToSeat", {{{"waist_height"}, {"hip_height", -1.0}}}},
    MeasurementRecipe{"waistToFloor", {{{"waist_height"}, {}}}},
    MeasurementRecipe{"inseam", {{{"crotch_height"}, {}}}},
};

/// Names that a ring scan of the trunk cannot fill: limbs, and the high point of the shoulder under the neck's skin.
constexpr std::array<std::string_view, 20> kNever{"ankle",
                                                  "biceps",
                                                  "bustPointToUnderbust",
                                                  "crossSeam",
                                                  "crossSeamFront",
                                                  "crotchDepth",
                                                  "heel",
                                                  "highBust",
                                                  "highBustFront",
                                                  "hpsToBust",
                                                  "hpsToWaistBack",
                                                  "hpsToWaistFront",
                                                  "knee",
                                                  "shoulderToElbow",
                                                  "shoulderToWrist",
                                                  "upperLeg",
                                                  "waistToArmpit",
                                                  "waistToKnee",
                                                  "waistToUnderbust",
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
