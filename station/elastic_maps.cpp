#include "station/elastic_maps.h"

#include <algorithm>
#include <array>

namespace annulus {
namespace {

constexpr double kKilopascals = 1e3;  ///< Of one N/mm².

constexpr std::array<ElasticMap, 7> kMaps{
    {{"outward", "outward_mm", "Displacement outward", "mm", &SkinMaps::outward, 1.0, ScaleRule::kAboutZero},
     {"sideways", "sideways_mm", "Displacement sideways", "mm", &SkinMaps::sideways, 1.0, ScaleRule::kFromZero},
     {"von-mises", "von_mises_kpa", "Stress (von Mises)", "kPa", &SkinMaps::von_mises, kKilopascals,
      ScaleRule::kFromZero},
     {"largest-strain", "largest_strain_percent", "Largest strain", "%", &SkinMaps::largest_strain, 100.0,
      ScaleRule::kAboutZero},
     {"smallest-strain", "smallest_strain_percent", "Smallest strain", "%", &SkinMaps::smallest_strain, 100.0,
      ScaleRule::kAboutZero},
     {"area-strain", "area_strain_percent", "Change of area", "%", &SkinMaps::area_strain, 100.0,
      ScaleRule::kAboutZero},
     {"pressure", "pressure_kpa", "Pressure on the skin", "kPa", &SkinMaps::pressure, kKilopascals,
      ScaleRule::kFromZero}}};

}  // namespace

std::span<const ElasticMap> ElasticMaps() { return kMaps; }

const ElasticMap* FindElasticMap(std::string_view word) {
  const auto found = std::find_if(kMaps.begin(), kMaps.end(), [&](const ElasticMap& map) { return map.word == word; });
  return found == kMaps.end() ? nullptr : &*found;
}

std::string ElasticMapWords() {
  std::string words;
  for (const ElasticMap& map : kMaps) words += (words.empty() ? "" : ", ") + std::string(map.word);
  return words;
}

}  // namespace annulus
