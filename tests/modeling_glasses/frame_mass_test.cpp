#include "modeling/glasses/frame_mass.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "modeling/glasses/frame_walls.h"
#include "tests/support/frame_styles.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

struct UnionVolume {
  double volume = 0.0;
  Vector3d first = Vector3d::Zero();
};

/// A body's union by lines along x, `step` apart in y and z, through fine meshes of its shells: what lies in at least
/// one shell.
UnionVolume MeasureUnion(const FrameBody& body, double step) {
  struct Crossing {
    double x;
    int change;
  };
  std::map<std::pair<long, long>, std::vector<Crossing>> lines;
  for (const PatchShell& shell : body.shells) {
    const TriangleMesh mesh = Tessellate(shell, {24, 20, 2});
    for (const auto& face : mesh.faces) {
      const Vector3d& a = mesh.vertices[face[0]];
      const Vector3d& b = mesh.vertices[face[1]];
      const Vector3d& c = mesh.vertices[face[2]];
      const double twice = (b.y() - a.y()) * (c.z() - a.z()) - (b.z() - a.z()) * (c.y() - a.y());
      if (twice == 0.0) continue;
      const auto index = [step](double value) { return static_cast<long>(std::floor(value / step)); };
      for (long i = index(std::min({a.y(), b.y(), c.y()})); i <= index(std::max({a.y(), b.y(), c.y()})); ++i) {
        for (long j = index(std::min({a.z(), b.z(), c.z()})); j <= index(std::max({a.z(), b.z(), c.z()})); ++j) {
          const double y = (static_cast<double>(i) + 0.5123) * step;
          const double z = (static_cast<double>(j) + 0.5321) * step;
          const double wb = ((y - a.y()) * (c.z() - a.z()) - (z - a.z()) * (c.y() - a.y())) / twice;
          const double wc = ((b.y() - a.y()) * (z - a.z()) - (b.z() - a.z()) * (y - a.y())) / twice;
          if (wb < 0.0 || wc < 0.0 || wb + wc > 1.0) continue;
          // A normal to +x (positive turn in y, z) leaves the solid.
          lines[{i, j}].push_back({a.x() + wb * (b.x() - a.x()) + wc * (c.x() - a.x()), twice > 0.0 ? -1 : 1});
        }
      }
    }
  }
  UnionVolume sum;
  for (auto& [place, line] : lines) {
    std::sort(line.begin(), line.end(), [](const Crossing& a, const Crossing& b) { return a.x < b.x; });
    int inside = 0;
    for (std::size_t k = 0; k + 1 < line.size(); ++k) {
      inside += line[k].change;
      if (inside < 1) continue;
      const double volume = (line[k + 1].x - line[k].x) * step * step;
      sum.volume += volume;
      sum.first +=
          volume * Vector3d(0.5 * (line[k + 1].x + line[k].x), (static_cast<double>(place.first) + 0.5123) * step,
                            (static_cast<double>(place.second) + 0.5321) * step);
    }
  }
  return sum;
}

std::vector<FrameDesign> Designs() {
  std::vector<FrameDesign> designs;
  designs.emplace_back(test::PaperStyle("example4"));
  FrameDesign full(test::PaperStyle("boston"));
  full.details.bridge = BridgeForm::kKeyhole;
  full.details.pads = PadForm::kFixed;
  full.details.temple = TempleForm::kSkull;
  full.details.hinge = HingeForm::kBarrel;
  full.details.end_piece = 6.0;
  full.details.arm_width = 4.0;
  full.details.bridge_gap = 18.0;
  full.details.groove_depth = 0.5;
  full.details.groove_width = 1.2;
  full.details.frame_curve = 5.0;
  full.details.face_form = 0.1;
  designs.push_back(full);
  full.details.pads = PadForm::kAdjustable;
  full.details.bridge = BridgeForm::kSaddle;
  full.details.rim = RimForm::kHalf;
  designs.push_back(full);
  full.details.rim = RimForm::kRimless;
  full.details.groove_depth = full.details.groove_width = 0.0;
  designs.push_back(full);
  return designs;
}

