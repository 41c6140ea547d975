#include "render/rasterizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "base/units.h"
#include "shapes.h"

namespace annulus {
namespace {

PixelSamples Grid(Projection projection, int width, int height) {
  PixelSamples grid;
  grid.projection = projection;
  grid.half_height = projection == Projection::kPerspective ? 0.3 : 0.5 * height;
  grid.width = width;
  grid.height = height;
  return grid;
}

CameraMesh MeshOf(const TriangleMesh& mesh) { return {mesh.vertices, mesh.faces}; }

double UniformIn(std::mt19937_64& engine, double from, double to) {
  return from + (to - from) * static_cast<double>(engine() >> 11) * 0x1.0p-53;
}

/// Depth at a sample of the picture.
float DepthAt(const VisibilityBuffer& buffer, int x, int y) {
  return buffer.window.Contains(x, y) ? buffer.depth[buffer.window.Index(x, y)] : kNoDepth;
}

std::size_t CountCovered(const VisibilityBuffer& buffer) {
  return static_cast<std::size_t>(
      std::count_if(buffer.face.begin(), buffer.face.end(), [](std::uint32_t face) { return face != kNoFace; }));
}

TEST(Rasterizer, SphereSilhouetteHasTheCirclesArea) {
  // Orthographic, 1 mm per sample: pi r^2 samples. The polygon of 720 corners is 1.3e-5 smaller; a circle of radius r
  // holds pi r^2 lattice points within a few r^(2/3).
  const double radius = 150.3;
  const CameraMesh mesh = MeshOf(SphereMesh({3.21, -1.77, 500.0}, radius, 720));
  const auto seen = RasterizeNearest(mesh, Grid(Projection::kOrthographic, 400, 360), {});
  EXPECT_NEAR(static_cast<double>(CountCovered(seen)), kPi * radius * radius, 40.0);
}

TEST(Rasterizer, PerspectiveSphereShowsItsTangentCone) {
  // On the axis the silhouette is the cone of half angle asin(r / d).
  const double radius = 100.0;
  const double distance = 600.0;
  const PixelSamples grid = Grid(Projection::kPerspective, 500, 500);
  const auto seen = RasterizeNearest(MeshOf(SphereMesh({0.0, 0.0, distance}, radius, 720)), grid, {});
  const double in_samples = std::tan(std::asin(radius / distance)) / grid.Pitch();
  EXPECT_NEAR(static_cast<double>(CountCovered(seen)), kPi * in_samples * in_samples, 40.0);
  // Nearest point of the sphere in the middle.
  EXPECT_NEAR(DepthAt(seen, 250, 250), distance - radius, 0.02);
}

TEST(Rasterizer, DepthOfAPlaneIsExactAtSampleCentres) {
  // Plane p.z = 700 + 0.8 p.x - 0.5 p.y. Perspective ray (u, v, 1): z = 700 / (1 - 0.8 u + 0.5 v).
  const Eigen::Vector3d corner(-2000.0, -2000.0, 700.0 - 0.8 * 2000.0 + 0.5 * 2000.0);
  const CameraMesh mesh = MeshOf(QuadMesh(corner, {4000.0, 0.0, 3200.0}, {0.0, 4000.0, -2000.0}));
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    const PixelSamples grid = Grid(projection, 61, 47);
    const auto seen = RasterizeNearest(mesh, grid, {});
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        const double right = (x + 0.5 - 30.5) * grid.Pitch();
        const double up = (23.5 - y - 0.5) * grid.Pitch();
        const double expected = projection == Projection::kPerspective ? 700.0 / (1.0 - 0.8 * right + 0.5 * up)
                                                                       : 700.0 + 0.8 * right - 0.5 * up;
        const float depth = DepthAt(seen, x, y);
        EXPECT_NEAR(depth / expected, 1.0, 1.2e-7) << x << " " << y;  // half a unit in the last place of a float
      }
    }
  }
}

TEST(Rasterizer, SharedEdgesBelongToExactlyOneFace) {
  // A jittered net over the whole picture: every sample must be covered once, none twice.
  std::mt19937_64 engine(11);
  constexpr int kCells = 40;
  TriangleMesh net;
  for (int i = 0; i <= kCells; ++i) {
    for (int j = 0; j <= kCells; ++j) {
      // On a lattice of whole and half samples many edges pass exactly through sample centres.
      const double x = std::round(UniformIn(engine, -1.5, 1.5)) * 0.5 + 4.0 * (i - kCells / 2);
      const double y = std::round(UniformIn(engine, -1.5, 1.5)) * 0.5 + 4.0 * (j - kCells / 2);
      net.vertices.emplace_back(x, y, 100.0);
    }
  }
  for (std::uint32_t i = 0; i < kCells; ++i) {
    for (std::uint32_t j = 0; j < kCells; ++j) {
      const std::uint32_t a = i * (kCells + 1) + j;
      const std::uint32_t c = a + kCells + 1;
      net.faces.push_back({a, c, a + 1});
      net.faces.push_back({a + 1, c, c + 1});
    }
  }
  const PixelSamples grid = Grid(Projection::kOrthographic, 140, 140);
  const std::vector<float> unlimited(140 * 140, kNoDepth);
  const SampleWindow whole{0, 0, 140, 140};
  const std::vector<Fragment> fragments = RasterizeAll(MeshOf(net), grid, {whole, unlimited}, {});
  ASSERT_EQ(fragments.size(), unlimited.size());
  for (std::uint32_t k = 0; k < fragments.size(); ++k) EXPECT_EQ(fragments[k].sample, k);
}

