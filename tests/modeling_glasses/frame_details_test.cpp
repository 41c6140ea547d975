// What paper 000 leaves for later: groove, curve, bridges, pads, half rims and rimless frames.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/units.h"
#include "modeling/bezier/tube_chain.h"
#include "modeling/glasses/bridge.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/hidden_end.h"
#include "modeling/glasses/nose_pad.h"
#include "modeling/glasses/rimless_mount.h"
#include "tests/support/frame_styles.h"
#include "winding.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

FrameDesign Style(const char* name) { return {test::PaperStyle(name)}; }

Frame Build(const FrameDesign& design) {
  Result<Frame> frame = BuildFrame(design, StandardAdjustment(design));
  EXPECT_TRUE(frame) << frame.error().Text();
  return std::move(frame).value();
}

FrameDesign Grooved(const char* style) {
  FrameDesign design = Style(style);
  design.details.groove_depth = 0.5;
  design.details.groove_width = 1.2;
  return design;
}

const PatchShell& Shell(const Frame& frame, const std::string& name) {
  for (const FrameBody& body : FrameBodies(frame)) {
    for (const PatchShell& shell : body.shells) {
      if (shell.name == name) return shell;
    }
  }
  ADD_FAILURE() << "no shell " << name;
  return FrameBodies(frame).front().shells.front();
}

TEST(FrameGroove, IsAsWideAndDeepAsAskedWhereTubesMeet) {
  for (const char* style : {"example2", "example4"}) {
    const FrameDesign design = Grooved(style);
    const Frame frame = Build(design);
    // At M0, M3, M6, M9 half widths are d/2 long, so lengths there are not distorted by a mitre.
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector3d front = frame.rim_right[k].a().Point(0.0, frame.rim.groove_v);
      const Vector3d back = frame.rim_right[k].b().Point(0.0, 1.0 - frame.rim.groove_v);
      EXPECT_NEAR((front - back).norm(), 1.2, 1e-12) << style;
      const Vector3d bottom = CubicBezierPoint(LensCurve(frame.rim, k), 0.0);
      EXPECT_NEAR((0.5 * (front + back) - bottom).norm(), 0.5, 1e-12) << style;
    }
  }
}

TEST(FrameGroove, TakesItsSectionTimesItsLengthFromTheRim) {
  // Section of the cut: a triangle w·depth/2 and what is between lips and seam,
  // 2∫ (s/2)·3v(1 - v) · (d/2)·12v(1 - v) dv = 18·s·d·(v³/3 - v⁴/2 + v⁵/5). It is mitred like the rim's whole section,
  // 2.4·(d/2)(s/2), of which the rim holds 516.306 mm³ (RoundRimHoldsItsSectionSweptAlongItsCentreLine), and lies 1.1
  // mm inside the circle of radius 0.911·25 mm.
  const FrameDesign design = Grooved("example2");
  const Frame grooved = Build(design);
  const Frame plain = Build(Style("example2"));
  const double v = 0.5 * (1.0 - std::sqrt(1.0 - 4.0 / 3.0 * 1.2 / 2.5));
  const double area =
      0.5 * 1.2 * 0.5 + 18.0 * 2.5 * 2.5 * (v * v * v / 3.0 - std::pow(v, 4) / 2.0 + std::pow(v, 5) / 5.0);
  const double length = 516.306 / (2.4 * 1.25 * 1.25) * (1.0 - 1.1 / (0.911 * 25.0));
  const double cut = Volume(Shell(plain, "rim_right")) - Volume(Shell(grooved, "rim_right"));
  EXPECT_NEAR(cut / (area * length), 1.0, 0.015);
}

TEST(FrameGroove, LensOutlineIsItsBottom) {
  const FrameDesign design = Grooved("example3");
  const Frame frame = Build(design);
  // Bottom edges of the flanks in the shell, front view: x to the wearer's left.
  const LensOutline outline = LensOutlineOf(frame, Eye::kRight);
  ASSERT_EQ(outline.points.size(), 720U);
  double worst = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const BezierPatch flank = Shell(frame, "rim_right").patches[4 * k + 2].patch;
    for (int step = 0; step < 180; ++step) {
      const Vector3d p = flank.Point(step / 180.0, 1.0) - frame.rim_centre_right();
      double nearest = 1e9;
      for (const Vector2d& point : outline.points)
        nearest = std::min(nearest, (point - Vector2d(-p.x(), p.z())).norm());
      worst = std::max(worst, nearest);
    }
  }
  EXPECT_LT(worst, 1e-9);
  EXPECT_TRUE(Validate(outline));
}

