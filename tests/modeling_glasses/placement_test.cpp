#include "modeling/glasses/placement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/frame_styles.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

/// Eyes 62 mm apart, ears 95 mm behind the forehead.
FacePoints LevelFace() {
  FacePoints face;
  face.eye_right.position = {31, 80, 1580};
  face.eye_left.position = {-31, 80, 1580};
  face.ear_right.position = {76, 4, 1584};
  face.ear_left.position = {-76, 4, 1584};
  face.forehead.position = {0, 99, 1620};
  face.sellion.position = {0, 94, 1588};
  face.pronasale.position = {0, 113, 1550};
  return face;
}

FrameParameters Style(const char* name) { return test::PaperStyle(name); }

void ExpectSmall(const PlacementResiduals& residuals) {
  EXPECT_LE(residuals.eye_right, 1e-6);
  EXPECT_LE(residuals.eye_left, 1e-6);
  EXPECT_LE(residuals.bridge, 1e-6);
  EXPECT_LE(residuals.ear_right, 1e-6);
  EXPECT_LE(residuals.ear_left, 1e-6);
}

/// A vertical cylinder of this radius about the station's axis, z from 1400 to 1700 mm.
SplineSurface Cylinder(double radius) {
  const PeriodicCubicBasis theta(90);
  const ClampedCubicBasis z(UniformBreakpoints(1400, 1700, 30));
  const Eigen::VectorXd constant =
      Eigen::VectorXd::Constant(static_cast<Eigen::Index>(theta.count() * z.count()), radius);
  return SplineSurface(theta, z, constant);
}

TEST(Placement, ScalesTheFrameToThePupillaryDistance) {
  const auto worn = PlaceFrame(Style("example3"), LevelFace());
  ASSERT_TRUE(worn) << worn.error().Text();
  EXPECT_NEAR(worn->design.parameters.width, 62.0 / 1.2, 1e-9);
  EXPECT_NEAR(worn->design.parameters.height, 0.7 * 62.0 / 1.2, 1e-9);
}

TEST(Placement, HoldsTheFirstTwoStepsAfterTheTilt) {
  for (const char* style : {"example1", "example2", "example3", "example4"}) {
    const auto worn = PlaceFrame(Style(style), LevelFace());
    ASSERT_TRUE(worn) << worn.error().Text();
    ExpectSmall(worn->residuals);
    const Frame frame = BuildWornFrame(*worn).value();
    const Vector3d o0 = worn->station_from_frame * frame.rim_centre_right();
    EXPECT_NEAR(o0.x(), 31.0, 1e-9);
    EXPECT_NEAR(o0.z(), 1580.0, 1e-9);
    EXPECT_NEAR((worn->station_from_frame * frame.bridge_centre()).y(), 99.0, 1e-9);
  }
}

TEST(Placement, TiltsTheLowerEdgeTowardsTheFaceByFifteenDegrees) {
  const auto worn = PlaceFrame(Style("example2"), LevelFace());
  ASSERT_TRUE(worn) << worn.error().Text();
  const Vector3d up = worn->station_from_frame.linear() * Vector3d::UnitZ();
  EXPECT_NEAR(up.y(), std::sin(RadiansFromDegrees(15.0)), 1e-12);  // The top leans forward.
  EXPECT_NEAR(up.z(), std::cos(RadiansFromDegrees(15.0)), 1e-12);
  // P3P4 and P1P2 are l2 apart: l2·sin 15° in y.
  const double half = 0.5 * worn->design.parameters.height;
  const Vector3d upper = worn->station_from_frame * Vector3d(0, 0, half);
  const Vector3d lower = worn->station_from_frame * Vector3d(0, 0, -half);
  EXPECT_NEAR(upper.y() - lower.y(), 2.0 * half * std::sin(RadiansFromDegrees(15.0)), 1e-9);
}

TEST(Placement, RollsWithEyesAtDifferentHeights) {
  FacePoints face = LevelFace();
  face.eye_right.position.z() += 3.0;
  face.ear_left.position.y() -= 4.0;
  const auto worn = PlaceFrame(Style("example4"), face);
  ASSERT_TRUE(worn) << worn.error().Text();
  ExpectSmall(worn->residuals);
  EXPECT_NEAR(worn->design.parameters.width, std::hypot(62.0, 3.0) / 1.2, 1e-9);
  EXPECT_GT(worn->l6_left, worn->l6_right);
}

