#include "modeling/glasses/wall_check.h"

#include <gtest/gtest.h>

#include "modeling/glasses/frame_library.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// A straight tube along x whose section is 2·half_width by 2·0.75·half_depth.
PatchShell Tube(const std::string& name, double half_width, double half_depth, const Vector3d& offset) {
  BezierTube::Sections sections;
  for (std::size_t i = 0; i < 4; ++i) {
    sections[i] = {offset + Vector3d(10.0 * static_cast<double>(i), 0, 0), Vector3d(0, 0, half_width),
                   Vector3d(0, -half_depth, 0)};
  }
  return ShellOfTubes(name, {BezierTube(sections)}, TubeEnds::kCapped);
}

TEST(WallCheck, ABandIsAsThickAsItsSection) {
  // Much wider than deep: the ray through its middle is 2·0.75·half_depth long, and thinner only towards its seams.
  const auto walls = ThinnestWalls({{"body", {Tube("band", 10.0, 1.0, Vector3d::Zero())}}});
  ASSERT_EQ(walls.size(), 1U);
  EXPECT_EQ(walls[0].body, "body");
  EXPECT_EQ(walls[0].shell, "band");
  EXPECT_LE(walls[0].thickness, 1.5);
  EXPECT_GT(walls[0].thickness, 0.5);
}

TEST(WallCheck, ShellsThatOverlapAreOneWall) {
  // Two bands, each 1.5 deep, the second 1 mm behind the first: together 2.5.
  const PatchShell front = Tube("front", 10.0, 1.0, Vector3d(0, 0.5, 0));
  const PatchShell back = Tube("back", 10.0, 1.0, Vector3d(0, -0.5, 0));
  const double alone = ThinnestWalls({{"body", {front}}}).at(0).thickness;
  const double together = ThinnestWalls({{"body", {front, back}}}).at(0).thickness;
  EXPECT_NEAR(together - alone, 1.0, 0.3);
}

Frame Build(const FrameDesign& design) {
  auto frame = BuildFrame(design, StandardAdjustment(design));
  EXPECT_TRUE(frame) << frame.error().Text();
  return *frame;
}

TEST(WallCheck, ThePaperSSolidIsThreeQuartersOfS) {
  FrameParameters p;  // s = l1/20 = 2.5: 1.875 mm
  EXPECT_FALSE(CheckWalls(Build(p), {1.9, 1.9, 1.9}));
  const auto walls = ThinnestWalls(FrameBodies(Build(p)));
  for (const WallPlace& wall : walls) EXPECT_LE(wall.thickness, 1.875 + 1e-6) << wall.shell;
  EXPECT_TRUE(CheckWalls(Build(p), {1.0, 1.0, 1.0}));
}

TEST(WallCheck, AnErrorNamesPartPlaceThicknessAndWhatToChange) {
  FrameParameters p;
  const Status by_design = CheckWalls(Build(p), {2.0, 2.0, 2.0});
  ASSERT_FALSE(by_design);
  // 2.0 / 0.75 = 2.67.
  EXPECT_NE(by_design.error().Text().find("--depth 2.67"), std::string::npos) << by_design.error().Text();
  p.lower_thickness = 1.0;
  FrameDesign thin(p);
  const Status measured = CheckWalls(Build(thin), {1.2, 1.2, 1.2});
  ASSERT_FALSE(measured);
  EXPECT_NE(measured.error().Text().find("rim_"), std::string::npos) << measured.error().Text();
  EXPECT_NE(measured.error().Text().find("mm thick at x "), std::string::npos) << measured.error().Text();
}

TEST(WallCheck, ADeepGrooveLeavesAThinWall) {
  FrameParameters p;
  p.upper_thickness = p.lower_thickness = 2.5;
  FrameDesign grooved(p);
  grooved.details.depth = 4.0;
  const double plain = ThinnestWalls(FrameBodies(Build(grooved))).front().thickness;
  grooved.details.groove_width = 1.4;
  grooved.details.groove_depth = 0.8;
  double rim = 1e9;
  for (const WallPlace& wall : ThinnestWalls(FrameBodies(Build(grooved)))) {
    if (wall.shell == "rim_right") rim = wall.thickness;
  }
  EXPECT_LT(rim, plain);
}

TEST(WallCheck, LimitsFollowTheMaterial) {
  EXPECT_EQ(UsualWallLimits(std::nullopt).fittings, 0.8);
  EXPECT_EQ(UsualWallLimits(DesignMaterial::kAcetate).frame, 0.8);
  EXPECT_EQ(UsualWallLimits(DesignMaterial::kMetal).frame, 0.5);
  EXPECT_EQ(UsualWallLimits(DesignMaterial::kMetal).fittings, 0.0);
}

}  // namespace
}  // namespace annulus
