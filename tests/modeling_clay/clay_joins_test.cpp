#include "modeling/clay/clay_joins.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "modeling/clay/clay_convert.h"
#include "modeling/clay/clay_operation.h"
#include "tests/modeling_clay/clay_check.h"
#include "tests/modeling_clay/clay_surfaces.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

TEST(ClayJoins, SeeAKinkAndAGapOfKnownSize) {
  auto mesh = ClayMesh::Make(ClayBlock());
  ASSERT_TRUE(mesh);
  EXPECT_LT(MeasureJoins(*mesh).largest_kink_rad, 1e-12);
  EXPECT_LT(MeasureJoins(*mesh).largest_gap_mm, 1e-14);
  const BezierPatch::ControlNet flat = mesh->patch(14).net;
  // An inner patch of the top whose second row along an edge is lifted by a tenth of its distance: atan(0.1).
  BezierPatch::ControlNet net = flat;
  const double step = net[1][0].x() - net[0][0].x();
  for (std::size_t j = 0; j < 4; ++j) net[1][j].z() += 0.1 * step;
  mesh->SetNet(14, net);
  EXPECT_NEAR(MeasureJoins(*mesh).largest_kink_rad, std::atan(0.1), 1e-12);
  net = flat;
  for (std::size_t j = 0; j < 4; ++j) net[0][j].z() += 0.02;
  mesh->SetNet(14, net);
  EXPECT_NEAR(MeasureJoins(*mesh).largest_gap_mm, 0.02, 1e-15);
}

TEST(ClayJoins, StaySmoothAtThePolesOfAModel) {
  auto made = ClayFromSurface(test::Wavy());
  ASSERT_TRUE(made) << made.error().Text();
  ClayBody& body = made->body;
  // The middle of the upper cap, where all of its patches meet.
  const auto cap = static_cast<std::uint32_t>(made->columns * (made->rows + 1));
  ToolHold hold;
  hold.at = {cap, 0.5, 0.95};
  hold.radius_mm = 40.0;
  for (const double depth : {5.0, -3.0, 4.0}) {
    const auto report = Perform(body, PushAct{hold, depth, 1, 2.0});
    ASSERT_TRUE(report) << report.error().Text();
  }
  const ClayJoinQuality quality = MeasureJoins(body.mesh());
  EXPECT_LE(quality.largest_gap_mm, 1e-9);
  EXPECT_LE(quality.largest_kink_rad, 1e-6);
  EXPECT_LE(quality.largest_kink_elsewhere_rad, 1e-3);
}

/// A block whose top and bottom are regular polygons of `sides` corners, each cut into `sides` patches that meet in its
/// middle: a corner of that many edges in a plane.
PatchShell Prism(std::size_t sides, double radius, double height) {
  const auto corner = [&](std::size_t n, double z) {
    const double turn = 2.0 * std::numbers::pi * static_cast<double>(n % sides) / static_cast<double>(sides);
    return Vector3d(radius * std::cos(turn), radius * std::sin(turn), z);
  };
  const auto middle = [&](std::size_t n, double z) { return Vector3d(0.5 * (corner(n, z) + corner(n + 1, z))); };
  const auto flat = [](const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
    return ShellPatch{RuledPatch(StraightCurve(a, d), StraightCurve(b, c))};
  };
  PatchShell shell;
  for (std::size_t n = 0; n < sides; ++n) {
    const std::size_t before = n + sides - 1;
    shell.patches.push_back(flat(Vector3d(0, 0, 0), middle(before, 0), corner(n, 0), middle(n, 0)));
    shell.patches.push_back(
        flat(Vector3d(0, 0, -height), middle(n, -height), corner(n, -height), middle(before, -height)));
    for (const auto& [from, to] : {std::pair{middle(before, 0), corner(n, 0)}, {corner(n, 0), middle(n, 0)}}) {
      const Vector3d down(0, 0, -height);
      shell.patches.push_back(flat(from + down, to + down, to, from));
    }
  }
  return shell;
}

/// The angle between the normals of all leaves that meet at the corner u = v = 0 of patch 0.
double KinkAtMiddle(const ClayMesh& mesh) {
  const ClayMesh::Leaf leaf = mesh.Locate({0, 0.0, 0.0});
  std::vector<Vector3d> normals;
  for (const PatchCorner& at : mesh.vertex(mesh.patch(leaf.patch).vertex[0]).corners) {
    const double u = at.corner == 1 || at.corner == 2 ? 1.0 : 0.0;
    normals.push_back(BezierPatch(mesh.patch(at.patch).net).Normal(u, at.corner >= 2 ? 1.0 : 0.0));
  }
  double kink = 0.0;
  for (const Vector3d& normal : normals) kink = std::max(kink, normal.cross(normals.front()).norm());
  return kink;
}

TEST(ClayJoins, ShareTheirPlaneAtCornersOfThreeFiveAndSix) {
  for (const std::size_t sides : {3U, 5U, 6U}) {
    auto body = ClayBody::Make(Prism(sides, 30.0, 20.0));
    ASSERT_TRUE(body) << body.error().Text();
    const double area =
        0.5 * static_cast<double>(sides) * std::sin(2.0 * std::numbers::pi / static_cast<double>(sides));
    EXPECT_NEAR(body->volume(), area * 900.0 * 20.0, 1e-9);
    ToolHold hold;
    hold.at = {0, 0.1, 0.2};
    hold.radius_mm = 5.0;
    for (const double depth : {1.0, -0.5, 0.7}) {
      const auto report = Perform(*body, PushAct{hold, depth, 1, 2.0});
      ASSERT_TRUE(report) << report.error().Text();
    }
    EXPECT_LE(KinkAtMiddle(body->mesh()), 1e-9) << sides;
    EXPECT_EQ(test::Unsound(body->mesh(), 1e-9), "");
    const ClayJoinQuality quality = MeasureJoins(body->mesh());
    EXPECT_LE(quality.largest_kink_rad, 1e-6);
    EXPECT_LE(quality.largest_kink_elsewhere_rad, 1e-3);
    // Along the edges that end there the patches were never C1: what they do is told.
    EXPECT_GT(quality.largest_kink_not_c1_rad, 1e-3);
    RecordProperty("kink_not_c1_1e6_rad", static_cast<int>(1e6 * quality.largest_kink_not_c1_rad));
  }
}

}  // namespace
}  // namespace annulus
