// Paper 000, §3: what its figures say about control points.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "modeling/glasses/frame.h"
#include "tests/support/frame_styles.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

Frame BuildStyle(const char* name) {
  const FrameDesign design(test::PaperStyle(name));
  Result<Frame> frame = BuildFrame(design, StandardAdjustment(design));
  EXPECT_TRUE(frame) << frame.error().Text();
  return std::move(frame).value();
}

Vector3d M(const Frame& frame, std::size_t i) { return frame.rim_right[(i % 12) / 3].sections()[i % 3].centre; }

constexpr std::array<const char*, 4> kExamples{"example1", "example2", "example3", "example4"};

TEST(PaperFrame, CutsStandAcrossTheBisectorsAndSidesAreParallel) {
  for (const char* name : kExamples) {
    const Frame frame = BuildStyle(name);
    const FrameParameters& p = frame.design.parameters;
    const Vector3d centre = frame.rim_centre_right();
    const double x = 0.5 * p.width;
    const double z = 0.5 * p.height;
    const std::array<Vector3d, 4> corners{centre + Vector3d(x, 0, z), centre + Vector3d(-x, 0, z),
                                          centre + Vector3d(-x, 0, -z), centre + Vector3d(x, 0, -z)};
    const std::array<double, 4> cuts{p.upper_outer, p.upper_inner, p.lower_inner, p.lower_outer};
    for (std::size_t k = 0; k < 4; ++k) {
      // P1M0 ⟂ M11M1, |P1M0| = t, and M0 half way.
      const Vector3d to_m = M(frame, 3 * k) - corners[k];
      EXPECT_NEAR(to_m.norm(), cuts[k], 1e-12) << name;
      EXPECT_NEAR(to_m.dot(M(frame, 3 * k + 1) - M(frame, 3 * k + 11)), 0.0, 1e-9) << name;
      EXPECT_LT((M(frame, 3 * k) - 0.5 * (M(frame, 3 * k + 1) + M(frame, 3 * k + 11))).norm(), 1e-12) << name;
      // 45° to both sides: the same distance from each.
      EXPECT_NEAR(std::abs(to_m.x()), std::abs(to_m.z()), 1e-12) << name;
    }
    // M1M2 // M8M7 and M4M5 // M11M10.
    EXPECT_LT((M(frame, 2) - M(frame, 1)).cross(M(frame, 7) - M(frame, 8)).norm(), 1e-9) << name;
    EXPECT_LT((M(frame, 5) - M(frame, 4)).cross(M(frame, 10) - M(frame, 11)).norm(), 1e-9) << name;
  }
}

TEST(PaperFrame, RimSectionsHaveThePapersWidthsAndDepth) {
  const Frame frame = BuildStyle("example4");
  const FrameParameters& p = frame.design.parameters;
  for (std::size_t k = 0; k < 4; ++k) {
    const BezierTube& tube = frame.rim_right[k];
    for (std::size_t i = 0; i < 4; ++i) {
      // s: the depth of the polygon Q_i2ᴬ Q_i0ᴮ Q_i1ᴮ, all round; it is l1/20.
      EXPECT_NEAR((tube.a().control_point(i, 1) - tube.b().control_point(i, 2)).norm(), p.width / 20.0, 1e-12);
      EXPECT_NEAR((tube.a().control_point(i, 2) - tube.b().control_point(i, 1)).norm(), p.width / 20.0, 1e-12);
    }
    // Q_01Q_02 ⟂ M1M0 and Q_31Q_32 ⟂ M2M3, as long as the paper's d.
    const auto& s = tube.sections();
    EXPECT_NEAR(s[0].half_width.dot(s[1].centre - s[0].centre), 0.0, 1e-9);
    EXPECT_NEAR(s[3].half_width.dot(s[3].centre - s[2].centre), 0.0, 1e-9);
    EXPECT_NEAR(2.0 * s[0].half_width.norm(), k < 2 ? p.upper_thickness : p.lower_thickness, 1e-12);
    // Q11Q12 = Q21Q22 on the upper and lower tubes.
    if (k % 2 == 0) {
      EXPECT_NEAR(s[1].half_width.norm(), s[2].half_width.norm(), 1e-12);
    }
  }
}