TEST(FrameGroove, OutlineIsInTheRimsOwnPlaneWhateverItsFaceFormAndCurve) {
  const LensOutline flat = LensOutlineOf(Build(Grooved("boston")), Eye::kRight);
  FrameDesign design = Grooved("boston");
  design.details.face_form = RadiansFromDegrees(15.0);
  design.details.frame_curve = 6.0;
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    const LensOutline wrapped = LensOutlineOf(Build(design), eye);
    const LensOutline expected = eye == Eye::kRight ? flat : Mirrored(flat);
    for (std::size_t k = 0; k < flat.points.size(); ++k) {
      ASSERT_LT((wrapped.points[k] - expected.points[k]).norm(), 1e-12);
    }
  }
}

TEST(FrameCurve, PutsTheLensOutlineOnItsSphere) {
  for (const char* style : {"example2", "rectangle", "example4"}) {
    for (const double curve : {2.0, 4.0, 6.0, 8.0}) {
      FrameDesign design = Grooved(style);
      design.details.frame_curve = curve;
      const Frame frame = Build(design);
      const double radius = 530.0 / curve;
      const Vector3d centre = frame.rim_centre_right() + Vector3d(0.0, frame.rim.sphere_front - radius, 0.0);
      for (std::size_t k = 0; k < 4; ++k) {
        for (double u = 0.0; u <= 1.0; u += 0.125) {
          const Vector3d p = LensPoint(frame.rim, k, u);
          EXPECT_NEAR((p - centre).norm(), radius, 0.12) << style << " " << curve;
        }
      }
      // The lens' middle is the sphere's front-most point.
      EXPECT_NEAR(frame.lens_right.Point(0.5, 0.5).y(), frame.rim.sphere_front, 1e-9);
    }
  }
}

TEST(FrameFaceForm, TurnsEachRimAboutItsCentreNasalSideForward) {
  FrameDesign design = Style("example2");
  design.details.face_form = RadiansFromDegrees(7.0);
  const Frame frame = Build(design);
  const auto m = [&](std::size_t k) { return frame.rim_right[k].CentreLine(0.0); };
  const Vector3d normal = (m(1) - m(0)).cross(m(2) - m(0)).normalized();
  EXPECT_NEAR(std::abs(normal.y()), std::cos(RadiansFromDegrees(7.0)), 1e-12);
  EXPECT_GT(m(1).y(), 0.0);
  EXPECT_LT(m(0).y(), 0.0);
  EXPECT_LT((0.25 * (m(0) + m(1) + m(2) + m(3)) - frame.rim_centre_right()).norm(), 1e-12);
}

TEST(FrameBridge, EndsInsideBothRimsForEveryFormAndGap) {
  for (const BridgeForm form : {BridgeForm::kStraight, BridgeForm::kSaddle, BridgeForm::kKeyhole}) {
    for (double gap = 12.0; gap <= 26.0; gap += 2.0) {
      FrameDesign design = Grooved("example3");
      design.details.bridge = form;
      design.details.bridge_gap = gap;
      design.details.face_form = RadiansFromDegrees(gap / 2.0);
      const Frame frame = Build(design);
      EXPECT_LE(LargestKink(frame.bridge), 1e-9);
      const TriangleMesh right = Tessellate(Shell(frame, "rim_right"), {24, 20, 2});
      const TriangleMesh left = Tessellate(Shell(frame, "rim_left"), {24, 20, 2});
      for (double around = 0.03125; around < 1.0; around += 0.0625) {
        EXPECT_NEAR(WindingNumber(right, frame.bridge.front().Point(0, around)), 1.0, 1e-6) << gap;
        EXPECT_NEAR(WindingNumber(left, frame.bridge.back().Point(1, around)), 1.0, 1e-6) << gap;
      }
      EXPECT_NEAR(frame.bridge_centre().x(), 0.0, 1e-12);
    }
  }
}

TEST(FrameBridge, BowsForwardAndUpByWhatIsAsked) {
  FrameDesign design = Style("example3");
  design.details.bridge_gap = 18.0;
  design.details.bridge_forward = 4.0;
  design.details.bridge_rise = 2.5;
  for (const BridgeForm form : {BridgeForm::kSaddle, BridgeForm::kKeyhole}) {
    design.details.bridge = form;
    const Frame frame = Build(design);
    const Vector3d end = frame.bridge.front().CentreLine(0.0);
    EXPECT_NEAR(frame.bridge_centre().y() - end.y(), 4.0, 1e-12);
    EXPECT_NEAR(frame.bridge_centre().z() - end.z(), 2.5, 1e-12);
    EXPECT_LT((BridgeCentre(design) - frame.bridge_centre()).norm(), 1e-12);
  }
}

TEST(FrameBridge, KeyholeNarrowsBetweenItsFlanks) {
  FrameDesign design = Style("square");
  design.details.bridge_gap = 18.0;
  design.details.bridge = BridgeForm::kKeyhole;
  const Frame frame = Build(design);
  double nearest = 1e9;
  for (const Vector3d& p : Tessellate(Shell(frame, "flank_right"), {}).vertices) nearest = std::min(nearest, p.x());
  const double rims = 0.5 * 18.0 - 0.5 * design.parameters.upper_thickness;
  EXPECT_LT(nearest, rims - 1.5);
  EXPECT_GT(nearest, 3.0);
}