TEST(Placement, TemplesEndOnTheEars) {
  const auto worn = PlaceFrame(Style("example2"), LevelFace());
  ASSERT_TRUE(worn);
  const Frame frame = BuildWornFrame(*worn).value();
  EXPECT_LT((worn->station_from_frame * frame.arm_right.ear_point - Vector3d(76, 4, 1584)).norm(), 1e-9);
  EXPECT_LT((worn->station_from_frame * frame.arm_left.ear_point - Vector3d(-76, 4, 1584)).norm(), 1e-9);
}

TEST(Placement, RefusesImpossibleFaces) {
  FacePoints face = LevelFace();
  std::swap(face.eye_left, face.eye_right);
  auto worn = PlaceFrame(Style("example2"), face);
  ASSERT_FALSE(worn);
  EXPECT_THAT(worn.error().Text(), HasSubstr("right eye"));
  face = LevelFace();
  face.forehead.position.y() = std::nan("");
  EXPECT_FALSE(PlaceFrame(Style("example2"), face));
  face = LevelFace();
  face.ear_left.position.y() = 120.0;
  worn = PlaceFrame(Style("example2"), face);
  ASSERT_FALSE(worn);
  EXPECT_THAT(worn.error().Text(), HasSubstr("left temple"));
  EXPECT_FALSE(PlaceFrame(Style("example2"), LevelFace(), 1.2));
  FrameParameters bad = Style("example2");
  bad.upper_outer = 30.0;
  EXPECT_FALSE(PlaceFrame(bad, LevelFace()));
}

TEST(Placement, MovesForwardJustEnoughToClearTheHead) {
  // On a cylinder the gap of a point is its distance from the axis less the radius, exactly.
  const auto worn = PlaceFrame(Style("example2"), LevelFace());
  ASSERT_TRUE(worn);
  const auto clear = ClearHead(*worn, Cylinder(100.0), 2.0);
  ASSERT_TRUE(clear) << clear.error().Text();
  EXPECT_GT(clear->forward_shift, 1.0);
  ExpectSmall(clear->residuals);
  const WornMeshes meshes = TessellateWornFrame(*clear, {24, 12}, 4).value();
  double nearest = 1e9;
  for (const FrameMesh& part : meshes.parts) {
    if (part.name.substr(0, 3) == "arm") continue;
    for (const Vector3d& p : part.mesh.vertices) nearest = std::min(nearest, std::hypot(p.x(), p.y()));
  }
  EXPECT_NEAR(nearest, 102.0, 0.02);
  EXPECT_NEAR(clear->clearance, 2.0, 1e-3);
}

TEST(Placement, LeavesAFrameThatIsClearWhereItIs) {
  const auto worn = PlaceFrame(Style("example2"), LevelFace());
  ASSERT_TRUE(worn);
  const auto clear = ClearHead(*worn, Cylinder(50.0));
  ASSERT_TRUE(clear);
  EXPECT_EQ(clear->forward_shift, 0.0);
  EXPECT_GT(clear->clearance, 1.0);
}

TEST(Placement, SaysWhenTheHeadCannotBeCleared) {
  const auto worn = PlaceFrame(Style("example2"), LevelFace());
  ASSERT_TRUE(worn);
  const auto clear = ClearHead(*worn, Cylinder(190.0));
  ASSERT_FALSE(clear);
  EXPECT_THAT(clear.error().Text(), HasSubstr("40 mm forward"));
}

TEST(Placement, MeshesAreInTheStationFrame) {
  const auto worn = PlaceFrame(Style("boston"), LevelFace());
  ASSERT_TRUE(worn);
  const WornMeshes meshes = TessellateWornFrame(*worn, {}, 8).value();
  ASSERT_EQ(meshes.parts.size(), 5U);
  ASSERT_EQ(meshes.lenses.size(), 2U);
  for (const FrameMesh& part : meshes.parts) {
    EXPECT_EQ(CountOpenEdges(part.mesh), 0U);
    EXPECT_GT(SignedVolume(part.mesh), 0.0);
    for (const Vector3d& p : part.mesh.vertices) EXPECT_NEAR(p.z(), 1580.0, 60.0);
  }
  for (const Vector3d& p : meshes.lenses[0].mesh.vertices) EXPECT_GT(p.x(), 0.0);
  for (const Vector3d& p : meshes.lenses[1].mesh.vertices) EXPECT_LT(p.x(), 0.0);
}

}  // namespace
}  // namespace annulus
