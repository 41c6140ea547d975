#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "modeling/glasses/prescription.h"
#include "tests/support/dice.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;

constexpr const char* kExample = R"({
  "format": "annulus-rx", "version": 1, "date": "2026-05-04", "prescriber": "Dr. Example", "refracted_vertex_mm": 12,
  "right": {"sph_d": -4, "cyl_d": -0.75, "axis_deg": 90, "add_d": 2, "pd_mm": 31.5, "height_mm": 20,
            "prism": {"horizontal_cm_m": 1, "horizontal_base": "in", "vertical_cm_m": 0.5, "vertical_base": "down"}},
  "left": {"sph_d": -3.5, "pd_mm": 32, "prism": {"magnitude_cm_m": 2, "base_deg": 180}},
  "centration": {"status": "confirmed", "confirmed_by": "A. Optician"}
})";

std::string Complaint(const std::string& text) {
  const auto read = PrescriptionFromJson(text, "rx.json");
  return read ? "read" : read.error().Text();
}

/// The example with something changed.
std::string With(const std::function<void(Json&)>& change) {
  Json root = Json::parse(kExample);
  change(root);
  return root.dump();
}

TEST(PrescriptionJson, ReadsTheDocumentedExample) {
  const auto rx = PrescriptionFromJson(kExample, "rx.json");
  ASSERT_TRUE(rx) << rx.error().Text();
  EXPECT_EQ(rx->date, "2026-05-04");
  EXPECT_EQ(rx->prescriber, "Dr. Example");
  EXPECT_EQ(rx->refracted_vertex, 12.0);
  EXPECT_EQ(rx->right, (EyePrescription{-4.0, -0.75, 90.0, {1.0, -0.5}, 2.0, 31.5, 20.0}));
  EXPECT_EQ(rx->left, (EyePrescription{-3.5, 0.0, {}, {2.0, 0.0}, {}, 32.0, {}}));
  EXPECT_EQ(rx->centration_confirmed_by, "A. Optician");
}

TEST(PrescriptionJson, LessIsEnough) {
  const auto rx = PrescriptionFromJson(R"({"format": "annulus-rx", "version": 1, "date": "2026-05-04",
    "prescriber": "X", "right": {"sph_d": 1}, "left": {"sph_d": 1.25}})",
                                       "rx.json");
  ASSERT_TRUE(rx) << rx.error().Text();
  EXPECT_FALSE(rx->centration_confirmed());
  EXPECT_FALSE(rx->refracted_vertex);
  EXPECT_FALSE(rx->right.pd);
}

TEST(PrescriptionJson, WhatIsWrittenReadsBackToTheSameBits) {
  test::Dice dice(3);
  for (int round = 0; round < 500; ++round) {
    Prescription rx;
    rx.date = "2026-05-04";
    rx.prescriber = "Ärztin \"Ü\"";
    for (EyePrescription* eye : {&rx.right, &rx.left}) {
      eye->sphere = dice.Between(-15.0, 15.0);
      eye->cylinder = dice.Below(3) == 0 ? 0.0 : dice.Between(-6.0, 6.0);
      if (eye->cylinder != 0.0) eye->axis_deg = dice.Between(0.0, 180.0);
      if (dice.Below(2) == 0) eye->prism = {dice.Between(-8.0, 8.0), dice.Between(-8.0, 8.0)};
      if (dice.Below(2) == 0) eye->add = dice.Between(0.25, 4.0);
      if (dice.Below(2) == 0) eye->pd = dice.Between(20.0, 45.0);
      if (dice.Below(2) == 0) eye->height = dice.Between(5.0, 60.0);
    }
    if (dice.Below(2) == 0) rx.refracted_vertex = dice.Between(5.0, 25.0);
    if (dice.Below(2) == 0) rx.centration_confirmed_by = "A. Optician";
    const std::string text = PrescriptionToJson(rx);
    const auto read = PrescriptionFromJson(text, "rx.json");
    ASSERT_TRUE(read) << read.error().Text();
    ASSERT_EQ(*read, rx);
    ASSERT_EQ(PrescriptionToJson(*read), text);
  }
}

