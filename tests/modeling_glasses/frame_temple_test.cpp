// Temples, end pieces and hinges.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "base/units.h"
#include "modeling/bezier/tube_chain.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/hinge.h"
#include "tests/support/frame_styles.h"
#include "winding.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

FrameDesign Hinged(TempleForm form) {
  FrameDesign design(test::PaperStyle("boston"));
  FrameDetails& details = design.details;
  details.hinge = HingeForm::kBarrel;
  details.end_piece = 6.0;
  details.arm_width = 4.0;
  details.temple = form;
  details.bridge_gap = 18.0;
  return design;
}

Frame Build(const FrameDesign& design, const FrameAdjustment& adjustment) {
  Result<Frame> frame = BuildFrame(design, adjustment);
  EXPECT_TRUE(frame) << frame.error().Text();
  return std::move(frame).value();
}

/// Ears behind, to the sides of and below where they are on nobody; bowed, tips turned in.
FrameAdjustment Worn(const FrameDesign& design) {
  FrameAdjustment adjustment = StandardAdjustment(design);
  adjustment.temple_right.ear += Vector3d(-3.0, 4.0, 6.0);
  adjustment.temple_left.ear += Vector3d(-4.0, -3.0, -5.0);
  adjustment.temple_right.bow = RadiansFromDegrees(4.0);
  adjustment.temple_left.bow = RadiansFromDegrees(1.0);
  adjustment.temple_right.tip_in = RadiansFromDegrees(8.0);
  return adjustment;
}

TriangleMesh MeshOf(const FrameBody& body, const ShellTessellation& steps) {
  TriangleMesh mesh;
  for (const PatchShell& shell : body.shells) Append(mesh, Tessellate(shell, steps));
  return mesh;
}

/// Length of the centre line of tubes first … last by small chords.
double Chords(const std::vector<BezierTube>& chain, std::size_t first, std::size_t last) {
  double length = 0.0;
  for (std::size_t k = first; k <= last; ++k) {
    for (int step = 0; step < 2000; ++step) {
      length += (chain[k].CentreLine((step + 1) / 2000.0) - chain[k].CentreLine(step / 2000.0)).norm();
    }
  }
  return length;
}

TEST(FrameTemple, LowerEdgeMeetsTheEarWhateverItsForm) {
  for (const TempleForm form : {TempleForm::kPaper, TempleForm::kSkull, TempleForm::kStraight}) {
    const FrameDesign design = Hinged(form);
    const FrameAdjustment adjustment = Worn(design);
    const Frame frame = Build(design, adjustment);
    for (const auto& [arm, ear] : {std::pair(frame.arm_right, adjustment.temple_right.ear),
                                   std::pair(frame.arm_left, adjustment.temple_left.ear)}) {
      EXPECT_LT((arm.ear_point - ear).norm(), 1e-9);
      EXPECT_LT((arm.temple[arm.ear_tube].a().control_point(3, 0) - ear).norm(), 1e-9);
      EXPECT_LE(LargestKink(arm.temple), 1e-9);
    }
  }
}

TEST(FrameTemple, LengthsAreThoseOfItsCentreLine) {
  for (const TempleForm form : {TempleForm::kSkull, TempleForm::kStraight}) {
    FrameDesign design = Hinged(form);
    design.details.tip_length = 45.0;
    const Frame frame = Build(design, Worn(design));
    for (const FrameArm& arm : {frame.arm_right, frame.arm_left}) {
      const double to_bend = Chords(arm.temple, arm.ear_tube + 1, arm.temple.size() - 1);
      const double tip = Chords(arm.temple, 0, arm.ear_tube);
      EXPECT_NEAR(arm.length_to_bend, to_bend, 1e-3);
      EXPECT_NEAR(arm.overall_length, to_bend + tip, 1e-3);
      EXPECT_NEAR(tip, 45.0, 1.0);  // The bend rounds a corner of two 7.5 mm legs.
    }
  }
}

