#include "modeling/flatten/flat_pattern.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/storage.h"
#include "modeling/flatten/cut_outline.h"
#include "modeling/flatten/pattern_drawing.h"
#include "modeling/flatten/pattern_json.h"
#include "modeling/flatten/surface_region.h"
#include "tests/modeling_flatten/flat_bodies.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

/// The bodice that docs/formats.md shows.
Pattern Bodice() {
  PosixStorage storage;
  const auto text = ReadTextFile(storage, test::SourceFolder() + "/docs/examples/flatten/bodice.json");
  EXPECT_TRUE(text);
  auto pattern = PatternFromJson(*text, "bodice.json");
  EXPECT_TRUE(pattern) << pattern.error().Text();
  return *pattern;
}

/// One quarter of a tube from z = 40 to 140 mm.
Pattern Panel() {
  const char* text = R"({"format": "annulus pattern", "version": 1, "name": "panel", "allowance_mm": 10, "lines": {
    "foot": {"places": [{"theta_deg": 0, "z_mm": 40}, {"theta_deg": 90, "z_mm": 40}]},
    "left": {"places": [{"theta_deg": 90, "z_mm": 40}, {"theta_deg": 90, "z_mm": 140}], "notches": [0.25]},
    "head": {"places": [{"theta_deg": 0, "z_mm": 140}, {"theta_deg": 90, "z_mm": 140}]},
    "right": {"places": [{"theta_deg": 0, "z_mm": 40}, {"theta_deg": 0, "z_mm": 140}]}},
    "pieces": [{"id": "panel", "outline": ["foot", "left", "-head", "-right"]}]})";
  return *PatternFromJson(text, "panel.json");
}

double LargestMismatch(const FlatPattern& flat) {
  double largest = 0.0;
  for (const FlatSeam& seam : flat.seams) largest = std::max(largest, std::abs(seam.flat_mm[0] - seam.flat_mm[1]));
  return largest;
}

TEST(FlattenPattern, OfACylinderIsARectangleWithTheBodysMeasures) {
  const SurfaceSegment cylinder = test::BodyOf(0.0, 300.0, [](double, double) { return 100.0; });
  const Pattern panel = Panel();
  const auto flat = FlattenPattern(panel, {cylinder, {}}, {});
  ASSERT_TRUE(flat) << flat.error().Text();
  const double width = 50.0 * std::numbers::pi;
  EXPECT_NEAR(flat->pieces[0].flat_area_mm2, width * 100.0, 1e-5);
  EXPECT_LE(flat->pieces[0].largest_strain, 1e-8);
  const auto drawn = DrawPattern(panel, *flat);
  EXPECT_NEAR(drawn[0].high.x() - drawn[0].low.x(), width + 20.0, 1e-5);
  EXPECT_NEAR(drawn[0].high.y() - drawn[0].low.y(), 120.0, 1e-5);
  ASSERT_EQ(drawn[0].notches.size(), 1U);  // a quarter up the left edge, as far out as the allowance
  EXPECT_NEAR(drawn[0].notches[0][0].y(), 10.0 + 25.0, 1e-5);
  EXPECT_NEAR(drawn[0].notches[0][1].x() - drawn[0].notches[0][0].x(), 10.0, 1e-5);
}

TEST(FlattenPattern, OfATrunkMatchesAllSeams) {
  const SurfaceSegment trunk = test::Trunk(130.0, 25.0);
  const auto flat = FlattenPattern(Bodice(), test::OnTrunk(trunk), {});
  ASSERT_TRUE(flat) << flat.error().Text();
  ASSERT_EQ(flat->pieces.size(), 4U);
  EXPECT_EQ(flat->seams.size(), 4U);
  EXPECT_LE(LargestMismatch(*flat), 0.1);
  for (const FlatPiece& piece : flat->pieces) {
    EXPECT_EQ(CountFlips(piece.body.sheet, piece.points), 0U);
    EXPECT_NEAR(piece.flat_area_mm2 / piece.body_area_mm2, 1.0, 0.05);
    const Eigen::Vector2d grain = piece.points[piece.body.grain[1]] - piece.points[piece.body.grain[0]];
    EXPECT_NEAR(grain.x(), 0.0, 1e-9);
    EXPECT_GT(grain.y(), 0.0);
  }
}

