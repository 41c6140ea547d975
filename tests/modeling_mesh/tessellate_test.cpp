#include "modeling/mesh/tessellate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

// A surface of constant radius: B-splines sum to one.
SurfaceSegment Cylinder(double radius, double z_min, double z_max) {
  const PeriodicCubicBasis theta(12);
  const ClampedCubicBasis z(UniformBreakpoints(z_min, z_max, 5));
  const auto count = static_cast<Eigen::Index>(theta.count() * z.count());
  return {.name = "body",
          .surface = SplineSurface(theta, z, Eigen::VectorXd::Constant(count, radius)),
          .knowledge = {},
          .normal_matrix = {}};
}

TEST(TessellateSurface, ClosesACylinder) {
  TessellationOptions options;
  options.theta_count = 90;
  options.ends = EndClosure::kBoth;
  const TriangleMesh mesh = TessellateSurface(Cylinder(100.0, 500.0, 700.0), options);
  EXPECT_EQ(CountOpenEdges(mesh), 0U);
  EXPECT_EQ(mesh.faces.size(), 2U * 90U * 50U + 2U * 90U);
  // A prism over a regular 90-gon.
  const double area = 0.5 * 90.0 * 1e4 * std::sin(kTwoPi / 90.0);
  EXPECT_NEAR(SignedVolume(mesh), area * 200.0, 1e-6 * area);
  EXPECT_NEAR(SurfaceArea(mesh), 2.0 * area + 90.0 * 200.0 * std::sin(kPi / 90.0) * 200.0, 1e-6);
}

TEST(TessellateSurface, StandsAroundAnAxisOfItsOwn) {
  SurfaceSegment limb = Cylinder(40.0, 0.0, 100.0);
  limb.axis = {0.0, {200.0, -30.0}, {0.5, 0.0}, {0.0, 0.001}};
  for (const Eigen::Vector3d& p : TessellateSurface(limb, {}).vertices) {
    const Eigen::Vector2d centre(200.0 + 0.5 * p.z(), -30.0 + 0.001 * p.z() * p.z());
    EXPECT_NEAR((p.head<2>() - centre).norm(), 40.0, 1e-9);
  }
}

TEST(TessellateSurface, LeavesTheEndsOpenUnlessAsked) {
  TessellationOptions options;
  options.theta_count = 60;
  EXPECT_EQ(CountOpenEdges(TessellateSurface(Cylinder(100.0, 0.0, 50.0), options)), 120U);
  options.ends = EndClosure::kAbove;
  EXPECT_EQ(CountOpenEdges(TessellateSurface(Cylinder(100.0, 0.0, 50.0), options)), 60U);
}

TEST(TessellateSurface, LeavesOutWhatIsNotKnown) {
  SurfaceSegment segment = Cylinder(100.0, 0.0, 100.0);
  segment.knowledge = KnowledgeMap(90, 10, 0.0, 100.0);
  for (std::size_t row = 0; row < 10; ++row) {
    for (std::size_t column = 0; column < 90; ++column) {
      if (row < 8)
        segment.knowledge.SetCell(column, row, column == 7 && row == 4 ? Knowledge::kUnknown : Knowledge::kMeasured);
    }
  }
  TessellationOptions options;
  options.theta_count = 90;
  options.max_z_spacing_mm = 10.0;
  options.ends = EndClosure::kBoth;
  const TriangleMesh mesh = TessellateSurface(segment, options);
  // Corners lie at column i, height 10 j; the unknown cell takes the corner (7, 4) and with it four cells; rows of
  // corners 8, 9, 10 are unknown, which leaves seven rows of cells. The lower fan is made, the upper is not.
  EXPECT_EQ(mesh.faces.size(), 2U * (90U * 7U - 4U) + 90U);
  EXPECT_EQ(CountOpenEdges(mesh), 90U + 8U);
  EXPECT_GT(SignedVolume(mesh), 0.0);
  for (const Eigen::Vector3d& v : mesh.vertices) EXPECT_LE(v.z(), 70.0 + 1e-9);
  options.skip_unknown = false;
  EXPECT_EQ(CountOpenEdges(TessellateSurface(segment, options)), 0U);
}

}  // namespace
}  // namespace annulus
