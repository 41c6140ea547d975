#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "modeling/elastic/skin_maps.h"
#include "render/value_scale.h"

namespace annulus {

/// A map of an elastic region that can be written and drawn.
struct ElasticMap {
  const char* word;  ///< As --map and --picture take it.
  const char* key;   ///< In the report.
  const char* title;
  const char* unit;
  std::vector<double> SkinMaps::*values;
  double factor;   ///< From the values' unit to `unit`.
  ScaleRule rule;  ///< Of its colours.
};

[[nodiscard]] std::span<const ElasticMap> ElasticMaps();
/// Null if there is none of this word.
[[nodiscard]] const ElasticMap* FindElasticMap(std::string_view word);
/// All words, for messages.
[[nodiscard]] std::string ElasticMapWords();

}  // namespace annulus
