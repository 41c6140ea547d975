#include "render/colour_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/units.h"
#include "render/hvc.h"

namespace annulus {
namespace {

std::string Refusal(std::string_view text) {
  const auto colour = ParseColourChoice(text);
  return colour ? std::string() : colour.error().Text();
}

TEST(ColourChoice, ReadsEveryWayToSayOneColour) {
  const LinearRgb orange = LinearFromHex(0xff8800);
  EXPECT_EQ(*ParseColourChoice("#ff8800"), orange);
  EXPECT_TRUE(ParseColourChoice("rgb:255,136,0")->isApprox(orange, 1e-6F));
  const Hvc hvc = HvcFromRgb(orange);
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "hvc:%.9f,%.9f,%.9f", hvc.hue * 50.0 / kPi, hvc.value, hvc.chroma);
  EXPECT_TRUE(ParseColourChoice(text.data())->isApprox(orange, 1e-5F)) << text.data();
  EXPECT_TRUE(ParseColourChoice("linear:0.25,0.5,1")->isApprox(LinearRgb(0.25F, 0.5F, 1.0F)));
}

TEST(ColourChoice, SamplesHaveNamesAndNumbers) {
  ASSERT_EQ(SampleColours().size(), 8U);
  for (std::size_t k = 0; k < SampleColours().size(); ++k) {
    const LinearRgb colour = LinearFromHex(SampleColours()[k].rrggbb);
    EXPECT_EQ(*ParseColourChoice("sample:" + std::string(SampleColours()[k].name)), colour);
    EXPECT_EQ(*ParseColourChoice("sample:" + std::to_string(k + 1)), colour);
  }
}

TEST(ColourChoice, TheBarRunsOnceRoundTheHuesInEqualSteps) {
  EXPECT_EQ(ColourBar(0.0), LinearRgb(1.0F, 0.0F, 0.0F));
  EXPECT_EQ(ColourBar(1.0), LinearRgb(1.0F, 0.0F, 0.0F));
  for (int k = 1; k < 40; ++k) {
    const double step = HvcFromRgb(ColourBar(k / 40.0)).hue - HvcFromRgb(ColourBar((k - 1) / 40.0)).hue;
    EXPECT_NEAR(std::remainder(step, kTwoPi), kTwoPi / 40.0, 1e-4) << k;
  }
}

TEST(ColourChoice, ChangesAreAppliedInTheirOrder) {
  const LinearRgb green = *ParseColourChoice("sample:green");
  EXPECT_EQ(*ParseColourChoice("sample:green,brighter:0.2,vivid:-0.3"), Vivified(Brightened(green, 0.2), -0.3));
  EXPECT_EQ(*ParseColourChoice("sample:green,vivid:-0.3,brighter:0.2"), Brightened(Vivified(green, -0.3), 0.2));
  EXPECT_EQ(*ParseColourChoice("rgb:10,20,30,vivid:1"), Vivified(*ParseColourChoice("rgb:10,20,30"), 1.0));
}

TEST(ColourChoice, RefusalsSayWhatWasSeenAndWhatIsAllowed) {
  EXPECT_NE(Refusal("sample:pink").find("'pink' is no sample colour: the samples are black, brown"), std::string::npos);
  EXPECT_NE(Refusal("sample:9").find("1 to 8"), std::string::npos);
  EXPECT_NE(Refusal("bar:1.01").find("'1.01' is no place on the colour bar: write bar:P"), std::string::npos);
  EXPECT_NE(Refusal("rgb:1,2").find("less than three numbers"), std::string::npos);
  EXPECT_NE(Refusal("rgb:1,2,256").find("'256'"), std::string::npos);
  EXPECT_NE(Refusal("#12345").find("six hexadecimal digits"), std::string::npos);
  EXPECT_NE(Refusal("#123456,brighter:2").find("'brighter:2' is no change of a colour"), std::string::npos);
  EXPECT_NE(Refusal("#123456,").find("'' is no change"), std::string::npos);
  EXPECT_NE(Refusal("blue").find("'blue' is no colour: write #rrggbb, sample:NAME"), std::string::npos);
  for (const char* wrong : {"", ",", "rgb:", "rgb:nan,0,0", "bar:", "bar:inf", "linear:1,1,1.5", "hvc:5,11,2",
                            "bar: 0.5", "#123456 ", "sample:", "vivid:0.5"}) {
    EXPECT_FALSE(Refusal(wrong).empty()) << wrong;
  }
}

TEST(ColourChoice, WrittenColoursReadBackToTheBit) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> channel(0.0F, 1.0F);
  for (int k = 0; k < 2000; ++k) {
    const LinearRgb any(channel(random), channel(random), channel(random));
    EXPECT_EQ(*ParseColourChoice(ColourText(any)), any);
    const LinearRgb byte = LinearFromHex(random() & 0xffffffU);
    EXPECT_EQ(ColourText(byte).size(), 7U);
    EXPECT_EQ(*ParseColourChoice(ColourText(byte)), byte);
  }
  EXPECT_EQ(ColourText(LinearFromHex(0x2b1a12)), "#2b1a12");
}

TEST(ColourChoice, TheChooserShowsSamplesBarAndTheChosenColour) {
  const LinearRgb amber = LinearFromHex(SampleColours()[2].rrggbb);
  const RgbImage page = ColourChooser(amber);
  ASSERT_EQ(page.width, 760);
  ASSERT_EQ(page.height, 560);
  const auto bytes = [&page](int x, int y) {
    const LinearRgb& c = page.rgb[page.Index(x, y)];
    return std::array<int, 3>{SrgbByteFromLinear(c[0]), SrgbByteFromLinear(c[1]), SrgbByteFromLinear(c[2])};
  };
  EXPECT_EQ(bytes(600, 280), (std::array<int, 3>{0xb8, 0x72, 0x2a})) << "the chosen colour's field";
  EXPECT_EQ(bytes(250, 60), (std::array<int, 3>{0xb8, 0x72, 0x2a})) << "the third sample";
  EXPECT_EQ(bytes(455, 245), (std::array<int, 3>{255, 255, 255})) << "no display shows this light a colour so vivid";
}

}  // namespace
}  // namespace annulus
