#include "station/glasses_views.h"

#include <gtest/gtest.h>

#include "modeling/bezier/bezier_tube.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// A straight tube along x between two places, about (·, y, z), with this half width and half depth.
PatchShell Tube(const std::string& name, double from, double to, double y, double half) {
  BezierTube::Sections sections;
  for (std::size_t i = 0; i < 4; ++i) {
    const double share = static_cast<double>(i) / 3.0;
    sections[i] = {Vector3d(from + share * (to - from), y, 0.0), Vector3d(0, 0, half), Vector3d(0, -half, 0)};
  }
  return ShellOfTubes(name, {BezierTube(sections)}, TubeEnds::kCapped);
}

Eigen::AlignedBox2d BoxOf(const std::vector<ViewLines::Segment>& segments) {
  Eigen::AlignedBox2d box;
  for (const auto& [a, b] : segments) box.extend(a).extend(b);
  return box;
}

TEST(GlassesViews, AreThirdAngle) {
  const Vector3d p(1.0, 2.0, 3.0);
  EXPECT_EQ(InView(FrameView::kFront, p), Eigen::Vector2d(-1.0, 3.0));
  EXPECT_EQ(InView(FrameView::kTop, p), Eigen::Vector2d(-1.0, -2.0));
  EXPECT_EQ(InView(FrameView::kSide, p), Eigen::Vector2d(2.0, 3.0));
}

TEST(GlassesViews, TheOutlineOfATubeIsItsRectangle) {
  const ViewLines lines = VisibleLines({{"b", {Tube("tube", 5.0, 35.0, 0.0, 2.0)}}}, FrameView::kFront);
  Eigen::AlignedBox2d all = BoxOf(lines.outlines);
  if (!lines.creases.empty()) all.extend(BoxOf(lines.creases));
  EXPECT_NEAR(all.min().x(), -35.0, 1e-9);
  EXPECT_NEAR(all.max().x(), -5.0, 1e-9);
  EXPECT_NEAR(all.min().y(), -2.0, 1e-9);
  EXPECT_NEAR(all.max().y(), 2.0, 1e-9);
}

TEST(GlassesViews, WhatStandsBehindIsHidden) {
  const std::vector<FrameBody> bodies = {
      {"b", {Tube("before", 0.0, 30.0, 10.0, 5.0), Tube("behind", 10.0, 20.0, -10.0, 1.0)}}};
  const ViewLines both = VisibleLines(bodies, FrameView::kFront);
  const ViewLines alone = VisibleLines({{"b", {bodies[0].shells[0]}}}, FrameView::kFront);
  EXPECT_EQ(both.outlines.size(), alone.outlines.size());
  EXPECT_EQ(both.creases.size(), alone.creases.size());
}

TEST(GlassesViews, TheSideViewLeavesTheLeftOut) {
  const std::vector<FrameBody> bodies = {
      {"b", {Tube("arm_right", 0.0, 30.0, 0.0, 2.0), Tube("arm_left", -30.0, 0.0, 50.0, 2.0)}}};
  EXPECT_LT(VisibleLines(bodies, FrameView::kSide).box.max().x(), 10.0);
  EXPECT_GT(VisibleLines(bodies, FrameView::kTop).box.sizes().y(), 50.0);
}

}  // namespace
}  // namespace annulus
