#include "modeling/exchange/solid_model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "modeling/exchange/step_file.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/frame_library.h"
#include "modeling/mesh/bvh.h"
#include "modeling/mesh/overlap_volume.h"
#include "tests/support/frame_styles.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// The flat patch with these corners, counter-clockwise seen from outside.
ShellPatch FlatPatch(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  BezierPatch::ControlNet net;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      const double u = static_cast<double>(i) / 3.0;
      const double v = static_cast<double>(j) / 3.0;
      net[i][j] = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d;
    }
  }
  return {BezierPatch(net), PatchDetail::kStraight, PatchDetail::kStraight};
}

/// The box from `low` to `high` as six flat patches.
PatchShell Box(const std::string& name, const Vector3d& low, const Vector3d& high) {
  const auto corner = [&](int x, int y, int z) {
    return Vector3d(x == 0 ? low.x() : high.x(), y == 0 ? low.y() : high.y(), z == 0 ? low.z() : high.z());
  };
  PatchShell shell{name, {}};
  shell.patches.push_back(FlatPatch(corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0), corner(1, 0, 0)));
  shell.patches.push_back(FlatPatch(corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)));
  shell.patches.push_back(FlatPatch(corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1)));
  shell.patches.push_back(FlatPatch(corner(0, 1, 0), corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0)));
  shell.patches.push_back(FlatPatch(corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0)));
  shell.patches.push_back(FlatPatch(corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1)));
  return shell;
}

/// A body of revolution about x that closes at both ends in a pole: a straight tube whose ends have no size.
PatchShell Spindle(double length, double half_size) {
  BezierTube::Sections sections;
  for (std::size_t i = 0; i < 4; ++i) {
    const double size = i == 0 || i == 3 ? 0.0 : half_size;
    sections[i] = {Vector3d(length * static_cast<double>(i) / 3.0, 0, 0), Vector3d(0, 0, size), Vector3d(0, -size, 0)};
  }
  return ShellOfTubes("spindle", {BezierTube(sections)}, TubeEnds::kCapped);
}

bool Inside(const Bvh& solid, const Vector3d& p) {
  // Odd number of crossings along a direction that no edge of ours has.
  Ray ray{p, Vector3d(0.5377, 0.7321, 0.4182).normalized()};
  bool inside = false;
  while (const auto hit = solid.Cast(ray, 1e4)) {
    inside = !inside;
    ray.origin += (hit->distance_mm + 1e-7) * ray.direction;
  }
  return inside;
}

/// Volume of the union of shells: exact volumes less, for each pair, what lies in both and in no shell before; that is
/// sampled in the box that the two have in common.
double SampledUnion(const std::vector<PatchShell>& shells) {
  std::mt19937_64 random(8);
  std::vector<Eigen::AlignedBox3d> boxes;
  std::vector<Bvh> solids;
  double sum = 0.0;
  for (const PatchShell& shell : shells) {
    const TriangleMesh mesh = Tessellate(shell, {.along = 48, .around = 40, .straight = 4});
    boxes.emplace_back();
    for (const Vector3d& v : mesh.vertices) boxes.back().extend(v);
    solids.emplace_back(mesh);
    sum += Volume(shell);
  }
  const auto in = [&](std::size_t k, const Vector3d& p) { return boxes[k].contains(p) && Inside(solids[k], p); };
  for (std::size_t a = 0; a < shells.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const Eigen::AlignedBox3d common = boxes[a].intersection(boxes[b]);
      if (common.isEmpty()) continue;
      constexpr int kSamples = 15000;
      int hits = 0;
      for (int k = 0; k < kSamples; ++k) {
        Vector3d p;
        for (int axis = 0; axis < 3; ++axis) {
          p[axis] = std::uniform_real_distribution<double>(common.min()[axis], common.max()[axis])(random);
        }
        bool counts = in(a, p) && in(b, p);
        for (std::size_t before = 0; before < b && counts; ++before) counts = !in(before, p);
        if (counts) ++hits;
      }
      sum -= common.volume() * hits / kSamples;
    }
  }
  return sum;
}

TEST(OverlapVolume, OfThreeBoxesCountsEachPlaceOnceLessThanItsBoxes) {
  const auto mesh = [](const Vector3d& low, const Vector3d& high) { return Tessellate(Box("b", low, high), {}); };
  const std::vector<TriangleMesh> boxes = {mesh({0, 0, 0}, {2, 2, 2}), mesh({1, 0.5, 0}, {3, 2.5, 2}),
                                           mesh({1.5, 1, 0}, {4, 4, 2})};
  // Sum 8 + 8 + 15 = 31. Pairs overlap in 3, 1 and 4.5 (areas 1·1.5, 0.5·1, 1.5·1.5 times 2), all three in 1.
  EXPECT_NEAR(OverlapVolume(boxes, 0.01), 3.0 + 1.0 + 4.5 - 1.0, 0.06);
  EXPECT_EQ(OverlapVolume({boxes[0]}, 0.1), 0.0);
}

TEST(SolidModel, TwoBoxesBecomeOneSolidOfTheirUnion) {
  const auto body = SolidBodyOf({"boxes", {Box("a", {0, 0, 0}, {4, 3, 2}), Box("b", {3, 1, 1}, {6, 2, 5})}});
  ASSERT_TRUE(body) << body.error().Text();
  EXPECT_TRUE(body->fused()) << body->note();
  EXPECT_NEAR(body->volume(), 24.0 + 12.0 - 1.0, 1e-6);
  const auto skin = SkinOf(*body, 0.1);
  ASSERT_TRUE(skin) << skin.error().Text();
  EXPECT_EQ(CountOpenEdges(*skin), 0U);
  EXPECT_NEAR(SignedVolume(*skin), 35.0, 1e-4);
}

