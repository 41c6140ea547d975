#include "modeling/glasses/wall_check.h"

#include <gtest/gtest.h>

#include <cmath>

#include "modeling/bezier/shell_solids.h"
#include "modeling/glasses/frame_library.h"

namespace annulus {
namespace {

/// A plate `thick` mm thick in y about y = `at`.
PatchShell Plate(const std::string& name, double thick, double at) {
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
  place.translation().y() = at;
  return BoxShell(name, place, {10.0, 0.5 * thick, 8.0});
}

TEST(WallCheck, APlateIsAsThickAsItIs) {
  const auto walls = ThinnestWalls({{"body", {Plate("plate", 1.3, 5.0)}}});
  ASSERT_EQ(walls.size(), 1U);
  EXPECT_EQ(walls[0].body, "body");
  EXPECT_EQ(walls[0].shell, "plate");
  EXPECT_NEAR(walls[0].thickness, 1.3, 1e-9);
  EXPECT_NEAR(std::abs(walls[0].place.y() - 5.0), 0.65, 1e-9);
}

TEST(WallCheck, ShellsThatOverlapAreOneWall) {
  // Together from -0.4 to 1.7: each is thinner alone.
  const auto walls = ThinnestWalls({{"body", {Plate("front", 1.5, 0.95), Plate("back", 1.2, 0.2)}}});
  ASSERT_EQ(walls.size(), 2U);
  EXPECT_NEAR(walls[0].thickness, 2.1, 1e-9);
  EXPECT_NEAR(walls[1].thickness, 2.1, 1e-9);
}

TEST(WallCheck, WhatTouchesNothingIsAWallOfItsOwn) {
  const auto walls = ThinnestWalls({{"body", {Plate("thick", 3.0, 0.0), Plate("thin", 0.4, 20.0)}}});
  ASSERT_EQ(walls.size(), 2U);
  EXPECT_EQ(walls[0].shell, "thin");
  EXPECT_NEAR(walls[0].thickness, 0.4, 1e-9);
  EXPECT_NEAR(walls[1].thickness, 3.0, 1e-9);
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
  FrameParameters p;  // s = 2.5: the solid is 1.875 mm deep; the bridge ends at 0.9 of that
  const Status by_design = CheckWalls(Build(p), {1.87, 1.87, 1.87});
  ASSERT_FALSE(by_design);
  EXPECT_NE(by_design.error().Text().find("mm thick: design it deeper (--depth 2."), std::string::npos)
      << by_design.error().Text();
  p.lower_thickness = 1.0;
  const Status across = CheckWalls(Build(FrameDesign(p)), {1.2, 1.2, 1.2});
  ASSERT_FALSE(across);
  EXPECT_NE(across.error().Text().find("--lower-thickness"), std::string::npos) << across.error().Text();
  // The taper of the paper's temple towards the tip's seams is found by rays only.
  const Status measured = CheckWalls(Build(FrameParameters()), {1.6, 1.6, 1.6});
  ASSERT_FALSE(measured);
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