TEST(PaperFrame, LensHasTheInnerRimsControlPointsAndFourRaisedThirdPoints) {
  for (const char* name : kExamples) {
    const Frame frame = BuildStyle(name);
    const FrameParameters& p = frame.design.parameters;
    // Q_i0ᴬ of the rim in order: 0, 3, 6, 9 pseudo-inherent, the others representative.
    const auto q = [&](std::size_t i) -> Vector3d { return frame.rim_right[(i % 12) / 3].a().control_point(i % 3, 0); };
    const std::array<std::array<std::size_t, 4>, 4> order{
        {{0, 1, 2, 3}, {11, 99, 99, 4}, {10, 99, 99, 5}, {9, 8, 7, 6}}};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        const Vector3d& control = frame.lens_right.control_point(i, j);
        if (order[i][j] != 99) {
          EXPECT_LT((control - q(order[i][j])).norm(), 1e-12) << name << i << j;
          continue;
        }
        // Third points of the rectangle, P1 at the upper outer corner, raised 3s.
        const Vector3d expected =
            frame.rim_centre_right() + Vector3d(p.width * (0.5 - static_cast<double>(j) / 3.0), 3.0 * p.width / 20.0,
                                                p.height * (0.5 - static_cast<double>(i) / 3.0));
        EXPECT_LT((control - expected).norm(), 1e-12) << name << i << j;
      }
    }
  }
}

TEST(PaperFrame, LensHasALimitNormalWhereItsEdgesShareATangent) {
  for (const char* name : kExamples) {
    const Frame frame = BuildStyle(name);
    for (const double u : {0.0, 1.0}) {
      for (const double v : {0.0, 1.0}) {
        const Vector3d s_u = frame.lens_right.DerivativeU(u, v);
        const Vector3d s_v = frame.lens_right.DerivativeV(u, v);
        EXPECT_LT(s_u.normalized().cross(s_v.normalized()).norm(), 1e-9) << name;
        // On the way to the middle the tangents' cross product tends to it.
        const double step = 1e-5;
        const double u_near = u + step * (0.5 - u);
        const double v_near = v + step * (0.5 - v);
        const Vector3d near = frame.lens_right.DerivativeU(u_near, v_near)
                                  .cross(frame.lens_right.DerivativeV(u_near, v_near))
                                  .normalized();
        EXPECT_LT((frame.lens_right.Normal(u, v) - near).norm(), 1e-3) << name;
      }
    }
  }
}

TEST(PaperFrame, BridgeAndArmsHaveTheUpperRimsWidthAtTheBridgesHeight) {
  for (const char* name : kExamples) {
    const Frame frame = BuildStyle(name);
    const FrameParameters& p = frame.design.parameters;
    ASSERT_EQ(frame.bridge.size(), 1U);
    const auto& bridge = frame.bridge[0].sections();
    const double z = p.bridge_height - 0.5 * p.height;
    for (const std::size_t i : {std::size_t{1}, std::size_t{2}}) {
      EXPECT_NEAR(2.0 * bridge[i].half_width.norm(), p.upper_thickness, 1e-12) << name;
      EXPECT_NEAR(2.0 * bridge[i].half_depth.norm(), p.width / 20.0, 1e-12) << name;
      EXPECT_NEAR(bridge[i].centre.z(), z, 1e-9) << name;
    }
    ASSERT_EQ(frame.arm_right.temple.size(), 2U);
    const auto& f = frame.arm_right.temple[1].sections();
    // In the rim the seams follow its centre line, so the end's height is d1.
    EXPECT_NEAR(2.0 * f[3].half_width.z(), p.upper_thickness, 1e-9) << name;
    EXPECT_NEAR(2.0 * f[2].half_width.norm(), p.upper_thickness, 1e-12) << name;
    EXPECT_NEAR(f[3].centre.z(), z, 1e-9) << name;
    // l0 between the rectangles: M's of the nose side are t/√2 inside their corners.
    const double inner = M(frame, 3).x() - p.upper_inner / std::numbers::sqrt2;
    EXPECT_NEAR(2.0 * inner, p.width / 5.0, 1e-12) << name;
  }
}

TEST(PaperFrame, LengthsOfFigure16AreTenthsOfTheWidth) {
  for (const char* name : kExamples) {
    const Frame frame = BuildStyle(name);
    const double tenth = frame.design.parameters.width / 10.0;
    const auto& r = frame.arm_right.temple[0].sections();
    const auto& f = frame.arm_right.temple[1].sections();
    EXPECT_NEAR((f[3].centre - f[2].centre).norm(), tenth, 1e-9) << name;  // l4
    EXPECT_NEAR((f[2].centre - f[1].centre).norm(), tenth, 1e-9) << name;  // l5
    EXPECT_NEAR((r[3].centre - r[2].centre).norm(), tenth, 1e-9) << name;  // l7
    EXPECT_NEAR((r[2].centre - r[1].centre).norm(), tenth, 1e-9) << name;  // l8
    EXPECT_NEAR((r[1].centre - r[0].centre).norm(), tenth, 1e-9) << name;  // l9
    EXPECT_NEAR((f[1].centre - f[0].centre).norm(), frame.arm_right.l6, 1e-9) << name;
  }
}

}  // namespace
}  // namespace annulus
