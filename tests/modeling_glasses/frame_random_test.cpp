// Frames drawn at random over all forms, sizes and adjustments: they are closed solids whose outlines do not cross.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "base/units.h"
#include "modeling/bezier/tube_chain.h"
#include "random_designs.h"
#include "winding.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// 10,000 with ANNULUS_LONG=1.
int Draws(int in_short) {
  const char* wanted = std::getenv("ANNULUS_LONG");
  return wanted != nullptr && *wanted == '1' ? 10000 : in_short;
}

double Side(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
  return (b - a).x() * (p - a).y() - (b - a).y() * (p - a).x();
}

/// Pairs of edges of a closed polygon, not neighbours, that cross.
int Crossings(const std::vector<Vector2d>& polygon) {
  const std::size_t n = polygon.size();
  int crossings = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d& a = polygon[i];
    const Vector2d& b = polygon[(i + 1) % n];
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      const Vector2d& c = polygon[j];
      const Vector2d& d = polygon[(j + 1) % n];
      if (Side(a, b, c) * Side(a, b, d) < 0.0 && Side(c, d, a) * Side(c, d, b) < 0.0) ++crossings;
    }
  }
  return crossings;
}

/// A closed curve of the rim at a place across its sections (half widths), in the rim's own plane.
template <typename PlaceOfRow>
std::vector<Vector2d> RimOutline(const Rim& rim, const PlaceOfRow& place) {
  constexpr int kSteps = 24;
  const Eigen::Isometry3d rim_from_frame = rim.frame_from_rim.inverse();
  std::vector<Vector2d> points;
  for (std::size_t k = 0; k < 4; ++k) {
    BezierCurve curve;
    for (std::size_t r = 0; r < 4; ++r) {
      const std::size_t i = (3 * k + r) % 12;
      curve[r] = rim_from_frame * (rim.m[i] + place(i) * rim.half_width[i]);
    }
    for (int step = 0; step < kSteps; ++step) {
      const Vector3d p = CubicBezierPoint(curve, static_cast<double>(step) / kSteps);
      points.emplace_back(p.x(), p.z());
    }
  }
  return points;
}

Frame Drawn(std::mt19937_64& random) {
  const Result<AdjustedDesign> adjusted = AdjustDesign(WildDesign(random));
  EXPECT_TRUE(adjusted) << adjusted.error().Text();
  const Status valid = Validate(adjusted->design);
  EXPECT_TRUE(valid) << valid.error().Text();
  Result<Frame> frame = BuildFrame(adjusted->design, WildAdjustment(random, adjusted->design));
  EXPECT_TRUE(frame) << frame.error().Text();
  return std::move(frame).value();
}

TEST(FrameRandom, OutlinesOfTheRimDoNotCrossThemselves) {
  std::mt19937_64 random(20260801);
  for (int draw = 0; draw < Draws(1000); ++draw) {
    const Frame frame = Drawn(random);
    const Rim& rim = frame.rim;
    EXPECT_EQ(Crossings(RimOutline(rim, [](std::size_t) { return 0.0; })), 0) << "centre line of draw " << draw;
    EXPECT_EQ(Crossings(RimOutline(rim, [](std::size_t) { return -1.0; })), 0) << "inner outline of draw " << draw;
    EXPECT_EQ(Crossings(RimOutline(rim, [](std::size_t) { return 1.0; })), 0) << "outer outline of draw " << draw;
    EXPECT_EQ(Crossings(RimOutline(rim, [&rim](std::size_t i) { return rim.lens_place[i]; })), 0)
        << "lens' outline of draw " << draw;
  }
}

TEST(FrameRandom, EveryShellIsClosedAndHoldsSomething) {
  std::mt19937_64 random(20260802);
  double worst_gap = 0.0;
  for (int draw = 0; draw < Draws(1000); ++draw) {
    const Frame frame = Drawn(random);
    for (const FrameBody& body : FrameBodies(frame)) {
      for (const PatchShell& shell : body.shells) {
        const ShellJoins joins = MeasureJoins(shell);
        ASSERT_EQ(joins.open_edges, 0U) << body.name << " " << shell.name << " of draw " << draw;
        worst_gap = std::max(worst_gap, joins.position_gap);
        ASSERT_GT(Volume(shell), 0.0) << body.name << " " << shell.name << " of draw " << draw;
        const TriangleMesh mesh = Tessellate(shell, {3, 3, 1});
        ASSERT_EQ(CountOpenEdges(mesh), 0U) << body.name << " " << shell.name << " of draw " << draw;
        ASSERT_GT(SignedVolume(mesh), 0.0) << body.name << " " << shell.name << " of draw " << draw;
      }
    }
  }
  EXPECT_LE(worst_gap, 1e-9);
}