TEST(FlattenPattern, LaysTheSamePatternOnAnotherBody) {
  const SurfaceSegment small = test::Trunk(130.0, 25.0);
  const SurfaceSegment large = test::Trunk(156.0, 30.0);  // 1.2 times, around; the heights are the same
  const auto first = FlattenPattern(Bodice(), test::OnTrunk(small), {});
  const auto second = FlattenPattern(Bodice(), test::OnTrunk(large), {});
  ASSERT_TRUE(first && second);
  EXPECT_LE(LargestMismatch(*second), 0.1);
  for (std::size_t p = 0; p < 4; ++p) {
    EXPECT_EQ(first->pieces[p].id, second->pieces[p].id);
    EXPECT_NEAR(second->pieces[p].flat_area_mm2 / first->pieces[p].flat_area_mm2, 1.2, 0.03);
  }
}

TEST(FlattenPattern, WithADartHasEqualLegsAndLessEnergy) {
  const SurfaceSegment trunk = test::Trunk(130.0, 40.0);
  Pattern pattern = Bodice();
  const auto before = FlattenPattern(pattern, test::OnTrunk(trunk), {});
  ASSERT_TRUE(before);
  PatternDart dart{0, 0.5, {}};
  for (std::size_t k = 0; k < pattern.lines.size(); ++k) {
    if (pattern.lines[k].id == "waist_front_left") dart.line = k;
  }
  dart.tip.turn = std::numbers::pi / 2.0 + 0.45;
  dart.tip.up = 1180.0;
  pattern.pieces[0].darts.push_back(dart);
  const auto after = FlattenPattern(pattern, test::OnTrunk(trunk), {});
  ASSERT_TRUE(after) << after.error().Text();
  EXPECT_EQ(after->seams.size(), 5U);
  EXPECT_LE(LargestMismatch(*after), 0.1);
  EXPECT_LT(after->pieces[0].energy, 0.8 * before->pieces[0].energy);
  EXPECT_EQ(CountRimCrossings({after->pieces[0].rim}, after->pieces[0].points), 0U);
}

TEST(WithProposedDarts, BringsTheStrainDown) {
  const SurfaceSegment trunk = test::Trunk(130.0, 40.0);
  Pattern pattern = Bodice();
  pattern.pieces.resize(1);
  pattern.element_mm = 18.0;
  pattern.darts = {0.01, 2};
  const auto before = FlattenPattern(pattern, test::OnTrunk(trunk), {});
  const auto proposed = WithProposedDarts(pattern, test::OnTrunk(trunk), {});
  ASSERT_TRUE(before && proposed);
  EXPECT_GE(proposed->pieces[0].darts.size(), 1U);
  const auto after = FlattenPattern(*proposed, test::OnTrunk(trunk), {});
  ASSERT_TRUE(after) << after.error().Text();
  EXPECT_LT(after->pieces[0].energy, 0.6 * before->pieces[0].energy);
  // A dart's place reads back.
  const auto again = PatternFromJson(PatternToJson(*proposed), "again");
  ASSERT_TRUE(again);
  EXPECT_EQ(PatternToJson(*again), PatternToJson(*proposed));
}

TEST(FlattenPattern, RefusesWhatCannotBeSewn) {
  const SurfaceSegment cylinder = test::BodyOf(0.0, 300.0, [](double, double) { return 100.0; });
  Pattern gap = Panel();
  gap.pieces[0].outline.pop_back();
  EXPECT_FALSE(FlattenPattern(gap, {cylinder, {}}, {}));
  Pattern lost = Panel();
  lost.lines[0].places[0].z_of = "level.nowhere";
  const auto refused = FlattenPattern(lost, {cylinder, {}}, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().Text().find("level.nowhere"), std::string::npos);
}

TEST(OffsetOutline, OfASquareIsALargerSquare) {
  const auto moved = OffsetOutline({{0.0, 0.0}, {100.0, 0.0}, {100.0, 50.0}, {0.0, 50.0}}, {10.0, 10.0, 20.0, 10.0});
  EXPECT_NEAR(0.5 * TurnedArea(moved), 120.0 * 80.0, 1e-9);
}

TEST(OffsetOutline, CutsOffTheLoopsOfANarrowHollow) {
  // A notch 10 mm wide and 40 mm deep closes when both walls move by 10 mm.
  const auto moved = OffsetOutline(
      {{0.0, 0.0}, {100.0, 0.0}, {100.0, 60.0}, {55.0, 60.0}, {55.0, 20.0}, {45.0, 20.0}, {45.0, 60.0}, {0.0, 60.0}},
      std::vector<double>(8, 10.0));
  EXPECT_NEAR(0.5 * TurnedArea(moved), 120.0 * 80.0, 1e-6);
}

}  // namespace
}  // namespace annulus