TEST(FrameTemple, StraightTempleWithoutBowIsAsLongAsItsWay) {
  const FrameDesign design = Hinged(TempleForm::kStraight);
  const Frame frame = Build(design, StandardAdjustment(design));
  const FrameArm& arm = frame.arm_right;
  const Vector3d to_ear = arm.temple[arm.ear_tube].CentreLine(1.0) - (arm.hinge->point + Vector3d::Zero());
  EXPECT_NEAR(arm.length_to_bend, std::abs(to_ear.y()) - 0.5 * kHingeGap, 1e-6);
}

TEST(FrameTemple, BowLeavesOutwardAndComesInAtTheEar) {
  const FrameDesign design = Hinged(TempleForm::kSkull);
  FrameAdjustment adjustment = StandardAdjustment(design);
  adjustment.temple_right.bow = RadiansFromDegrees(5.0);
  const Frame frame = Build(design, adjustment);
  const FrameArm& arm = frame.arm_right;
  const BezierTube& side = arm.temple[arm.ear_tube + 1];
  const Vector3d leaving = (side.CentreLine(0.999) - side.CentreLine(1.0)).normalized();
  const Vector3d arriving = (side.CentreLine(0.0) - side.CentreLine(0.001)).normalized();
  EXPECT_NEAR(std::asin(leaving.x()), RadiansFromDegrees(5.0), 2e-3);
  EXPECT_NEAR(std::asin(arriving.x()), RadiansFromDegrees(-5.0), 2e-3);
}

TEST(FrameTemple, TipDropsWidensAndTurnsIn) {
  FrameDesign design = Hinged(TempleForm::kSkull);
  design.details.tip_drop = RadiansFromDegrees(50.0);
  FrameAdjustment adjustment = StandardAdjustment(design);
  adjustment.temple_right.tip_in = RadiansFromDegrees(10.0);
  const Frame frame = Build(design, adjustment);
  const FrameArm& arm = frame.arm_right;
  const Vector3d tip = (arm.temple[1].CentreLine(0.0) - arm.temple[1].CentreLine(1.0)).normalized();
  EXPECT_NEAR(tip.z(), -std::sin(RadiansFromDegrees(50.0)) * std::cos(RadiansFromDegrees(10.0)), 0.02);
  EXPECT_NEAR(tip.x(), -std::sin(RadiansFromDegrees(10.0)), 0.01);
  EXPECT_GT(arm.temple[1].sections()[0].half_width.norm(), 1.5 * arm.temple[1].sections()[3].half_width.norm());
}

TEST(FrameHinge, FrontAndOpenTemplesDoNotOverlap) {
  for (const TempleForm form : {TempleForm::kPaper, TempleForm::kSkull, TempleForm::kStraight}) {
    for (const double end_piece : {3.5, 6.0, 12.0}) {
      FrameDesign design = Hinged(form);
      design.details.end_piece = end_piece;
      const Frame frame = Build(design, Worn(design));
      ASSERT_EQ(FrameBodies(frame).size(), 3U);
      const TriangleMesh front = MeshOf(FrameBodies(frame)[0], {8, 8, 2});
      for (const std::size_t side : {std::size_t{1}, std::size_t{2}}) {
        const TriangleMesh temple = MeshOf(FrameBodies(frame)[side], {8, 8, 2});
        const Vector3d hinge = (side == 1 ? frame.arm_right : frame.arm_left).hinge->point;
        for (const Vector3d& p : temple.vertices) {
          if ((p - hinge).norm() > 8.0) continue;
          ASSERT_NEAR(WindingNumber(front, p), 0.0, 1e-4) << end_piece;
        }
        for (const Vector3d& p : front.vertices) {
          if ((p - hinge).norm() > 8.0) continue;
          ASSERT_NEAR(WindingNumber(temple, p), 0.0, 1e-4) << end_piece;
        }
      }
    }
  }
}

TEST(FrameHinge, LeavesItsGapBetweenEndPieceAndTemple) {
  const FrameDesign design = Hinged(TempleForm::kSkull);
  const Frame frame = Build(design, Worn(design));
  for (const FrameArm& arm : {frame.arm_right, frame.arm_left}) {
    const TubeSection& front = arm.end_piece.front().sections()[0];
    const TubeSection& rear = arm.temple.back().sections()[3];
    EXPECT_NEAR((front.centre - rear.centre).norm(), kHingeGap, 1e-12);
    EXPECT_LT(front.half_width.cross(rear.half_width).norm(), 1e-12);
    EXPECT_NEAR((front.centre - rear.centre).dot(arm.hinge->back), -kHingeGap, 1e-12);
  }
}

