#include "modeling/glasses/frame.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <numbers>
#include <random>
#include <string>

#include "base/units.h"
#include "modeling/mesh/mesh_io.h"
#include "tests/support/frame_styles.h"
#include "winding.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

Frame Build(const FrameParameters& parameters) {
  Result<Frame> frame = BuildFrame(parameters, StandardAdjustment(parameters));
  EXPECT_TRUE(frame.has_value()) << frame.error().Text();
  return std::move(frame).value();
}

/// An adjustment whose temples rest on these points.
FrameAdjustment Ears(const Vector3d& right, const Vector3d& left) {
  FrameAdjustment adjustment;
  adjustment.temple_right.ear = right;
  adjustment.temple_left.ear = left;
  return adjustment;
}

Frame BuildStyle(const char* name) { return Build(test::PaperStyle(name)); }

double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

/// Valid parameters drawn at random; invalid draws are drawn again.
FrameParameters RandomParameters(std::mt19937_64& random) {
  for (;;) {
    FrameParameters p;
    p.width = Uniform(random, 35, 65);
    p.height = Uniform(random, 0.4, 1.2) * p.width;
    for (double FrameParameters::*corner : {&FrameParameters::upper_outer, &FrameParameters::upper_inner,
                                            &FrameParameters::lower_outer, &FrameParameters::lower_inner}) {
      p.*corner = Uniform(random, 0.01, 0.35) * std::min(p.width, p.height);
    }
    p.upper_thickness = Uniform(random, 0.01, 0.2) * p.width;
    p.lower_thickness = Uniform(random, 0.01, 0.2) * p.width;
    p.bridge_height = Uniform(random, 0.2, 0.9) * p.height;
    if (Validate(p)) return p;
  }
}

TEST(Frame, QuiteRoundSquareRimIsACircle) {
  // Octagon with t = 0.2516·l1: its curve meets the bisectors at l1/√2 - t = 0.4555·l1 and the axes at
  // l1/2 - t/(4√2) = 0.45552·l1 from the centre; between, no point is 0.05 % off 0.911·l1/2.
  const Frame frame = BuildStyle("example2");
  const double radius = 0.911 * frame.design.parameters.width / 2.0;
  double worst = 0.0;
  for (const BezierTube& tube : frame.rim_right) {
    for (double u = 0.0; u <= 1.0; u += 1.0 / 64.0) {
      worst = std::max(worst, std::abs((tube.CentreLine(u) - frame.rim_centre_right()).norm() / radius - 1.0));
    }
  }
  EXPECT_LT(worst, 0.0005);
}

TEST(Frame, CentreLineTouchesTheBisectorsAtTheCornerCuts) {
  const Frame frame = BuildStyle("example4");
  const FrameParameters& p = frame.design.parameters;
  const double root = std::numbers::sqrt2;
  // The right rim's rectangle: x from l0/2 to l0/2 + l1, z from -l2/2 to l2/2; M_i is t/√2 inside its corner in x and
  // z.
  const double inner = p.bridge_gap() / 2.0;
  const double outer = inner + p.width;
  const double top = p.height / 2.0;
  const Vector3d m0(outer - p.upper_outer / root, 0, top - p.upper_outer / root);
  const Vector3d m3(inner + p.upper_inner / root, 0, top - p.upper_inner / root);
  const Vector3d m6(inner + p.lower_inner / root, 0, -top + p.lower_inner / root);
  const Vector3d m9(outer - p.lower_outer / root, 0, -top + p.lower_outer / root);
  EXPECT_LT((frame.rim_right[0].CentreLine(0) - m0).norm(), 1e-12);
  EXPECT_LT((frame.rim_right[1].CentreLine(0) - m3).norm(), 1e-12);
  EXPECT_LT((frame.rim_right[2].CentreLine(0) - m6).norm(), 1e-12);
  EXPECT_LT((frame.rim_right[3].CentreLine(0) - m9).norm(), 1e-12);
}

TEST(Frame, RimTubesJoinWithC1AlsoWhenUpperAndLowerThicknessDiffer) {
  const Frame frame = BuildStyle("example4");
  for (const auto& rim : {frame.rim_right, frame.rim_left}) {
    for (std::size_t k = 0; k < 4; ++k) {
      const BezierTube& next = rim[(k + 1) % 4];
      for (double v = 0.0; v <= 1.0; v += 0.125) {
        EXPECT_LT((rim[k].a().Point(1, v) - next.a().Point(0, v)).norm(), 1e-12);
        EXPECT_LT((rim[k].b().Point(1, v) - next.b().Point(0, v)).norm(), 1e-12);
        EXPECT_LT((rim[k].a().DerivativeU(1, v) - next.a().DerivativeU(0, v)).norm(), 1e-11);
        EXPECT_LT((rim[k].b().DerivativeU(1, v) - next.b().DerivativeU(0, v)).norm(), 1e-11);
      }
    }
  }
}