TEST(FramePads, TouchWithASlightlyConvexFaceAtTheirPose) {
  for (const PadForm form : {PadForm::kFixed, PadForm::kAdjustable}) {
    FrameDesign design = Style("boston");
    design.details.bridge_gap = 18.0;
    design.details.pads = form;
    const Frame frame = Build(design);
    const PadPose& pose = frame.adjustment.pad_right;
    double highest = -1e9;
    double nearest = 1e9;
    double low = 0.0;
    double high = 0.0;
    for (const Vector3d& p : Tessellate(Shell(frame, "pad_right"), {24, 24, 1}).vertices) {
      highest = std::max(highest, (p - pose.centre).dot(pose.normal));
      nearest = std::min(nearest, (p - pose.centre).norm());
      if (form == PadForm::kFixed && (p - pose.centre).dot(pose.normal) < -1.2) continue;  // Its neck.
      low = std::min(low, (p - pose.centre).dot(pose.up));
      high = std::max(high, (p - pose.centre).dot(pose.up));
    }
    EXPECT_NEAR(highest, 0.0, 1e-9);
    EXPECT_NEAR(nearest, 0.0, 1e-9);
    EXPECT_NEAR(high - low, design.details.pad_length, form == PadForm::kFixed ? 1.0 : 0.05);
  }
}

TEST(FramePads, WiresRunFromInsideTheRimIntoThePad) {
  FrameDesign design = Grooved("boston");
  design.details.bridge_gap = 18.0;
  design.details.pads = PadForm::kAdjustable;
  const Frame frame = Build(design);
  const TriangleMesh rim = Tessellate(Shell(frame, "rim_right"), {24, 20, 2});
  const TriangleMesh pad = Tessellate(Shell(frame, "pad_right"), {12, 12, 1});
  const PatchShell& wire = Shell(frame, "pad_wire_right");
  for (double v = 0.05; v < 1.0; v += 0.1) {
    EXPECT_NEAR(WindingNumber(rim, wire.patches[0].patch.Point(0, v)), 1.0, 1e-6);
    EXPECT_NEAR(WindingNumber(rim, wire.patches[1].patch.Point(0, v)), 1.0, 1e-6);
    EXPECT_NEAR(WindingNumber(pad, wire.patches[2].patch.Point(1, v)), 1.0, 1e-6);
    EXPECT_NEAR(WindingNumber(pad, wire.patches[3].patch.Point(1, v)), 1.0, 1e-6);
  }
}

TEST(FramePads, StandardPoseHasTheUsualSplayAndFrontalAngle) {
  const FrameDesign design = Style("boston");
  const PadPose pose = StandardAdjustment(design).pad_right;
  // Splay: the face's trace seen from above against the sagittal plane; frontal: seen from the front against it.
  EXPECT_NEAR(std::asin(-pose.normal.y()), RadiansFromDegrees(30.0), 1e-12);
  EXPECT_NEAR(std::atan2(-pose.up.x(), pose.up.z()), RadiansFromDegrees(25.0), 1e-12);
  EXPECT_NEAR(pose.normal.dot(pose.up), 0.0, 1e-12);
  EXPECT_NEAR(pose.normal.norm(), 1.0, 1e-12);
}

TEST(FramePads, RefusesPosesThatAreNone) {
  FrameDesign design = Style("boston");
  design.details.pads = PadForm::kAdjustable;
  FrameAdjustment adjustment = StandardAdjustment(design);
  adjustment.pad_left.normal *= 2.0;
  EXPECT_FALSE(BuildFrame(design, adjustment));
  adjustment = StandardAdjustment(design);
  adjustment.pad_right.normal = -adjustment.pad_right.normal;  // Away from the nose.
  EXPECT_FALSE(BuildFrame(design, adjustment));
  adjustment = StandardAdjustment(design);
  adjustment.pad_right.centre.y() = -80.0;
  EXPECT_FALSE(BuildFrame(design, adjustment));
  adjustment.pad_right.centre.y() = std::nan("");
  EXPECT_FALSE(BuildFrame(design, adjustment));
  design.details.pads = PadForm::kNone;
  EXPECT_TRUE(BuildFrame(design, adjustment));
}