TEST(FrameHinge, TempleSwingsFreelyThroughNinetyDegrees) {
  const FrameDesign design = Hinged(TempleForm::kSkull);
  const Frame frame = Build(design, Worn(design));
  const TriangleMesh front = MeshOf(FrameBodies(frame)[0], {8, 8, 2});
  const HingeAxis& axis = *frame.arm_right.hinge;
  for (double degrees = 0.0; degrees <= 90.0; degrees += 15.0) {
    // Closing moves what is behind the axis inward: back turns to -outward.
    const Eigen::Isometry3d closed_from_open = ClosedFromOpen(axis, RadiansFromDegrees(degrees));
    const Vector3d closed = closed_from_open.linear() * axis.back;
    EXPECT_NEAR(closed.dot(axis.outward), -std::sin(RadiansFromDegrees(degrees)), 1e-12);
    for (const Vector3d& p : MeshOf(FrameBodies(frame)[1], {6, 6, 2}).vertices) {
      const Vector3d turned = closed_from_open * p;
      if ((turned - axis.point).norm() > 12.0) continue;
      ASSERT_NEAR(WindingNumber(front, turned), 0.0, 1e-4) << degrees;
    }
  }
}

TEST(FrameHinge, KnucklesHaveARoundHoleForThePin) {
  const FrameDesign design = Hinged(TempleForm::kSkull);
  const Frame frame = Build(design, StandardAdjustment(design));
  const HingeAxis& axis = *frame.arm_right.hinge;
  int knuckles = 0;
  for (const FrameBody& body : FrameBodies(frame)) {
    for (const PatchShell& shell : body.shells) {
      if (shell.name != "knuckle_right") continue;
      ++knuckles;
      double least = 1e9;
      double most = 0.0;
      for (const Vector3d& p : Tessellate(shell, {12, 4, 1}).vertices) {
        const Vector3d away = p - axis.point - (p - axis.point).dot(axis.up) * axis.up;
        least = std::min(least, away.norm());
        most = std::max(most, away.norm());
      }
      EXPECT_NEAR(least, 0.6, 1e-9);
      EXPECT_NEAR(most, 1.3, 1e-3);
      EXPECT_GT(least, 0.5 * kPinDiameter);
      const double third = (axis.height - 2.0 * kKnuckleGap) / 3.0;
      EXPECT_NEAR(Volume(shell), kPi * (1.3 * 1.3 - 0.6 * 0.6) * third, 2e-3 * third * 4.0);
    }
  }
  EXPECT_EQ(knuckles, 3);
}

TEST(FrameHinge, PositionDoesNotDependOnTheEar) {
  const FrameDesign design = Hinged(TempleForm::kStraight);
  const Frame nobody = Build(design, StandardAdjustment(design));
  FrameAdjustment adjustment = StandardAdjustment(design);
  adjustment.temple_right.ear += Vector3d(-5.0, 8.0, -12.0);
  const Frame worn = Build(design, adjustment);
  const auto joint = [](const Frame& frame) -> Vector3d {
    return 0.5 * (frame.arm_right.end_piece[0].CentreLine(0.0) + frame.arm_right.temple.back().CentreLine(1.0));
  };
  EXPECT_LT((joint(nobody) - joint(worn)).norm(), 1e-12);
}

TEST(FrameTemple, RefusesBendsThatNoTempleTakes) {
  const FrameDesign design = Hinged(TempleForm::kSkull);
  FrameAdjustment adjustment = StandardAdjustment(design);
  adjustment.temple_right.bow = 1.0;
  EXPECT_FALSE(BuildFrame(design, adjustment));
  adjustment = StandardAdjustment(design);
  adjustment.temple_left.tip_in = std::nan("");
  EXPECT_FALSE(BuildFrame(design, adjustment));
}

}  // namespace
}  // namespace annulus
