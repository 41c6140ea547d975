#include "modeling/flatten/flat_pattern.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/storage.h"
#include "modeling/flatten/cut_outline.h"
#include "modeling/flatten/pattern_drawing.h"
#include "modeling/flatten/pattern_json.h"
#include "modeling/flatten/surface_region.h"
#include "tests/modeling_flatten/flat_bodies.h"
#include "tests/modeling_flatten/sheet_shapes.h"
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

TEST(WithProposedCuts, BringsTheStrainDown) {
  const SurfaceSegment trunk = test::Trunk(130.0, 40.0);
  Pattern pattern = Bodice();
  pattern.pieces.resize(1);
  pattern.element_mm = 18.0;
  pattern.darts = {0.01, 2};
  const auto before = FlattenPattern(pattern, test::OnTrunk(trunk), {});
  const auto proposed = WithProposedCuts(pattern, test::OnTrunk(trunk), {});
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

std::size_t LineCalled(const Pattern& pattern, const char* id) {
  for (std::size_t k = 0; k < pattern.lines.size(); ++k) {
    if (pattern.lines[k].id == id) return k;
  }
  return pattern.lines.size();
}

TEST(FlattenPattern, OfADividedPanelIsTwoRectanglesThatAreSewn) {
  const SurfaceSegment cylinder = test::BodyOf(0.0, 300.0, [](double, double) { return 100.0; });
  Pattern panel = Panel();
  PatternDivision division;
  division.ends = {PatternDivision::End{LineCalled(panel, "foot"), 0.4},
                   PatternDivision::End{LineCalled(panel, "head"), 0.4}};
  panel.pieces[0].divisions.push_back(division);
  const auto flat = FlattenPattern(panel, {cylinder, {}}, {});
  ASSERT_TRUE(flat) << flat.error().Text();
  ASSERT_EQ(flat->pieces.size(), 2U);
  const double width = 50.0 * std::numbers::pi;
  std::array<double, 2> areas{flat->pieces[0].flat_area_mm2, flat->pieces[1].flat_area_mm2};
  std::sort(areas.begin(), areas.end());
  EXPECT_NEAR(areas[0], 0.4 * width * 100.0, 1e-5);
  EXPECT_NEAR(areas[1], 0.6 * width * 100.0, 1e-5);
  ASSERT_EQ(flat->seams.size(), 1U);
  EXPECT_NEAR(flat->seams[0].body_mm, 100.0, 1e-6);
  EXPECT_NEAR(flat->seams[0].flat_mm[0], 100.0, 1e-5);
  EXPECT_NEAR(flat->seams[0].flat_mm[1], 100.0, 1e-5);
  // The line's notch stays where it was, and both sides of the division get one at the same height.
  std::vector<double> heights;
  for (const DrawnPiece& drawn : DrawPattern(panel, *flat)) {
    EXPECT_NEAR(drawn.high.y() - drawn.low.y(), 120.0, 1e-5);
    for (const DrawnStroke& notch : drawn.notches) heights.push_back(notch[0].y() - drawn.low.y() - 10.0);
  }
  std::sort(heights.begin(), heights.end());
  ASSERT_EQ(heights.size(), 3U);
  EXPECT_NEAR(heights[0], 25.0, 1e-5);
  EXPECT_NEAR(heights[2] - heights[1], 0.0, 1e-5);
}

TEST(FlattenPattern, SewsTheNeighbourToBothPartsOfADividedPiece) {
  const SurfaceSegment trunk = test::Trunk(130.0, 40.0);
  Pattern pattern = Bodice();
  const auto whole = FlattenPattern(pattern, test::OnTrunk(trunk), {});
  ASSERT_TRUE(whole);
  std::size_t front = 0;
  for (std::size_t p = 0; p < 4; ++p) front = pattern.pieces[p].id == "front_left" ? p : front;
  PatternDivision division;
  division.ends = {PatternDivision::End{LineCalled(pattern, "side_left"), 0.6},
                   PatternDivision::End{LineCalled(pattern, "centre_front"), 0.65}};
  pattern.pieces[front].divisions.push_back(division);
  const auto flat = FlattenPattern(pattern, test::OnTrunk(trunk), {});
  ASSERT_TRUE(flat) << flat.error().Text();
  EXPECT_EQ(flat->pieces.size(), 5U);
  EXPECT_EQ(flat->seams.size(), whole->seams.size() + 3);  // two lines in two seams each, and the division
  EXPECT_LE(LargestMismatch(*flat), 0.1);
  EXPECT_LT(flat->energy, whole->energy);
  double side = 0.0;
  for (const FlatSeam& seam : flat->seams) side += seam.line == "side_left" ? seam.body_mm : 0.0;
  for (const FlatSeam& seam : whole->seams) side -= seam.line == "side_left" ? seam.body_mm : 0.0;
  EXPECT_NEAR(side, 0.0, 1e-9);
  for (const FlatPiece& piece : flat->pieces) {
    EXPECT_EQ(CountFlips(piece.body.sheet, piece.points), 0U);
    const Eigen::Vector2d grain = piece.points[piece.body.grain[1]] - piece.points[piece.body.grain[0]];
    EXPECT_NEAR(grain.x(), 0.0, 1e-9);
    EXPECT_GT(grain.y(), 0.0);
  }
}

TEST(FlattenPattern, RefusesADivisionThatEndsWhereItBegins) {
  const SurfaceSegment cylinder = test::BodyOf(0.0, 300.0, [](double, double) { return 100.0; });
  Pattern panel = Panel();
  panel.pieces[0].divisions.push_back({{PatternDivision::End{0, 0.4}, PatternDivision::End{0, 0.4}}, {}});
  EXPECT_FALSE(FlattenPattern(panel, {cylinder, {}}, {}));
}

TEST(WithProposedCuts, DividesASaddleThatDartsCannotRelieve) {
  // A throat: r falls to 70 mm at z = 90 and rises again; curved inwards everywhere near it.
  const SurfaceSegment throat = test::BodyOf(
      0.0, 300.0, [](double, double z) { return 110.0 - 40.0 * std::exp(-(z - 90.0) * (z - 90.0) / (40.0 * 40.0)); });
  Pattern panel = Panel();
  panel.element_mm = 12.0;
  panel.darts = {0.005, 2, 0};
  const auto darts = WithProposedCuts(panel, {throat, {}}, {});
  ASSERT_TRUE(darts) << darts.error().Text();
  const auto darted = FlattenPattern(*darts, {throat, {}}, {});
  panel.darts.seams = 1;
  const auto proposed = WithProposedCuts(panel, {throat, {}}, {});
  ASSERT_TRUE(proposed) << proposed.error().Text();
  ASSERT_EQ(proposed->pieces[0].divisions.size(), 1U);
  const auto divided = FlattenPattern(*proposed, {throat, {}}, {});
  ASSERT_TRUE(darted && divided);
  EXPECT_EQ(divided->pieces.size(), 2U);
  EXPECT_LE(LargestMismatch(*divided), 0.1);
  EXPECT_LT(divided->energy, 0.5 * darted->energy);
  const auto again = PatternFromJson(PatternToJson(*proposed), "again");
  ASSERT_TRUE(again) << again.error().Text();
  EXPECT_EQ(PatternToJson(*again), PatternToJson(*proposed));
}

TEST(FlattenMesh, ProposesDartsInADome) {
  const TriangleMesh dome = test::Cap(100.0, 0.25 * std::numbers::pi, 16);
  Pattern pattern;
  pattern.name = "dome";
  pattern.darts = {0.01, 0, 0};
  const auto plain = FlattenMesh(dome, pattern, {});
  ASSERT_TRUE(plain) << plain.error().Text();
  EXPECT_TRUE(plain->seams.empty());
  pattern.darts.most = 2;
  const auto darted = FlattenMesh(dome, pattern, {});
  ASSERT_TRUE(darted) << darted.error().Text();
  ASSERT_EQ(darted->seams.size(), 2U);
  EXPECT_LE(LargestMismatch(*darted), 0.1);
  EXPECT_LT(darted->energy, 0.5 * plain->energy);
  EXPECT_EQ(CountFlips(darted->pieces[0].body.sheet, darted->pieces[0].points), 0U);
  // A dart is folded: the cut line passes over its mouth.
  const auto drawn = DrawPattern(pattern, *darted);
  const double area = 2.0 * std::numbers::pi * 1e4 * (1.0 - std::cos(0.25 * std::numbers::pi));  // of the dome
  EXPECT_GT(0.5 * TurnedArea(drawn[0].cut.points), area);
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