TEST(FrameRandom, ChainsJoinWithG1AndRimsWithC1) {
  std::mt19937_64 random(20260803);
  double worst_kink = 0.0;
  double worst_seam = 0.0;
  double worst_join = 0.0;
  for (int draw = 0; draw < Draws(1000); ++draw) {
    const Frame frame = Drawn(random);
    std::vector<BezierTube> tubes(frame.rim_right.begin(), frame.rim_right.end());
    for (const std::vector<BezierTube>& chain : {frame.bridge, frame.arm_right.temple, frame.arm_left.temple,
                                                 frame.arm_right.end_piece, frame.arm_left.end_piece}) {
      worst_kink = std::max(worst_kink, LargestKink(chain));
      tubes.insert(tubes.end(), chain.begin(), chain.end());
    }
    for (const BezierTube& tube : tubes) {
      for (const double u : {0.0, 0.3, 0.7, 1.0}) {
        worst_seam = std::max({worst_seam, (tube.a().DerivativeV(u, 1) - tube.b().DerivativeV(u, 0)).norm(),
                               (tube.b().DerivativeV(u, 1) - tube.a().DerivativeV(u, 0)).norm()});
      }
    }
    for (const auto& rim : {frame.rim_right, frame.rim_left}) {
      for (std::size_t k = 0; k < rim.size(); ++k) {
        for (const double v : {0.0, 0.2, 0.5, 0.8, 1.0}) {
          const BezierTube& next = rim[(k + 1) % rim.size()];
          worst_join = std::max({worst_join, (rim[k].a().DerivativeU(1, v) - next.a().DerivativeU(0, v)).norm(),
                                 (rim[k].b().DerivativeU(1, v) - next.b().DerivativeU(0, v)).norm()});
        }
      }
    }
  }
  EXPECT_LE(worst_kink, 1e-9);  // rad
  EXPECT_LE(worst_seam, 1e-9);  // mm
  EXPECT_LE(worst_join, 1e-9);
}

TEST(FrameRandom, BridgeTemplesAndWiresEndInsideTheRim) {
  std::mt19937_64 random(20260804);
  for (int draw = 0; draw < Draws(200); ++draw) {
    const Frame frame = Drawn(random);
    // Of a half rim too the whole rim is looked at: its ends are tested with the half rims.
    TriangleMesh rim = Tessellate(RimShell("rim", frame.rim, std::nullopt), {16, 12, 2});
    if (frame.design.details.rim == RimForm::kRimless) {
      rim = {};
      for (const FrameBody& body : FrameBodies(frame)) {
        for (const PatchShell& shell : body.shells) {
          if (shell.name.find("mount") == 0 && shell.name.find("right") != std::string::npos) {
            Append(rim, Tessellate(shell, {16, 12, 1}));
          }
        }
      }
    }
    for (double around = 0.0625; around < 1.0; around += 0.125) {
      ASSERT_NEAR(WindingNumber(rim, frame.bridge.front().Point(0, around)), 1.0, 1e-6) << "bridge of draw " << draw;
      ASSERT_NEAR(WindingNumber(rim, frame.arm_right.attachment().Point(1, around)), 1.0, 1e-6)
          << "temple of draw " << draw;
    }
  }
}

/// The shells of a body near a place, as one mesh.
TriangleMesh Near(const FrameBody& body, const Vector3d& place, double radius) {
  TriangleMesh mesh;
  for (const PatchShell& shell : body.shells) {
    TriangleMesh part = Tessellate(shell, {8, 8, 2});
    const bool near = std::any_of(part.vertices.begin(), part.vertices.end(),
                                  [&](const Vector3d& p) { return (p - place).norm() < radius; });
    if (near) Append(mesh, part);
  }
  return mesh;
}

TEST(FrameRandom, OpenTemplesDoNotEnterTheFront) {
  constexpr double kRadius = 6.0;  // mm about the hinge
  std::mt19937_64 random(20260808);
  for (int draw = 0; draw < Draws(100); ++draw) {
    const Frame frame = Drawn(random);
    if (!frame.arm_right.hinge) continue;
    const std::vector<FrameBody>& bodies = FrameBodies(frame);
    const bool rimless = bodies.size() == 5;
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      const Vector3d& hinge = (side == 0 ? frame.arm_right : frame.arm_left).hinge->point;
      const TriangleMesh front = Near(bodies[rimless ? 1 + side : 0], hinge, kRadius);
      const TriangleMesh temple = Near(bodies[bodies.size() - 2 + side], hinge, kRadius);
      for (const auto& [inner, outer] : {std::pair(&front, &temple), std::pair(&temple, &front)}) {
        for (const Vector3d& p : inner->vertices) {
          if ((p - hinge).norm() > kRadius) continue;
          ASSERT_NEAR(WindingNumber(*outer, p), 0.0, 1e-3) << "draw " << draw << " side " << side;
        }
      }
    }
  }
}

TEST(FrameRandom, AdjustingTwiceChangesNothingMore) {
  std::mt19937_64 random(20260805);
  int changed = 0;
  for (int draw = 0; draw < Draws(1000); ++draw) {
    const FrameDesign wild = WildDesign(random);
    const Result<AdjustedDesign> once = AdjustDesign(wild);
    ASSERT_TRUE(once);
    const Result<AdjustedDesign> twice = AdjustDesign(once->design);
    ASSERT_TRUE(twice);
    EXPECT_TRUE(twice->design == once->design) << draw;
    EXPECT_TRUE(twice->messages.empty()) << draw;
    EXPECT_EQ(once->messages.empty(), once->design == wild) << draw;
    changed += once->messages.empty() ? 0 : 1;
  }
  EXPECT_GT(changed, Draws(1000) / 2);  // The draws are wild.
}

}  // namespace
}  // namespace annulus