TEST(Frame, RimIsAsWideAsItsThicknessAtTheCornersAndThreeQuartersOfSDeep) {
  const Frame frame = BuildStyle("example4");
  const FrameParameters& p = frame.design.parameters;
  const auto width = [](const BezierTube& tube) { return (tube.Point(0, 0.5) - tube.Point(0, 0.0)).norm(); };
  EXPECT_NEAR(width(frame.rim_right[0]), p.upper_thickness, 1e-12);
  EXPECT_NEAR(width(frame.rim_right[1]), p.upper_thickness, 1e-12);
  EXPECT_NEAR(width(frame.rim_right[2]), p.lower_thickness, 1e-12);
  EXPECT_NEAR(width(frame.rim_right[3]), p.lower_thickness, 1e-12);
  const double s = p.width / 20.0;
  for (const BezierTube& tube : frame.rim_right) {
    EXPECT_NEAR(tube.Point(0.37, 0.25).y() - tube.Point(0.37, 0.75).y(), 0.75 * s, 1e-12);
  }
}

TEST(Frame, LensBoundaryIsTheRimsInnerOutline) {
  for (const char* style : {"example1", "example2", "example3", "example4"}) {
    const Frame frame = BuildStyle(style);
    for (double t = 0.0; t <= 1.0; t += 0.0625) {
      const auto inner = [&](std::size_t k, double u) { return frame.rim_right[k].Point(u, 0.0); };
      EXPECT_LT((frame.lens_right.Point(0, t) - inner(0, t)).norm(), 1e-9);
      EXPECT_LT((frame.lens_right.Point(t, 1) - inner(1, t)).norm(), 1e-9);
      EXPECT_LT((frame.lens_right.Point(1, 1 - t) - inner(2, t)).norm(), 1e-9);
      EXPECT_LT((frame.lens_right.Point(1 - t, 0) - inner(3, t)).norm(), 1e-9);
    }
  }
}

TEST(Frame, LensBulgesForwardByTheRaisedControlPoints) {
  // Boundary control points in y = 0, inner four at 3s: the middle is (B1 + B2)²·3s = 0.5625·3s forward.
  const Frame frame = BuildStyle("example3");
  const double s = frame.design.parameters.depth();
  EXPECT_NEAR(frame.lens_right.Point(0.5, 0.5).y(), 0.5625 * 3.0 * s, 1e-12);
  EXPECT_NEAR(frame.lens_left.Point(0.5, 0.5).y(), 0.5625 * 3.0 * s, 1e-12);
  for (const BezierPatch& lens : {frame.lens_right, frame.lens_left}) {
    for (double u = 0.0; u <= 1.0; u += 0.25) {
      for (double v = 0.0; v <= 1.0; v += 0.25) EXPECT_GT(lens.Normal(u, v).y(), 0.3) << u << " " << v;
    }
  }
}

TEST(Frame, LeftIsTheMirrorImageOfRight) {
  const Frame frame = BuildStyle("example4");
  const auto mirror = [](const Vector3d& p) { return Vector3d(-p.x(), p.y(), p.z()); };
  for (std::size_t k = 0; k < 4; ++k) {
    // A and B change sides: around becomes 1 - around.
    const Vector3d left = frame.rim_left[k].Point(0.3, 0.8);
    EXPECT_LT((left - mirror(frame.rim_right[k].Point(0.3, 0.2))).norm(), 1e-12);
  }
  EXPECT_LT((frame.lens_left.Point(0.2, 0.7) - mirror(frame.lens_right.Point(0.7, 0.2))).norm(), 1e-12);
  EXPECT_LT((frame.arm_left.ear_point - mirror(frame.arm_right.ear_point)).norm(), 1e-12);
}

TEST(Frame, LensOutlinesAreCounterClockwiseInFrontView) {
  const Frame frame = BuildStyle("example4");
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    const LensOutline outline = LensOutlineOf(frame, eye);
    double twice_area = 0.0;
    double nasal = 0.0;
    for (std::size_t k = 0; k < outline.points.size(); ++k) {
      const Eigen::Vector2d& a = outline.points[k];
      const Eigen::Vector2d& b = outline.points[(k + 1) % outline.points.size()];
      twice_area += a.x() * b.y() - a.y() * b.x();
      nasal = std::max(nasal, eye == Eye::kRight ? a.x() : -a.x());
    }
    EXPECT_GT(twice_area, 0.0);
    // Seen from the front the right lens has the nose on its right; the rim is half l1 less half its thickness away.
    EXPECT_GT(nasal, 0.5 * frame.design.parameters.width - 1.5 * frame.design.parameters.upper_thickness);
  }
}

