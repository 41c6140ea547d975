/// Colours of the frame's textures at some places, against stored ones. The page's shader (solid_texture.glsl) is held
/// against the same file in a browser (tests/browser/designer_test.mjs), so that preview and true picture agree.
///
/// Where a change is meant to move them, store them again from the repository's folder with
///   ANNULUS_UPDATE_GOLDEN=1 build/release/golden_test
/// and change the shader likewise.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "render/texture.h"
#include "station/look_words.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTolerance = 2e-5;
constexpr int kPlaces = 24;

template <class Vector>
Json JsonOf(const Vector& vector) {
  return {vector[0], vector[1], vector[2]};
}

/// Over front and temples, as a frame lies in its own coordinates.
std::vector<Eigen::Vector3f> Places() {
  std::mt19937 random(17);
  // Not std::uniform_real_distribution, whose numbers are each library's own.
  const auto within = [&random](float low, float high) {
    return low + (high - low) * static_cast<float>(random() >> 8U) / 16777216.0F;
  };
  std::vector<Eigen::Vector3f> places;
  for (int k = 0; k < kPlaces; ++k) {
    const float x = within(-75.0F, 75.0F);
    const float y = within(-150.0F, 10.0F);
    places.emplace_back(x, y, within(-30.0F, 30.0F));
  }
  return places;
}

Json Computed() {
  const LinearRgb ground(0.55F, 0.19F, 0.016F);
  Json json{{"ground", JsonOf(ground)}, {"places_mm", Json::array()}, {"textures", Json::array()}};
  for (const Eigen::Vector3f& place : Places()) json["places_mm"].push_back(JsonOf(place));
  for (const auto& [word, pattern] : kPatternWords) {
    if (pattern == TexturePattern::kPlain) continue;
    for (const auto& [scale, seed] : {std::pair(1.0F, 0U), std::pair(0.5F, 7U), std::pair(2.5F, 4000000000U)}) {
      const Texture texture{pattern, LinearRgb(0.02F, 0.01F, 0.006F), scale, seed};
      Json colours = Json::array();
      for (const Eigen::Vector3f& place : Places()) colours.push_back(JsonOf(TextureColour(texture, ground, place)));
      json["textures"].push_back({{"pattern", std::string(word)},
                                  {"second", JsonOf(texture.second)},
                                  {"scale", scale},
                                  {"seed", seed},
                                  {"colours", std::move(colours)}});
    }
  }
  return json;
}

TEST(Golden, TexturesAreColouredAsTheyWere) {
  const std::string path = test::SourceFolder() + "/tests/golden/texture_colours.json";
  const Json computed = Computed();
  if (std::getenv("ANNULUS_UPDATE_GOLDEN") != nullptr) {
    std::ofstream(path) << computed.dump() << "\n";
    GTEST_SKIP() << "stored " << path;
  }
  std::ifstream file(path);
  ASSERT_TRUE(file) << path;
  const Json stored = Json::parse(file);
  ASSERT_EQ(stored.at("textures").size(), computed.at("textures").size());
  for (std::size_t t = 0; t < computed["textures"].size(); ++t) {
    const Json& wanted = stored["textures"][t];
    const Json& seen = computed["textures"][t];
    ASSERT_EQ(wanted.at("pattern"), seen.at("pattern"));
    ASSERT_EQ(wanted.at("colours").size(), seen.at("colours").size());
    for (std::size_t k = 0; k < seen["colours"].size(); ++k) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        EXPECT_NEAR(seen["colours"][k][channel].get<double>(), wanted["colours"][k][channel].get<double>(), kTolerance)
            << wanted["pattern"] << " at place " << k;
      }
    }
  }
}

}  // namespace
}  // namespace annulus