TEST(FrameMass, IsThatOfTheUnionOfItsShells) {
  for (const FrameDesign& design : Designs()) {
    const auto frame = BuildFrame(design, StandardAdjustment(design));
    ASSERT_TRUE(frame) << frame.error().Text();
    const FrameMass mass = MassOf(*frame, 1.28);
    ASSERT_EQ(mass.bodies.size(), FrameBodies(*frame).size());
    Vector3d first = Vector3d::Zero();
    double volume = 0.0;
    for (std::size_t k = 0; k < mass.bodies.size(); ++k) {
      const UnionVolume expected = MeasureUnion(FrameBodies(*frame)[k], 0.08);
      EXPECT_NEAR(mass.bodies[k].volume / expected.volume, 1.0, 0.02) << mass.bodies[k].name;
      EXPECT_LT((mass.bodies[k].centre_of_gravity - expected.first / expected.volume).norm(), 0.3)
          << mass.bodies[k].name;
      volume += expected.volume;
      first += expected.first;
    }
    EXPECT_NEAR(mass.volume / volume, 1.0, 0.01);
    EXPECT_NEAR(mass.mass, 1.28e-3 * mass.volume, 1e-9);
    EXPECT_LT((mass.centre_of_gravity - first / volume).norm(), 0.3);
    EXPECT_NEAR(mass.centre_of_gravity.x(), 0.0, 0.02);
  }
}

double WallCalled(const std::vector<Wall>& walls, const std::string& name) {
  for (const Wall& wall : walls) {
    if (wall.name == name) return wall.thickness;
  }
  ADD_FAILURE() << "no wall " << name;
  return 0.0;
}

TEST(FrameWalls, RoundRimIsNinetyThreePercentOfItsThicknessBetweenCorners) {
  // Half widths of a 90° tube are 1, 1/cos 22.5° twice, 1 at -45°, -22.5°, 22.5°, 45° to the middle's normal: in the
  // middle (2 cos 45° + 6)/8 = 0.9268 of d.
  const FrameDesign design(test::PaperStyle("example2"));
  const auto frame = BuildFrame(design, StandardAdjustment(design));
  ASSERT_TRUE(frame);
  const std::vector<Wall> walls = WallsOf(*frame);
  for (const char* name : {"rim_top", "rim_nose", "rim_bottom", "rim_temple"}) {
    EXPECT_NEAR(WallCalled(walls, name), 0.9268 * 2.5, 0.02) << name;
  }
  EXPECT_NEAR(WallCalled(walls, "rim_depth"), 0.75 * 2.5, 1e-12);
  EXPECT_NEAR(WallCalled(walls, "bridge"), 0.75 * 2.5, 0.13);  // It tapers where it enters the rims.
  for (const Wall& wall : walls) EXPECT_GT(wall.thickness, 0.0) << wall.name;
}

TEST(FrameWalls, GrooveLeavesWhatIsBehindAndBesideIt) {
  FrameDesign design(test::PaperStyle("example2"));
  design.details.groove_depth = 0.5;
  design.details.groove_width = 1.2;
  const auto frame = BuildFrame(design, StandardAdjustment(design));
  ASSERT_TRUE(frame);
  const std::vector<Wall> walls = WallsOf(*frame);
  // Lips at v = 0.2 (3v(1 - v) = 1.2/2.5): 2v²(3 - 2v)·1.25 = 0.26 mm from the inner seam; with the groove's 0.5 mm
  // 1.74 of 2.5 mm stay, times 0.9268 between corners.
  EXPECT_NEAR(WallCalled(walls, "rim_top"), 1.74 * 0.9268, 0.02);
  // Half way down, 0.51 mm from the seam, 2v²(3 - 2v)·1.25 = 0.51 at v = 0.2921: the front is 3v(1 - v)·1.25 = 0.7754
  // mm off the middle plane, the flank a quarter of 1.2 mm.
  EXPECT_NEAR(WallCalled(walls, "groove_shoulder"), 0.7727 - 0.3, 1e-3);
}

TEST(FrameWalls, HingesPadsAndMountsHaveTheirs) {
  for (const FrameDesign& design : Designs()) {
    const auto frame = BuildFrame(design, StandardAdjustment(design));
    ASSERT_TRUE(frame);
    const std::vector<Wall> walls = WallsOf(*frame);
    if (design.details.hinge == HingeForm::kBarrel) {
      EXPECT_NEAR(WallCalled(walls, "knuckle"), 0.7, 1e-12);
      // Towards a rimless mount the end piece tapers to the disc's 0.9 mm.
      EXPECT_GT(WallCalled(walls, "end_piece"),
                (design.details.rim == RimForm::kRimless ? 0.5 : 0.68) * design.depth());
      EXPECT_LT(WallCalled(walls, "end_piece"), 0.76 * design.depth());
    }
    if (design.details.pads == PadForm::kAdjustable) {
      EXPECT_GE(WallCalled(walls, "pad_wire"), 0.6);
    }
    if (design.details.rim == RimForm::kRimless) {
      EXPECT_NEAR(WallCalled(walls, "lens_screw"), 1.3, 1e-12);
    }
    EXPECT_NEAR(WallCalled(walls, "temple"), 0.75 * design.depth(), 0.25);
  }
}

}  // namespace
}  // namespace annulus
