#include "modeling/glasses/frame_library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "modeling/glasses/frame.h"
#include "modeling/glasses/frame_library_data.h"

namespace annulus {
namespace {

using testing::HasSubstr;

const char* const kOwn = R"({
  "format": "annulus-frame-library", "version": 1,
  "styles": [
    {"name": "mine", "description": "of my own", "material": "metal",
     "parameters": {"width_mm": 50, "upper_outer_mm": 8, "upper_inner_mm": 8, "upper_thickness_mm": 2.5,
                    "lower_outer_mm": 8, "lower_inner_mm": 8, "lower_thickness_mm": 2.5, "height_mm": 40,
                    "bridge_height_mm": 24},
     "details": {"bridge": "keyhole", "face_form_deg": 5},
     "sizes": [{"name": "one", "a_mm": 48, "b_mm": 38, "dbl_mm": 18, "temple_mm": 140}]}
  ]
})";

std::string Own(const std::string& from, const std::string& to) {
  std::string text = kOwn;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string Complaint(const std::string& json) {
  const auto library = FrameLibraryFromJson(json, "own.json");
  return library ? "fine" : library.error().Text();
}

TEST(FrameLibrary, HasAtLeast24StylesInThreeSizesEach) {
  std::size_t sized = 0;
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    if (style.name.starts_with("example")) continue;
    ++sized;
    EXPECT_EQ(style.sizes.size(), 3U) << style.name;
    EXPECT_GE(style.description.size(), 10U) << style.name;
    double previous = 0.0;
    for (const SoldSize& size : style.sizes) {
      EXPECT_GT(size.a, previous) << style.name;
      previous = size.a;
    }
  }
  EXPECT_GE(sized, 24U);
}

TEST(FrameLibrary, HasTheStylesThatOpticiansKnow) {
  for (const char* name : {"round",         "panto",
                           "boston",        "wellington",
                           "browline",      "half-browline",
                           "aviator",       "navigator",
                           "square",        "rectangle",
                           "oval",          "cat-eye",
                           "butterfly",     "octagon",
                           "hexagon",       "p3",
                           "keyhole-round", "half-rim-rectangle",
                           "rimless-oval",  "rimless-rectangle",
                           "half-eye",      "oversize",
                           "sport-wrap",    "children-round",
                           "example1",      "example2",
                           "example3",      "example4"}) {
    EXPECT_TRUE(BuiltInFrameLibrary().Find(name)) << name;
  }
}

TEST(FrameLibrary, HasSectionsThatTheMaterialAllows) {
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    if (style.sizes.empty()) continue;
    const bool metal = style.material == DesignMaterial::kMetal;
    const FrameParameters& p = style.design.parameters;
    EXPECT_GE(p.upper_thickness, metal ? 1.0 : 3.0) << style.name;
    EXPECT_LE(p.upper_thickness, metal ? 1.8 : 5.0) << style.name;
    EXPECT_GE(style.design.depth() * 0.75, metal ? 1.5 : 3.0) << style.name;  // what is left of s
    EXPECT_LE(style.design.depth() * 0.75, metal ? 2.5 : 4.5) << style.name;
  }
}

TEST(FrameLibrary, BuildsEveryStyle) {
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    const auto frame = BuildFrame(style.design, StandardAdjustment(style.design));
    EXPECT_TRUE(frame) << style.name << ": " << frame.error().Text();
    EXPECT_EQ(style.design.style, style.name);
  }
}

TEST(FrameLibrary, ReadsBackTheSame) {
  const std::string written = FrameLibraryToJson(BuiltInFrameLibrary());
  const auto read = FrameLibraryFromJson(written, "own.json");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(FrameLibraryToJson(*read), written);
  ASSERT_EQ(read->styles.size(), BuiltInFrameLibrary().styles.size());
  for (std::size_t k = 0; k < read->styles.size(); ++k) {
    EXPECT_EQ(read->styles[k].design, BuiltInFrameLibrary().styles[k].design);
    EXPECT_EQ(read->styles[k].sizes, BuiltInFrameLibrary().styles[k].sizes);
  }
}

