#include "modeling/exchange/smis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/modeling_exchange/measured_table.h"

namespace annulus {
namespace {

using test::Measured;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

MeasurementTable TableOf(std::vector<Measurement> measurements) {
  MeasurementTable table;
  table.measurements = std::move(measurements);
  return table;
}

TEST(Smis, NamesWhatTheProgramsKnowByTheirNames) {
  const PatternFile file = MeasurementsToSmis(TableOf({Measured("waist_girth", 700.123), Measured("hip_girth", 950)}),
                                              SewingDialect::kSeamly);
  EXPECT_THAT(file.text, HasSubstr("<m name=\"waist_circ\" value=\"700.12\" full_name=\"Term of waist_girth\" "
                                   "description=\"Definition of waist_girth. ± 0.25 mm (1 sd)\"/>"));
  EXPECT_THAT(file.text, HasSubstr("<m name=\"hip_circ\" value=\"950.00\""));
  EXPECT_THAT(file.text, Not(HasSubstr("@annulus")));
}

TEST(Smis, WritesOtherLengthsAsCustomMeasurements) {
  const PatternFile file = MeasurementsToSmis(TableOf({Measured("nose_breadth", 34.5)}), SewingDialect::kSeamly);
  EXPECT_THAT(file.text, HasSubstr("<m name=\"@annulus_nose_breadth\" value=\"34.50\""));
}

TEST(Smis, ListsWhatIsNoLengthAndWhatIsMissing) {
  const PatternFile file =
      MeasurementsToSmis(TableOf({Measured("trunk_volume", 7e7, "mm3"), Measured("shoulder_slope_left", 22, "deg")}),
                         SewingDialect::kValentina);
  EXPECT_THAT(file.text, Not(HasSubstr("<m ")));
  EXPECT_THAT(file.left_out, Contains("trunk_volume: not a length."));
  EXPECT_THAT(file.left_out, Contains("shoulder_slope_left: not a length."));
  EXPECT_THAT(file.left_out, Contains(HasSubstr("bust_circ: needs chest_girth")));
  for (const std::string& sentence : file.left_out) EXPECT_THAT(file.text, HasSubstr(sentence));
}

TEST(Smis, TakesTheMeanOfBothSidesAndKeepsTheSidesToo) {
  const std::string text =
      MeasurementsToSmis(TableOf({Measured("shoulder_length_right", 120), Measured("shoulder_length_left", 125)}),
                         SewingDialect::kSeamly)
          .text;
  EXPECT_THAT(text, HasSubstr("name=\"shoulder_length\" value=\"122.50\""));
  EXPECT_THAT(text, HasSubstr("name=\"@annulus_shoulder_length_right\" value=\"120.00\""));
  EXPECT_THAT(text, HasSubstr("name=\"@annulus_shoulder_length_left\" value=\"125.00\""));
}

TEST(Smis, GivesTheHeightOfAHorizontalLevelAtFrontSideAndBack) {
  const std::string text =
      MeasurementsToSmis(TableOf({Measured("waist_height", 1040)}), SewingDialect::kValentina).text;
  for (const char* name : {"height_waist_front", "height_waist_side", "height_waist_back"}) {
    EXPECT_THAT(text, HasSubstr(std::string("name=\"") + name + "\" value=\"1040.00\""));
  }
}

TEST(Smis, HasTheRootVersionAndUnitOfEachProgram) {
  const MeasurementTable table = TableOf({Measured("waist_girth", 700)});
  const std::string seamly = MeasurementsToSmis(table, SewingDialect::kSeamly).text;
  EXPECT_THAT(seamly, testing::StartsWith("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<smis>\n"));
  EXPECT_THAT(seamly, HasSubstr("<version>0.3.4</version>"));
  EXPECT_THAT(seamly, HasSubstr("<unit>mm</unit>"));
  EXPECT_THAT(seamly, testing::EndsWith("</smis>\n"));
  const std::string valentina = MeasurementsToSmis(table, SewingDialect::kValentina).text;
  EXPECT_THAT(valentina, HasSubstr("<vit>\n    <version>0.3.3</version>"));
  EXPECT_THAT(valentina, testing::EndsWith("</vit>\n"));
}

TEST(Smis, EscapesTextThatXmlWouldRead) {
  Measurement m = Measured("odd", 1);
  m.term = "a<b & \"c\"\n\x01";
  EXPECT_THAT(MeasurementsToSmis(TableOf({m}), SewingDialect::kSeamly).text,
              HasSubstr("full_name=\"a&lt;b &amp; &quot;c&quot;  \""));
}

TEST(Smis, SaysThatAnSdIsNotKnownAndLeavesOutNumbersThatAreNone) {
  Measurement known = Measured("waist_girth", 700);
  known.value.sigma = std::numeric_limits<double>::quiet_NaN();
  const Measurement none = Measured("hip_girth", std::numeric_limits<double>::quiet_NaN());
  const std::string text = MeasurementsToSmis(TableOf({known, none}), SewingDialect::kSeamly).text;
  EXPECT_THAT(text, HasSubstr("sd not known"));
  EXPECT_THAT(text, Not(HasSubstr("nan")));
  EXPECT_THAT(text, Not(HasSubstr("name=\"hip_circ\"")));
}

}  // namespace
}  // namespace annulus
