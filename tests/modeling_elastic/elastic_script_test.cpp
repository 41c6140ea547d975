#include "modeling/elastic/elastic_script.h"

#include <gtest/gtest.h>

#include <string>

#include "base/storage.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

TEST(ElasticScript, IsReadWithItsUnits) {
  const auto script = ElasticScriptFromJson(R"({
    "material": {"young_kpa": 15, "poisson": 0.45}, "method": "linear",
    "region": {"theta_from_deg": 30, "theta_to_deg": 150, "z_min_mm": 1100, "z_max_mm": 1300, "thickness_mm": 25,
               "spacing_mm": 6, "layers": 3},
    "edits": [{"theta_deg": 90, "z_mm": 1200, "outward_mm": 5, "radius_mm": 40}],
    "loads": [{"theta_deg": 60, "z_mm": 1200, "radius_mm": 30, "as": "force", "force_n": -2},
              {"theta_deg": 120, "z_mm": 1200, "radius_mm": 30, "outward_mm": 4}],
    "bands": [{"z_mm": 1150, "normal": [0, 1, 2], "width_mm": 30, "girth_mm": 800},
              {"z_mm": 1250, "rest_length_mm": 750, "stiffness_n": 40}],
    "girths_mm": [1150, 1250]})",
                                            "ops.json");
  ASSERT_TRUE(script) << script.error().Text();
  EXPECT_DOUBLE_EQ(script->material.young, 0.015);
  EXPECT_EQ(script->method, ElasticMethod::kLinear);
  EXPECT_DOUBLE_EQ(script->region->theta_to, 150.0 / 180.0 * 3.14159265358979323846);
  EXPECT_EQ(script->region->layers, 4U);
  EXPECT_DOUBLE_EQ(script->edits.at(0).outward, 5.0);
  EXPECT_EQ(script->loads.at(0).as, BumpLoad::As::kForce);
  EXPECT_EQ(script->loads.at(1).as, BumpLoad::As::kDisplacement);
  EXPECT_NEAR(script->bands.at(0).normal.norm(), 1.0, 1e-15);
  EXPECT_EQ(script->bands.at(0).girth, 800.0);
  EXPECT_FALSE(script->bands.at(1).girth);
  EXPECT_EQ(script->girths.size(), 2U);
}

TEST(ElasticScript, NamesWhatIsWrong) {
  const auto seen = [](const char* text) {
    const auto script = ElasticScriptFromJson(text, "ops.json");
    return script ? std::string("nothing") : script.error().Text();
  };
  EXPECT_NE(seen(R"({"edit": []})").find("edit"), std::string::npos);
  EXPECT_NE(seen(R"({"edits": [{"theta_deg": 90, "z_mm": 1, "outward_mm": 5}]})").find("'edits[0].radius_mm'"),
            std::string::npos);
  EXPECT_NE(seen(R"({"edits": [{"theta_deg": 90, "z_mm": 1, "outward_mm": 5, "radius_mm": 0}]})").find("radius_mm"),
            std::string::npos);
  EXPECT_NE(seen(R"({"material": {"poisson": 0.5}})").find("poisson"), std::string::npos);
  EXPECT_NE(seen(R"({"bands": [{"z_mm": 1, "girth_mm": 800}]})").find("'region' is missing"), std::string::npos);
  EXPECT_NE(seen(R"({"region": {"z_min_mm": 1, "z_max_mm": 2},
                     "bands": [{"z_mm": 1, "girth_mm": 800, "stiffness_n": 4}]})")
                .find("girth_mm"),
            std::string::npos);
  EXPECT_NE(seen("[]"), "nothing");
  EXPECT_NE(seen("{"), "nothing");
}

TEST(ElasticScript, TheExamplesOfTheDocumentsAreRead) {
  PosixStorage storage;
  for (const char* name : {"bust.json", "waistband.json"}) {
    const auto text = ReadTextFile(storage, test::SourceFolder() + "/docs/examples/elastic/" + name);
    ASSERT_TRUE(text) << text.error().Text();
    const auto script = ElasticScriptFromJson(*text, name);
    ASSERT_TRUE(script) << script.error().Text();
    EXPECT_TRUE(script->region);
  }
}

}  // namespace
}  // namespace annulus