TEST(Frame, BridgeAndTemplesEndInsideTheRim) {
  for (const test::FrameStyle& style : test::FrameStyles()) {
    const Frame frame = Build(style.parameters);
    const TriangleMesh right = Tessellate(ShellOfTubes("rim", frame.rim_right, TubeEnds::kLoop), {24, 24, 1});
    const TriangleMesh left = Tessellate(ShellOfTubes("rim", frame.rim_left, TubeEnds::kLoop), {24, 24, 1});
    for (double around = 0.0; around < 1.0; around += 0.0625) {
      EXPECT_NEAR(WindingNumber(right, frame.bridge[0].Point(0, around)), 1.0, 1e-6) << style.name;
      EXPECT_NEAR(WindingNumber(left, frame.bridge[0].Point(1, around)), 1.0, 1e-6) << style.name;
      EXPECT_NEAR(WindingNumber(right, frame.arm_right.temple[1].Point(1, around)), 1.0, 1e-6) << style.name;
      EXPECT_NEAR(WindingNumber(left, frame.arm_left.temple[1].Point(1, around)), 1.0, 1e-6) << style.name;
    }
    EXPECT_NEAR(WindingNumber(right, Vector3d::Zero()), 0.0, 1e-6);
  }
}

TEST(Frame, BridgeIsAtItsHeightAndStraight) {
  const Frame frame = BuildStyle("example4");
  const FrameParameters& p = frame.design.parameters;
  const Vector3d centre(0, 0, p.bridge_height - p.height / 2.0);
  EXPECT_LT((frame.bridge_centre() - centre).norm(), 1e-12);
  EXPECT_LT((frame.bridge[0].CentreLine(0.5) - centre).norm(), 1e-12);
  for (double u = 0.0; u <= 1.0; u += 0.1) EXPECT_NEAR(frame.bridge[0].CentreLine(u).z(), centre.z(), 1e-9);
}

TEST(Frame, TempleTurnsNinetyDegreesAndBendsFortyFiveBehindTheEar) {
  const Frame frame = BuildStyle("example2");
  const auto& f = frame.arm_right.temple[1].sections();
  const auto& r = frame.arm_right.temple[0].sections();
  const double l4 = frame.design.parameters.width / 10.0;
  const Vector3d start = f[2].centre - f[3].centre;
  const Vector3d back = f[0].centre - f[1].centre;
  EXPECT_NEAR(start.norm(), l4, 1e-9);
  EXPECT_NEAR((f[1].centre - f[2].centre).norm(), l4, 1e-9);
  EXPECT_NEAR(back.norm(), frame.arm_right.l6, 1e-9);
  EXPECT_NEAR(start.normalized().dot(back.normalized()), 0.0, 1e-9);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR((r[i].centre - r[i + 1].centre).norm(), l4, 1e-9);
  const Vector3d first = (r[2].centre - r[3].centre).normalized();
  const Vector3d last = (r[0].centre - r[1].centre).normalized();
  EXPECT_NEAR(std::acos(first.dot(last)), RadiansFromDegrees(45.0), 1e-9);
  EXPECT_LT(last.z(), -0.7);  // Downwards.
  EXPECT_NEAR(2.0 * f[1].half_width.norm(), frame.design.parameters.upper_thickness, 1e-12);
  EXPECT_NEAR(2.0 * f[0].half_width.norm(), frame.design.parameters.depth(), 1e-12);
  EXPECT_NEAR(2.0 * r[0].half_width.norm(), frame.design.parameters.upper_thickness, 1e-12);
}

TEST(Frame, TempleMeetsTheEarPointsAndItsPartsJoinWithG1) {
  FrameParameters p = test::PaperStyle("example4");
  const FrameAdjustment ears = Ears(Vector3d(82, -101, 6), Vector3d(-75, -95, -9));
  const Result<Frame> frame = BuildFrame(p, ears);
  ASSERT_TRUE(frame) << frame.error().Text();
  EXPECT_LT((frame->arm_right.temple[0].a().control_point(3, 0) - ears.temple_right.ear).norm(), 1e-12);
  EXPECT_LT((frame->arm_left.temple[0].a().control_point(3, 0) - ears.temple_left.ear).norm(), 1e-12);
  for (const FrameArm& arm : {frame->arm_right, frame->arm_left}) {
    for (double v = 0.0; v <= 1.0; v += 0.125) {
      for (const auto& [rear, front] :
           {std::pair(arm.temple[0].a(), arm.temple[1].a()), std::pair(arm.temple[0].b(), arm.temple[1].b())}) {
        EXPECT_LT((rear.Point(1, v) - front.Point(0, v)).norm(), 1e-9);
        const Vector3d before = rear.DerivativeU(1, v).normalized();
        const Vector3d after = front.DerivativeU(0, v).normalized();
        EXPECT_LT(before.cross(after).norm(), 1e-9);
        EXPECT_GT(before.dot(after), 0.0);
      }
    }
  }
}

