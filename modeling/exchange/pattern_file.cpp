#include "modeling/exchange/pattern_file.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"

namespace annulus {

const Measurement* FindMeasurement(const MeasurementTable& table, std::string_view id) {
  const auto found = std::find_if(table.measurements.begin(), table.measurements.end(),
                                  [id](const Measurement& m) { return m.id == id && std::isfinite(m.value.value); });
  return found == table.measurements.end() ? nullptr : &*found;
}

std::optional<RecipeValue> Follow(const MeasurementRecipe& recipe, const MeasurementTable& table) {
  RecipeValue sum;
  for (const MeasurementTerm& term : recipe.terms) {
    if (term.id.empty()) continue;
    const Measurement* source = FindMeasurement(table, term.id);
    if (source == nullptr) return std::nullopt;
    ENSURE(sum.sources.empty() || sum.sources.front()->unit == source->unit, "terms of a sum have one unit");
    sum.value += term.factor * source->value.value;
    sum.sources.push_back(source);
  }
  return sum;
}

std::string MissingSentence(const MeasurementRecipe& recipe) {
  std::string text = std::string(recipe.name) + ": needs " + std::string(recipe.terms[0].id);
  if (!recipe.terms[1].id.empty()) text += " and " + std::string(recipe.terms[1].id);
  return text + ", not all of it measured here.";
}

}  // namespace annulus
