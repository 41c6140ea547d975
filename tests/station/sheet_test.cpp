#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/units.h"
#include "station/measurement_files.h"
#include "station/sheet_canvas.h"
#include "station/sheet_figure.h"

namespace annulus {
namespace {

Measurement Of(const std::string& id, const std::string& method, const std::string& unit = "mm") {
  Measurement m;
  m.id = id;
  m.term = "Term of " + id;
  m.method = method;
  m.unit = unit;
  m.value = {100.0, 0.5};
  return m;
}

Measurement Around(const std::string& id, const std::string& method, double z) {
  Measurement m = Of(id, method);
  std::vector<Eigen::Vector3d> loop;
  for (const double degrees : {0.0, 90.0, 180.0, 0.0}) {
    loop.emplace_back(50.0 * std::cos(RadiansFromDegrees(degrees)), 50.0 * std::sin(RadiansFromDegrees(degrees)), z);
  }
  m.paths = {loop};
  return m;
}

/// An upright cylinder of 50 mm radius, all measured.
SurfaceModel Cylinder() {
  const PeriodicCubicBasis theta(12);
  const ClampedCubicBasis z({0.0, 100.0, 200.0});
  const auto count = static_cast<Eigen::Index>(theta.count() * z.count());
  SurfaceModel model;
  model.segments.push_back({"body", {theta, z, Eigen::VectorXd::Constant(count, 50.0)}, {}, {}, {}, {}});
  return model;
}

TEST(SheetWords, SortMeasurementsIntoGroups) {
  EXPECT_EQ(GroupOf(Of("waist_girth", "tape, horizontal")), SheetGroup::kGirths);
  EXPECT_EQ(GroupOf(Of("waist_height", "height")), SheetGroup::kHeights);
  EXPECT_EQ(GroupOf(Of("shoulder_height_left", "height")), SheetGroup::kHeights);
  EXPECT_EQ(GroupOf(Of("head_height", "height")), SheetGroup::kHeights);
  EXPECT_EQ(GroupOf(Of("head_girth", "tape, horizontal")), SheetGroup::kHead);
  EXPECT_EQ(GroupOf(Of("hip_depth", "extent")), SheetGroup::kBreadths);
  EXPECT_EQ(GroupOf(Of("scye_depth", "skin, vertical")), SheetGroup::kLengths);
  EXPECT_EQ(GroupOf(Of("shoulder_slope_left", "angle", "deg")), SheetGroup::kAngles);
  EXPECT_EQ(GroupOf(Of("head_volume", "volume", "mm3")), SheetGroup::kVolumes);
}

TEST(SheetWords, TellTheSkinFromTheTapeInJapanese) {
  EXPECT_EQ(TermIn(Of("waist_girth", "tape, horizontal"), SheetLanguage::kJapanese), "胴囲(ウエスト)");
  EXPECT_EQ(TermIn(Of("waist_perimeter", "skin, horizontal"), SheetLanguage::kJapanese), "胴囲(ウエスト) 体表");
  EXPECT_EQ(TermIn(Of("neck_to_waist_back", "skin, vertical"), SheetLanguage::kJapanese), "背丈 体表");
  EXPECT_EQ(TermIn(Of("neck_to_waist_back_tape", "tape, vertical"), SheetLanguage::kJapanese), "背丈");
  EXPECT_EQ(TermIn(Of("brand_new", "tape"), SheetLanguage::kJapanese), "Term of brand_new");
  EXPECT_EQ(TermIn(Of("waist_girth", "tape"), SheetLanguage::kEnglish), "Term of waist_girth");
}

TEST(SheetFigure, NumbersWhatItDrawsInTheSheetsOrder) {
  MeasurementTable table;
  table.measurements = {Around("hip_depth", "extent", 80),
                        Around("waist_girth", "tape, horizontal", 100),
                        Around("waist_perimeter", "skin, horizontal", 100.5),
                        Around("waist_height", "height", 100),
                        Of("head_volume", "volume", "mm3"),
                        Around("hip_girth", "tape, horizontal", 80)};
  const auto numbered = NumberForSheet(table);
  std::vector<std::pair<std::string, int>> found;
  for (const NumberedMeasurement& n : numbered) found.emplace_back(n.measurement->id, n.number);
  using Pair = std::pair<std::string, int>;
  EXPECT_THAT(found, testing::ElementsAre(Pair("waist_girth", 1), Pair("waist_perimeter", 1), Pair("hip_girth", 2),
                                          Pair("hip_depth", 2), Pair("waist_height", 0), Pair("head_volume", 0)));
}

TEST(SheetCanvas, SetsWordsSideBySide) {
  SheetCanvas canvas("test");
  const SheetText style;
  const double one = canvas.TextWidth("Waist", style);
  EXPECT_GT(one, 5.0);  // five letters of 9 pt, mm
  EXPECT_LT(one, 12.0);
  EXPECT_NEAR(canvas.TextWidth("WaistWaist", style), 2.0 * one, 0.3);
  const double line = canvas.Paragraph({10, 20}, 100.0, "Waist", style);
  EXPECT_NEAR(canvas.Paragraph({10, 20}, 0.5 * one, "Waist", style) / line, 2.0, 1.01);
}

TEST(SheetCanvas, RefusesLettersThatNoFontHas) {
  SheetCanvas canvas("test");
  canvas.Text({10, 10}, "\xF3\xB0\x80\x80", {});  // a private-use code point
  const auto bytes = canvas.Finish();
  ASSERT_FALSE(bytes.has_value());
  EXPECT_THAT(bytes.error().Text(), testing::HasSubstr("no font"));
}

TEST(MeasurementSheet, IsAPdfAndTheSameEachTime) {
  MeasurementTable table;
  table.measurements = {Around("waist_girth", "tape, horizontal", 100), Of("head_volume", "volume", "mm3")};
  const SurfaceModel model = Cylinder();
  const auto first = MeasurementSheet(table, model, {});
  const auto second = MeasurementSheet(table, model, {});
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(*first, *second);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(first->data()), 5), "%PDF-");
}

TEST(MeasurementSheet, OfAModelOfWhichNothingIsKnownHasNoPictures) {
  SurfaceModel model = Cylinder();
  model.segments.front().knowledge = KnowledgeMap(4, 4, 0.0, 200.0);
  EXPECT_TRUE(MeasurementSheet({}, model, {}).has_value());
}

TEST(MeasurementFiles, GoByTheirEnding) {
  EXPECT_EQ(MeasurementFormatOf("a.json"), MeasurementFormat::kJson);
  EXPECT_EQ(MeasurementFormatOf("a.freesewing.json"), MeasurementFormat::kFreeSewing);
  EXPECT_EQ(MeasurementFormatOf("dir.pdf/a.csv"), MeasurementFormat::kCsv);
  EXPECT_EQ(MeasurementFormatOf("a.smis"), MeasurementFormat::kSeamly);
  EXPECT_EQ(MeasurementFormatOf("a.vit"), MeasurementFormat::kValentina);
  EXPECT_EQ(MeasurementFormatOf("a.pdf"), MeasurementFormat::kSheet);
  for (const char* other : {"", "pdf", "a.PDF", "a.json.gz"}) {
    EXPECT_THAT(MeasurementFormatOf(other).error().Text(), testing::HasSubstr(".freesewing.json")) << other;
  }
}

}  // namespace
}  // namespace annulus