TEST(PrescriptionJson, BadFilesAreRefusedWithTheFieldAndTheRange) {
  EXPECT_THAT(Complaint("{"), HasSubstr("it is not a complete JSON object"));
  EXPECT_THAT(Complaint("[1]"), HasSubstr("it is not a complete JSON object"));
  EXPECT_THAT(Complaint(R"({"format": "annulus-frame"})"), HasSubstr("its format is not 'annulus-rx'"));
  EXPECT_THAT(Complaint(With([](Json& j) { j["version"] = 2; })), HasSubstr("its version is not 1"));
  EXPECT_THAT(Complaint(With([](Json& j) { j["dates"] = 2; })), HasSubstr("'dates' is not a known key"));
  EXPECT_THAT(Complaint(With([](Json& j) { j["right"]["sphere"] = 2; })),
              HasSubstr("right: 'sphere' is not a known key (known: sph_d, cyl_d"));
  EXPECT_THAT(Complaint(With([](Json& j) { j["right"]["sph_d"] = "-4.00"; })),
              HasSubstr("right: 'sph_d' is not a number"));
  EXPECT_THAT(Complaint(With([](Json& j) { j["left"].erase("sph_d"); })), HasSubstr("left: 'sph_d' is missing"));
  EXPECT_THAT(Complaint(With([](Json& j) { j.erase("left"); })), HasSubstr("'left' is missing or no object"));
  EXPECT_THAT(Complaint(With([](Json& j) { j["date"] = 20260504; })), HasSubstr("'date' is missing or no text"));
  EXPECT_THAT(Complaint(With([](Json& j) { j["right"]["sph_d"] = -40; })),
              HasSubstr("rx.json: right SPH is -40 D, outside -30 to 30 D"));
  EXPECT_THAT(Complaint(With([](Json& j) { j["right"].erase("axis_deg"); })), HasSubstr("it has no axis"));
}

TEST(PrescriptionJson, APrismIsReadInOneFormOnly) {
  const auto prism = [](const char* text) {
    return With([text](Json& j) { j["right"]["prism"] = Json::parse(text); });
  };
  EXPECT_THAT(Complaint(prism(R"({"horizontal_cm_m": 1})")),
              HasSubstr("right: prism: 'horizontal_base' is missing or no text"));
  EXPECT_THAT(Complaint(prism(R"({"horizontal_base": "in"})")), HasSubstr("has no 'horizontal_cm_m'"));
  EXPECT_THAT(Complaint(prism(R"({"horizontal_cm_m": 1, "horizontal_base": "up"})")),
              HasSubstr("'horizontal_base' is 'up', neither 'in' nor 'out'"));
  EXPECT_THAT(Complaint(prism(R"({"vertical_cm_m": -1, "vertical_base": "up"})")), HasSubstr("below 0"));
  EXPECT_THAT(Complaint(prism(R"({"magnitude_cm_m": 1, "base_deg": 400})")), HasSubstr("outside 0 to 360"));
  EXPECT_THAT(Complaint(prism(R"({"magnitude_cm_m": 1})")), HasSubstr("'base_deg' is missing"));
  EXPECT_THAT(Complaint(prism(R"({"magnitude_cm_m": 1, "base_deg": 0, "vertical_cm_m": 1})")),
              HasSubstr("'vertical_cm_m' is not a known key"));
  EXPECT_THAT(Complaint(prism(R"({"magnitude_cm_m": 21, "base_deg": 0})")), HasSubstr("right prism is 21 cm/m"));
  EXPECT_EQ(Complaint(prism("{}")), "read");
}

TEST(PrescriptionJson, AConfirmationHasAName) {
  const auto centration = [](const char* text) {
    return With([text](Json& j) { j["centration"] = Json::parse(text); });
  };
  EXPECT_EQ(Complaint(centration(R"({"status": "estimate"})")), "read");
  EXPECT_THAT(Complaint(centration(R"({"status": "confirmed"})")), HasSubstr("'confirmed_by' is missing or no text"));
  EXPECT_THAT(Complaint(centration(R"({"status": "confirmed", "confirmed_by": "  "})")), HasSubstr("has a name"));
  EXPECT_THAT(Complaint(centration(R"({"status": "estimate", "confirmed_by": "X"})")), HasSubstr("no 'confirmed_by'"));
  EXPECT_THAT(Complaint(centration(R"({"status": "sure"})")), HasSubstr("neither 'estimate' nor 'confirmed'"));
}

TEST(PrescriptionJson, ARepeatedKeyIsRefusedAtAnyDepth) {
  std::string text = kExample;
  const std::string key = R"("sph_d": -4,)";
  text.insert(text.find(key), R"("sph_d": 4, )");
  EXPECT_THAT(Complaint(text), HasSubstr("'sph_d' is given twice"));
  text = kExample;
  text.insert(text.find(R"("date")"), R"("date": "2026-05-05", )");
  EXPECT_THAT(Complaint(text), HasSubstr("'date' is given twice"));
}

}  // namespace
}  // namespace annulus
