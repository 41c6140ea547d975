#include "station/look_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/folders.h"

namespace annulus {
namespace {

std::string Refusal(const std::string& body) {
  const auto look = LookFromJson(R"({"format": "annulus-look", "version": 1)" + body + "}", "LOOK.json");
  return look ? std::string() : look.error().Text();
}

Look Unusual() {
  Look look;
  look.upper.colour = LinearFromHex(0xc47a22);
  look.upper.finish = Finish::kTranslucent;
  look.upper.texture = {TexturePattern::kTortoiseshell, LinearRgb(0.0123F, 0.3F, 1.0F / 3.0F), 0.7F, 4294967295U};
  look.lower.colour = LinearRgb(0.9F, 0.1F, 0.123456F);
  look.lower.finish = Finish::kBrushed;
  look.lens = {LinearFromHex(0x3060c0), 0.125, 0.9, LensCoating::kMirror, LinearRgb(0.4F, 0.5F, 0.6F), -4.25};
  look.skin = LinearFromHex(0x8d5a3c);
  look.make_up.lips = {LinearFromHex(0x9c1f2e), 0.8};
  look.make_up.brows = {LinearFromHex(0x2a1a10), 1.0 / 3.0};
  return look;
}

TEST(LookFile, ComesBackToTheByte) {
  for (const Look& look : {Look{}, Unusual()}) {
    const std::string written = LookToJson(look);
    const auto read = LookFromJson(written, "written");
    ASSERT_TRUE(read.has_value()) << read.error().Text();
    EXPECT_EQ(LookToJson(*read), written);
  }
}

TEST(LookFile, ComesBackToTheBit) {
  const Look look = Unusual();
  const auto read = LookFromJson(LookToJson(look), "written");
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->upper.texture.second, look.upper.texture.second);
  EXPECT_EQ(read->upper.texture.scale, look.upper.texture.scale);
  EXPECT_EQ(read->upper.texture.seed, look.upper.texture.seed);
  EXPECT_EQ(read->lower.colour, look.lower.colour);
  EXPECT_EQ(read->lower.finish, look.lower.finish);
  EXPECT_EQ(read->lens.mirror, look.lens.mirror);
  EXPECT_EQ(read->lens.power, look.lens.power);
  EXPECT_EQ(read->make_up.brows.strength, look.make_up.brows.strength);
  EXPECT_EQ(read->skin, look.skin);
}

TEST(LookFile, WhatIsLeftOutHasItsDefault) {
  const auto look = LookFromJson(R"({"format": "annulus-look", "version": 1,
    "upper": {"colour": "sample:green,brighter:0.1", "material": "metal"}, "lens": {"transmittance": 0.2}})",
                                 "short");
  ASSERT_TRUE(look.has_value()) << look.error().Text();
  EXPECT_EQ(look->lower.finish, Finish::kMetal) << "as the upper part";
  EXPECT_EQ(look->lower.colour, look->upper.colour);
  EXPECT_EQ(look->lens.lower_transmittance, 0.2) << "no gradient";
  EXPECT_EQ(look->lens.tint, LensLook{}.tint);
  EXPECT_EQ(look->skin, Look{}.skin);
  EXPECT_EQ(look->make_up.lips.strength, 0.0);
}

TEST(LookFile, NamesThePlaceOfWhatItRefuses) {
  EXPECT_NE(Refusal(R"(, "uper": {})").find("there is no key 'uper'"), std::string::npos);
  EXPECT_NE(Refusal(R"(, "upper": {"texture": {"size": 1}})").find("'upper.texture.size'"), std::string::npos);
  EXPECT_NE(Refusal(R"(, "upper": {"texture": {"scale": 11}})").find("'upper.texture.scale' is 11, not 0.1 … 10"),
            std::string::npos);
  EXPECT_NE(Refusal(R"(, "upper": {"texture": {"seed": 1.5}})").find("'upper.texture.seed' is 1.5, no whole number"),
            std::string::npos);
  EXPECT_NE(Refusal(R"(, "upper": {"texture": {"pattern": "zebra"}})").find("not one of plain, tortoiseshell, horn"),
            std::string::npos);
  EXPECT_NE(Refusal(R"(, "lower": {"material": "skin"})").find("'lower.material' is 'skin', not one of plastic"),
            std::string::npos);
  EXPECT_NE(Refusal(R"(, "lower": {"material": 3})").find("'lower.material' is missing or no text"), std::string::npos);
  EXPECT_NE(Refusal(R"(, "lens": {"power_d": -31})").find("'lens.power_d' is -31, not -30 … 30"), std::string::npos);
  EXPECT_NE(Refusal(R"(, "lens": {"tint": "sky"})").find("'lens.tint': 'sky' is no colour"), std::string::npos);
  EXPECT_NE(Refusal(R"(, "lens": [])").find("'lens'"), std::string::npos);
  EXPECT_NE(Refusal(R"(, "make_up": {"lips": {"strength": 2}})").find("'make_up.lips.strength' is 2"),
            std::string::npos);
  EXPECT_NE(Refusal(R"(, "make_up": {"eyes": {}})").find("'make_up.eyes'"), std::string::npos);
  EXPECT_NE(Refusal(R"(, "skin": null)").find("'skin' is missing or no text"), std::string::npos);
}

TEST(LookFile, TheExamplesOfTheDocumentationCanBeRead) {
  for (const char* name : {"example1-2", "example3", "example4", "example5", "example6", "make-up"}) {
    std::ifstream file(test::SourceFolder() + "/docs/examples/rendering/" + name + ".json");
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    const auto look = LookFromJson(text, name);
    EXPECT_TRUE(look.has_value()) << (look ? "" : look.error().Text());
  }
}

TEST(LookFile, RefusesWhatIsNoLook) {
  EXPECT_FALSE(LookFromJson("", "empty").has_value());
  EXPECT_FALSE(LookFromJson("[]", "list").has_value());
  EXPECT_FALSE(LookFromJson(R"({"version": 1})", "no format").has_value());
  EXPECT_FALSE(LookFromJson(R"({"format": "annulus-look", "version": 2})", "newer").has_value());
  EXPECT_FALSE(LookFromJson(R"({"format": "annulus-look", "version": 1, "skin": "#fff", "skin": "#ffffff"})", "twice")
                   .has_value());
}

}  // namespace
}  // namespace annulus