TEST(Rasterizer, ClippingLeavesNoGapsInsideAClosedSurface) {
  const PixelSamples grid = Grid(Projection::kPerspective, 120, 90);
  const auto seen = RasterizeNearest(MeshOf(SphereMesh({0.1, 0.2, -0.3}, 50.0, 24)), grid, {});
  EXPECT_EQ(CountCovered(seen), 120U * 90U);
  for (const float depth : seen.depth) {
    EXPECT_GE(depth, 1.0F);
    EXPECT_LE(depth, 51.0F);
  }
}

TEST(Rasterizer, NothingNearerThanTheNearPlaneIsDrawn) {
  const PixelSamples grid = Grid(Projection::kPerspective, 20, 20);
  EXPECT_EQ(CountCovered(RasterizeNearest(MeshOf(QuadMesh({-9, -9, 0.5}, {18, 0, 0}, {0, 18, 0})), grid, {})), 0U);
  EXPECT_EQ(CountCovered(RasterizeNearest(MeshOf(QuadMesh({-9, -9, -50}, {18, 0, 0}, {0, 18, 0})), grid, {})), 0U);
  EXPECT_EQ(CountCovered(RasterizeNearest(MeshOf(QuadMesh({-9, -9, 2}, {18, 0, 0}, {0, 18, 0})), grid, {})), 400U);
}

TEST(Rasterizer, TheWindowHoldsWhatIsSeenInWholePixels) {
  PixelSamples grid = Grid(Projection::kOrthographic, 60, 40);
  grid.supersampling = 4;
  // Samples are 1 mm; the picture's middle is the origin. Columns 35 … 44, rows 13 … 16.
  const auto seen = RasterizeNearest(MeshOf(QuadMesh({5, 3, 50}, {10, 0, 0}, {0, 4, 0})), grid, {});
  EXPECT_EQ(seen.window, (SampleWindow{32, 12, 16, 8}));
  EXPECT_EQ(CountCovered(seen), 40U);
  EXPECT_EQ(DepthAt(seen, 35, 13), 50.0F);
  EXPECT_EQ(DepthAt(seen, 34, 13), kNoDepth);
  // Beside the picture nothing is kept.
  EXPECT_TRUE(RasterizeNearest(MeshOf(QuadMesh({40, 3, 50}, {10, 0, 0}, {0, 4, 0})), grid, {}).window.IsEmpty());
}

TEST(Rasterizer, FacesWithoutAreaAreSkipped) {
  CameraMesh mesh;
  mesh.vertices = {{0, 0, 10}, {5, 0, 10}, {2.5, 0, 10}, {0, 0, 10}};
  mesh.faces = {{0, 1, 2}, {0, 0, 0}, {0, 3, 1}, {0, 1, 1}};
  EXPECT_EQ(CountCovered(RasterizeNearest(mesh, Grid(Projection::kOrthographic, 20, 20), {})), 0U);
  EXPECT_EQ(CountCovered(RasterizeNearest(CameraMesh{}, Grid(Projection::kOrthographic, 20, 20), {})), 0U);
}

TEST(Rasterizer, FragmentsComeFarToNearUpToTheLimit) {
  TriangleMesh mesh = QuadMesh({-50, -50, 30}, {100, 0, 0}, {0, 100, 0});
  Append(mesh, QuadMesh({-50, -50, 10}, {100, 0, 0}, {0, 100, 0}));
  Append(mesh, QuadMesh({-50, -50, 20}, {100, 0, 0}, {0, 100, 0}));
  const PixelSamples grid = Grid(Projection::kOrthographic, 8, 8);
  const SampleWindow whole{0, 0, 8, 8};
  const auto fragments = RasterizeAll(MeshOf(mesh), grid, {whole, std::vector<float>(64, 25.0F)}, {});
  ASSERT_EQ(fragments.size(), 128U);
  for (std::size_t k = 0; k < fragments.size(); k += 2) {
    EXPECT_EQ(fragments[k].depth, 20.0F);
    EXPECT_EQ(fragments[k + 1].depth, 10.0F);
  }
}

TEST(Rasterizer, RandomTrianglesGiveTheSameOnAnyNumberOfThreads) {
  std::mt19937_64 engine(5);
  CameraMesh mesh;
  for (std::uint32_t k = 0; k < 3000; ++k) {
    const double size = std::pow(10.0, UniformIn(engine, -3.0, 4.0));
    const Eigen::Vector3d middle(UniformIn(engine, -300, 300), UniformIn(engine, -300, 300),
                                 UniformIn(engine, -200, 900));
    for (int c = 0; c < 3; ++c) {
      mesh.vertices.push_back(middle + size * Eigen::Vector3d(UniformIn(engine, -1, 1), UniformIn(engine, -1, 1),
                                                              UniformIn(engine, -1, 1)));
    }
    mesh.faces.push_back({3 * k, 3 * k + 1, 3 * k + 2});
  }
  PixelSamples grid = Grid(Projection::kPerspective, 200, 150);
  const auto one = RasterizeNearest(mesh, grid, {});
  grid.threads = 3;
  const auto three = RasterizeNearest(mesh, grid, {});
  EXPECT_EQ(one.depth, three.depth);
  EXPECT_EQ(one.face, three.face);
  for (std::size_t k = 0; k < one.depth.size(); ++k) {
    EXPECT_EQ(std::isfinite(one.depth[k]), one.face[k] != kNoFace);
    EXPECT_GE(one.depth[k], 1.0F);
  }
}

}  // namespace
}  // namespace annulus