TEST(FrameLibrary, TakesOwnStylesBeforeTheBuiltInOnes) {
  const auto own = FrameLibraryFromJson(Own("\"mine\"", "\"boston\""), "own.json");
  ASSERT_TRUE(own) << own.error().Text();
  const FrameLibrary merged = Merged(*own, BuiltInFrameLibrary());
  EXPECT_EQ(merged.styles.size(), BuiltInFrameLibrary().styles.size());
  const LibraryStyle* const boston = merged.Find("boston").value();
  EXPECT_EQ(boston->description, "of my own");
  ASSERT_NE(boston->Size("one"), nullptr);
  EXPECT_EQ(boston->Size("one")->b, 38.0);
  EXPECT_EQ(boston->Size("two"), nullptr);
}

TEST(FrameLibrary, NamesTheStyleAndTheKeyThatIsWrong) {
  EXPECT_EQ(Complaint(kOwn), "fine");
  EXPECT_THAT(Complaint(Own("\"height_mm\": 40", "\"height_mm\": \"tall\"")),
              testing::AllOf(HasSubstr("own.json"), HasSubstr("mine"), HasSubstr("parameters.height_mm")));
  EXPECT_THAT(Complaint(Own("\"height_mm\": 40", "\"height_mm\": 400")), HasSubstr("height"));
  EXPECT_THAT(Complaint(Own("\"bridge\":", "\"bridges\":")), HasSubstr("details.bridges"));
  EXPECT_THAT(Complaint(Own("\"keyhole\"", "\"arch\"")), HasSubstr("'arch', not one of straight, saddle, keyhole"));
  EXPECT_THAT(Complaint(Own("\"a_mm\": 48", "\"a_mm\": 480")),
              testing::AllOf(HasSubstr("sizes[0]"), HasSubstr("a_mm is 480")));
  EXPECT_THAT(Complaint(Own("\"b_mm\"", "\"height\"")), HasSubstr("sizes[0].height"));
  EXPECT_THAT(Complaint(Own("\"metal\"", "\"wood\"")), HasSubstr("acetate, metal"));
  EXPECT_THAT(Complaint(Own("\"name\": \"mine\",", "")), HasSubstr("styles[0].name"));
  EXPECT_THAT(Complaint(Own("\"one\"", "\"\"")), HasSubstr("sizes[0].name"));
  EXPECT_THAT(Complaint(Own("\"face_form_deg\": 5", "\"face_form_deg\": 5, \"face_form_rad\": 0.1")),
              HasSubstr("face_form"));
  EXPECT_THAT(Complaint(Own("\"face_form_deg\": 5", "\"bridge\": \"saddle\"")), HasSubstr("'bridge' twice"));
}

TEST(FrameLibrary, NamesTheLineThatIsNoJson) {
  EXPECT_THAT(Complaint(Own("\"material\": \"metal\",", "\"material\": \"metal\"")), HasSubstr("line 5"));
  EXPECT_THAT(Complaint(Own("\"of my own\"", "of my own")), HasSubstr("line 4"));
}

TEST(FrameLibrary, RefusesEveryTruncation) {
  const std::string good = kOwn;
  for (std::size_t length = 0; length + 1 <= good.size(); ++length) {
    EXPECT_NE(Complaint(good.substr(0, length)), "fine") << length;
  }
}

TEST(FrameLibrary, RefusesForeignText) {
  for (const char* foreign :
       {"", "null", "[]", "{}", "\xff\xfe", R"({"format": "annulus-frame-library", "version": 1})",
        R"({"format": "annulus-frame-library", "version": 1, "styles": []})",
        R"({"format": "annulus-frame-library", "version": 1, "styles": [3]})",
        R"({"format": "annulus-frame-library", "version": 2, "styles": []})"}) {
    EXPECT_NE(Complaint(foreign), "fine") << foreign;
  }
  EXPECT_THAT(Complaint(std::string(100000, '[')), HasSubstr("levels deep"));
}

}  // namespace
}  // namespace annulus