TEST(Frame, RefusesEarsThatATempleCannotReach) {
  const FrameParameters p;
  EXPECT_FALSE(BuildFrame(p, Ears(Vector3d(75, 20, 0), Vector3d(-75, -95, 0))));    // In front.
  EXPECT_FALSE(BuildFrame(p, Ears(Vector3d(75, -95, 0), Vector3d(-75, -20, 0))));   // Too near.
  EXPECT_FALSE(BuildFrame(p, Ears(Vector3d(300, -95, 0), Vector3d(-75, -95, 0))));  // Far to the side.
  EXPECT_FALSE(BuildFrame(p, Ears(Vector3d(std::nan(""), -95, 0), Vector3d(-75, -95, 0))));
  FrameParameters bad;
  bad.height = -1.0;
  EXPECT_FALSE(BuildFrame(bad, Ears(Vector3d(75, -95, 0), Vector3d(-75, -95, 0))));
}

TEST(Frame, EveryPartIsAClosedSolidForRandomParameters) {
  std::mt19937_64 random(20260101);
  for (int k = 0; k < 300; ++k) {
    const Frame frame = Build(RandomParameters(random));
    for (const FrameMesh& part : TessellateFrameParts(frame, {6, 4})) {
      EXPECT_EQ(CountOpenEdges(part.mesh), 0U) << part.name;
      EXPECT_GT(SignedVolume(part.mesh), 0.0) << part.name;
    }
  }
}

TEST(Frame, RoundRimHoldsItsSectionSweptAlongItsCentreLine) {
  // 4 · 2.4·(d/2)(s/2) ∫ |C'(u) × h(u)| du, h the section's direction: 2.4 is the section's area for unit half sizes
  // (see the tube's test). numpy, with c = 1/√2, t = 0.2516 and Bernstein rows B of u = linspace(0, 1, 2001):
  //   C = B @ [[-.5+t*c,.5-t*c], [-.5+2**.5*t,.5], [.5-2**.5*t,.5], [.5-t*c,.5-t*c]]
  //   h = B @ [[-c,c], [-c,1+c]/(1+c), [c,1+c]/(1+c), [c,c]]; 4*trapz(|cross(C', h)|, u)*50*2.4*.25*2.5*2.5 = 516.306
  const Frame frame = BuildStyle("example2");
  EXPECT_NEAR(SignedVolume(Tessellate(ShellOfTubes("rim", frame.rim_right, TubeEnds::kLoop), {48, 48, 1})), 516.306,
              1.5);
}

/// What admesh prints about a file; empty if admesh is not installed.
std::string RunAdmesh(const std::string& path) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(("admesh '" + path + "' 2>/dev/null").c_str(), "r"), pclose);
  std::string text;
  char buffer[256];
  while (pipe && std::fgets(buffer, sizeof buffer, pipe.get()) != nullptr) text += buffer;
  return text;
}

/// The first number after `label` in admesh's report.
double NumberAfter(const std::string& report, const std::string& label) {
  const std::size_t at = report.find(label);
  if (at == std::string::npos) return -1.0;
  return std::strtod(report.c_str() + report.find_first_of("-0123456789", at + label.size()), nullptr);
}

TEST(Frame, AdmeshFindsTheStlClosed) {
  const Frame frame = BuildStyle("example4");
  const std::string path = testing::TempDir() + "annulus_frame_example4.stl";
  const TriangleMesh mesh = TessellateFrame(frame, {});
  std::ofstream(path, std::ios::binary) << WriteStl(mesh, "annulus frame");
  const std::string report = RunAdmesh(path);
  std::remove(path.c_str());
  if (report.empty()) GTEST_SKIP() << "admesh is not installed";
  EXPECT_EQ(NumberAfter(report, "Number of parts"), 5.0) << report;
  EXPECT_EQ(NumberAfter(report, "Total disconnected facets"), 0.0) << report;
  EXPECT_EQ(NumberAfter(report, "Degenerate facets"), 0.0) << report;
  EXPECT_EQ(NumberAfter(report, "Facets reversed"), 0.0) << report;
  EXPECT_NEAR(NumberAfter(report, "Volume"), SignedVolume(mesh), 0.5) << report;
  EXPECT_GT(NumberAfter(report, "Volume"), 1000.0) << report;
}

}  // namespace
}  // namespace annulus