TEST(SolidModel, BoxesThatStandApartStayTwoPieces) {
  const auto body = SolidBodyOf({"boxes", {Box("a", {0, 0, 0}, {1, 1, 1}), Box("b", {2, 0, 0}, {3, 1, 1})}});
  ASSERT_TRUE(body) << body.error().Text();
  EXPECT_TRUE(body->fused()) << body->note();
  EXPECT_NEAR(body->volume(), 2.0, 1e-6);
  const auto text = StepText({*body}, "boxes");
  ASSERT_TRUE(text) << text.error().Text();
  EXPECT_NE(text->find("PRODUCT('boxes_1','boxes_1'"), std::string::npos);
  EXPECT_NE(text->find("PRODUCT('boxes_2','boxes_2'"), std::string::npos);
}

TEST(SolidModel, AShellWithPolesIsASolid) {
  const PatchShell spindle = Spindle(12.0, 2.0);
  const auto body = SolidBodyOf({"spindle", {spindle}});
  ASSERT_TRUE(body) << body.error().Text();
  // Half sizes are 2·3u(1 - u); a section of half sizes h has the area 2.4·h² (see the tube's test);
  // 12·2.4·4·9·∫u²(1 - u)² du = 1036.8·B(3, 3) = 1036.8/30 = 34.56.
  EXPECT_NEAR(body->volume(), 34.56, 1e-3);
  EXPECT_TRUE(SkinOf(*body, 0.01));
}

TEST(SolidModel, AnOpenShellIsRefused) {
  PatchShell open = Box("open", {0, 0, 0}, {1, 1, 1});
  open.patches.pop_back();
  const auto body = SolidBodyOf({"open", {open}});
  ASSERT_FALSE(body);
  EXPECT_NE(body.error().Text().find("do not close"), std::string::npos) << body.error().Text();
}

TEST(SolidModel, EveryStyleIsOneValidSolidOfTheSampledVolume) {
  for (const test::FrameStyle& style : test::FrameStyles()) {
    const auto frame = BuildFrame(style.parameters, StandardAdjustment(style.parameters));
    ASSERT_TRUE(frame);
    for (const FrameBody& part : FrameBodies(*frame)) {
      const auto body = SolidBodyOf({part.name, part.shells});
      ASSERT_TRUE(body) << style.name << ": " << body.error().Text();
      EXPECT_TRUE(body->fused()) << style.name << ": " << body->note();
      EXPECT_EQ(body->pieces(), 1U) << style.name;
      EXPECT_NEAR(body->volume() / SampledUnion(part.shells), 1.0, 1e-3) << style.name;
    }
  }
}

TEST(SolidModel, FramesWithGroovesPadsAndHingesAreSolidsOfTheSampledVolume) {
  for (const char* name : {"wellington", "aviator", "rimless-oval"}) {
    const auto style = BuiltInFrameLibrary().Find(name);
    ASSERT_TRUE(style);
    const auto frame = BuildFrame((*style)->design, StandardAdjustment((*style)->design));
    ASSERT_TRUE(frame);
    for (const FrameBody& part : FrameBodies(*frame)) {
      if (part.name.ends_with("_left")) continue;
      const auto body = SolidBodyOf({part.name, part.shells});
      ASSERT_TRUE(body) << name << " " << part.name << ": " << body.error().Text();
      EXPECT_TRUE(body->fused()) << name << " " << part.name << ": " << body->note();
      EXPECT_NEAR(body->volume() / SampledUnion(part.shells), 1.0, 2e-3) << name << " " << part.name;
    }
  }
}

TEST(SolidModel, TheSkinOfAFrameIsClosedAndHoldsItsVolume) {
  const test::FrameStyle& style = test::FrameStyles()[3];
  const auto frame = BuildFrame(style.parameters, StandardAdjustment(style.parameters));
  ASSERT_TRUE(frame);
  for (const FrameBody& part : FrameBodies(*frame)) {
    const auto body = SolidBodyOf({part.name, part.shells});
    ASSERT_TRUE(body);
    const auto skin = SkinOf(*body, 0.01);
    ASSERT_TRUE(skin) << skin.error().Text();
    EXPECT_EQ(CountOpenEdges(*skin), 0U);
    EXPECT_NEAR(SignedVolume(*skin) / body->volume(), 1.0, 0.01);
  }
}

TEST(StepFile, SameBodiesGiveTheSameBytesWithoutDateOrHost) {
  const auto write = [] {
    const auto body = SolidBodyOf({"box", {Box("a", {0, 0, 0}, {4, 3, 2})}});
    return StepText({*body}, "box").value_or("");
  };
  const std::string first = write();
  EXPECT_EQ(write(), first);
  EXPECT_NE(first.find("FILE_NAME('box','2000-01-01T00:00:00'"), std::string::npos);
  EXPECT_NE(first.find("SI_UNIT(.MILLI.,.METRE.)"), std::string::npos);
  EXPECT_NE(first.find("PRODUCT('box','box'"), std::string::npos);
  EXPECT_NE(first.find("MANIFOLD_SOLID_BREP"), std::string::npos);
}

}  // namespace
}  // namespace annulus
