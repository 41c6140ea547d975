#include "modeling/bezier/patch_shell.h"

#include <gtest/gtest.h>

#include "modeling/glasses/frame.h"
#include "tests/support/frame_styles.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// A straight tube along x: section 2·half_width by 2·half_depth of the control polygon.
BezierTube StraightTube(double length, double half_width, double half_depth) {
  BezierTube::Sections sections;
  for (std::size_t i = 0; i < 4; ++i) {
    sections[i] = {Vector3d(length * static_cast<double>(i) / 3.0, 0, 0), Vector3d(0, 0, half_width),
                   Vector3d(0, -half_depth, 0)};
  }
  return BezierTube(sections);
}

TEST(PatchShell, VolumeOfAStraightTubeIsItsSectionTimesItsLength) {
  // Section: w = -1 + 2(3v² - 2v³), d = 3v(1 - v) in half widths and half depths; its area is
  // 2·∫ d·dw = 2·∫ 3v(1 - v)·12v(1 - v) dv = 72·B(3, 3) = 72/30 = 2.4 of half width times half depth.
  const PatchShell shell = ShellOfTubes("tube", {StraightTube(30.0, 2.0, 1.5)}, TubeEnds::kCapped);
  EXPECT_NEAR(Volume(shell), 2.4 * 2.0 * 1.5 * 30.0, 1e-9);
}

TEST(PatchShell, OfEveryStyleIsClosedAndItsMeshHasItsVolume) {
  for (const test::FrameStyle& style : test::FrameStyles()) {
    const auto frame = BuildFrame(style.parameters, StandardAdjustment(style.parameters));
    ASSERT_TRUE(frame);
    for (const PatchShell& shell : FrameBodies(*frame).front().shells) {
      const ShellJoins joins = MeasureJoins(shell);
      EXPECT_EQ(joins.open_edges, 0U) << style.name << " " << shell.name;
      EXPECT_LT(joins.position_gap, 1e-9) << style.name << " " << shell.name;
      const TriangleMesh mesh = Tessellate(shell, {});
      EXPECT_EQ(CountOpenEdges(mesh), 0U) << style.name << " " << shell.name;
      EXPECT_NEAR(SignedVolume(mesh) / Volume(shell), 1.0, 0.02) << style.name << " " << shell.name;
    }
  }
}

TEST(PatchShell, AMissingPatchLeavesOpenEdges) {
  PatchShell shell = ShellOfTubes("tube", {StraightTube(30.0, 2.0, 1.5)}, TubeEnds::kCapped);
  shell.patches.pop_back();
  EXPECT_EQ(MeasureJoins(shell).open_edges, 2U);
}

}  // namespace
}  // namespace annulus