TEST(FrameHalfRim, HoldsBridgeAndTemplesAndIsOpenBelow) {
  FrameDesign design = Grooved("square");
  design.details.rim = RimForm::kHalf;
  const Frame frame = Build(design);
  const PatchShell& shell = Shell(frame, "rim_right");
  EXPECT_EQ(MeasureJoins(shell).open_edges, 0U);
  const TriangleMesh rim = Tessellate(shell, {24, 20, 2});
  EXPECT_EQ(CountOpenEdges(rim), 0U);
  for (double around = 0.03125; around < 1.0; around += 0.0625) {
    EXPECT_NEAR(WindingNumber(rim, frame.bridge.front().Point(0, around)), 1.0, 1e-6);
    EXPECT_NEAR(WindingNumber(rim, frame.arm_right.attachment().Point(1, around)), 1.0, 1e-6);
  }
  EXPECT_NEAR(WindingNumber(rim, frame.rim_right[0].CentreLine(0.5)), 1.0, 1e-6);
  EXPECT_NEAR(WindingNumber(rim, frame.rim_right[2].CentreLine(0.5)), 0.0, 1e-6);
  // The lens keeps its whole outline.
  FrameDesign full = Grooved("square");
  const LensOutline expected = LensOutlineOf(Build(full), Eye::kRight);
  const LensOutline outline = LensOutlineOf(frame, Eye::kRight);
  for (std::size_t k = 0; k < expected.points.size(); ++k) {
    ASSERT_LT((outline.points[k] - expected.points[k]).norm(), 1e-12);
  }
}

TEST(FrameRimless, LensOutlineIsTheCentreLine) {
  FrameDesign design = Style("oval");
  design.details.rim = RimForm::kRimless;
  const Frame frame = Build(design);
  // Boxing A and B are the octagon curve's extent: the same as a rim's centre line, here from its Bezier extremes.
  double widest = 0.0;
  for (const BezierTube& tube : frame.rim_right) {
    for (double u = 0.0; u <= 1.0; u += 1.0 / 512.0) {
      widest = std::max(widest, (tube.CentreLine(u) - frame.rim_centre_right()).x());
    }
  }
  const LensOutline outline = LensOutlineOf(frame, Eye::kRight);
  EXPECT_NEAR(BoxOf(outline).a, 2.0 * widest, 1e-3);
  EXPECT_LT((frame.lens_right.Point(0, 0) - frame.rim_right[0].CentreLine(0)).norm(), 1e-12);
}

TEST(FrameRimless, IsABridgeAndTwoEndPiecesOnTheLenses) {
  FrameDesign design = Style("oval");
  design.details.rim = RimForm::kRimless;
  design.details.bridge = BridgeForm::kSaddle;
  design.details.bridge_gap = 19.0;
  design.details.hinge = HingeForm::kBarrel;
  design.details.end_piece = 5.0;
  design.details.arm_width = 3.0;
  const Frame frame = Build(design);
  std::vector<std::string> names;
  for (const FrameBody& body : FrameBodies(frame)) names.push_back(body.name);
  EXPECT_EQ(names,
            (std::vector<std::string>{"bridge", "end_piece_right", "end_piece_left", "temple_right", "temple_left"}));
  // The holes are inside the lens, at least 2 mm from its edge.
  const LensOutline outline = LensOutlineOf(frame, Eye::kRight);
  for (const RimSide side : {RimSide::kNose, RimSide::kTemple}) {
    const double z = side == RimSide::kNose ? BridgeZ(design) : TempleZ(design);
    const RimlessMount mount = MakeRimlessMount("mount", design, frame.rim, side, z, 2.0);
    const Vector3d hole = mount.frame_from_mount.translation() - frame.rim_centre_right();
    double nearest = 1e9;
    for (const Vector2d& p : outline.points) nearest = std::min(nearest, (p - Vector2d(-hole.x(), hole.z())).norm());
    EXPECT_GT(nearest, 2.0);
    EXPECT_LT(nearest, 3.01);
    // The lens' edge thickness fits between disc and nut.
    EXPECT_NEAR(WindingNumber(Tessellate(mount.shell, {}), mount.frame_from_mount * Vector3d(1.2, 0, 1.05)), 0.0, 1e-6);
    EXPECT_NEAR(WindingNumber(Tessellate(mount.shell, {}), mount.frame_from_mount * Vector3d(1.2, 0, 1.15)), 1.0, 1e-6);
  }
}

TEST(FrameLens, OutlinesOfAllStylesAndFormsCanBeCut) {
  for (const test::FrameStyle& style : test::FrameStyles()) {
    for (const RimForm form : {RimForm::kFull, RimForm::kHalf, RimForm::kRimless}) {
      FrameDesign design(style.parameters);
      design.details.rim = form;
      if (form != RimForm::kRimless) {
        design.details.groove_depth = 0.3;
        design.details.groove_width = 0.8;
      }
      for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
        const Status valid = Validate(LensOutlineOf(Build(design), eye));
        EXPECT_TRUE(valid) << style.name << ": " << valid.error().Text();
      }
    }
  }
}

}  // namespace
}  // namespace annulus
