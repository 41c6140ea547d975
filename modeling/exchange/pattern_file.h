#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "modeling/table/table.h"

namespace annulus {

/// A file of measurements for a pattern program.
struct PatternFile {
  std::string text;                   ///< All of it, UTF-8.
  std::vector<std::string> left_out;  ///< What was not filled or not written, one sentence each.
};

/// A term of a sum of measurements: `id` is empty where it is not used.
struct MeasurementTerm {
  std::string_view id;
  double factor = 1.0;
};

/// How another program's measurement is made of ours: the sum of its terms, all in mm or all in degrees.
struct MeasurementRecipe {
  std::string_view name;                 ///< The other program's.
  std::array<MeasurementTerm, 2> terms;  ///< At least the first.
};

/// A number made by a recipe.
struct RecipeValue {
  double value = 0.0;  ///< mm or degrees, like its terms.
  std::vector<const Measurement*> sources;
};

/// Null if the table has no measurement `id`, or none with a finite value.
[[nodiscard]] const Measurement* FindMeasurement(const MeasurementTable& table, std::string_view id);

/// Nothing if a term is not in the table. Requires terms of one unit.
[[nodiscard]] std::optional<RecipeValue> Follow(const MeasurementRecipe& recipe, const MeasurementTable& table);

/// "bust_circ: needs chest_girth, not all of it measured here."
[[nodiscard]] std::string MissingSentence(const MeasurementRecipe& recipe);

}  // namespace annulus
