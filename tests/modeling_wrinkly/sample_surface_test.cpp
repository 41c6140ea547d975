#include "modeling/wrinkly/sample_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "modeling/mesh/triangle_mesh.h"
#include "modeling/wrinkly/quad_mesh.h"
#include "wrinkly_meshes.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

TriangleMesh InDoubles(const WrinklyMesh& mesh) {
  TriangleMesh plain;
  for (const Eigen::Vector3f& position : mesh.positions) plain.vertices.push_back(position.cast<double>());
  plain.faces = mesh.faces;
  return plain;
}

/// A torus in space about the z axis, radii 60 and 25 mm, of rough control points.
WrinklySurface RoughTorus(double height, const WrinklyOptions& options = {}) {
  ControlMeshParts parts = RoughNet("torus:16x8", 5);
  for (std::size_t k = 0; k < parts.points.size(); ++k) {
    const double round = 2.0 * std::numbers::pi * static_cast<double>(k % 16) / 16.0;
    const double tube = 2.0 * std::numbers::pi * static_cast<double>(k / 16) / 8.0;
    const double radius = 60.0 + 25.0 * std::cos(tube);
    parts.points[k].position = {radius * std::cos(round), radius * std::sin(round), 25.0 * std::sin(tube)};
  }
  parts.values *= height;
  return WrinklySurface::Make(ControlMesh::Make(parts).value(), options).value();
}

ScreenView ViewFrom(double distance) {
  ScreenView view;
  view.camera_from_station << 1, 0, 0, 0, 0, 1, 0, -1, 0;  // looks along −y from the front
  view.eye_in_station = {60.0, distance, 0.0};
  return view;
}

TEST(SampleSurface, ClosesClosedSurfacesAtEveryDepth) {
  for (const double iterations : {0.0, 1.0, 1.5, 2.0}) {
    SamplingOptions options;
    options.iterations = iterations;
    options.depth = 2;
    const WrinklyMesh mesh = SampleSurface(RoughTorus(3.0), options, {}).value();
    EXPECT_EQ(mesh.cells, 128U * 81U);
    EXPECT_EQ(mesh.faces.size(), 4 * mesh.cells);
    const TriangleMesh plain = InDoubles(mesh);
    EXPECT_EQ(CountOpenEdges(plain), 0U);
    // Euler's formula of a torus.
    EXPECT_EQ(plain.vertices.size() + plain.faces.size(), 3 * plain.faces.size() / 2);
  }
}

TEST(SampleSurface, ConvergesToTheSmoothSurfaceWithoutIterations) {
  // The volume between levels of subdivision converges by the square of the step; Richardson's limit stays put.
  const WrinklySurface surface = RoughTorus(0.0);
  std::array<double, 3> volumes{};
  for (int depth = 1; depth <= 3; ++depth) {
    SamplingOptions options;
    options.depth = depth;
    volumes[static_cast<std::size_t>(depth - 1)] = SignedVolume(InDoubles(SampleSurface(surface, options, {}).value()));
  }
  EXPECT_GT(volumes[0], 0.0);
  EXPECT_NEAR((volumes[1] - volumes[0]) / (volumes[2] - volumes[1]), 9.0, 0.5);
}

TEST(SampleSurface, LeavesNoGapBetweenCellsOfDifferentSizes) {
  for (const std::string kind : {"near", "far"}) {
    SamplingOptions options;
    options.view = ViewFrom(kind == "near" ? 130.0 : 400.0);
    options.view->half_height = 2.0;  // so wide that all is in the picture
    options.triangle_px = kind == "near" ? 3.0 : 1.0;
    const WrinklyMesh mesh = SampleSurface(RoughTorus(2.0), options, {}).value();
    EXPECT_GT(mesh.deepest, mesh.shallowest);
    EXPECT_EQ(CountOpenEdges(InDoubles(mesh)), 0U) << kind;
  }
}

TEST(SampleSurface, IsClosedOverPatchesThatRunOppositeWays) {
  // A cube's six patches: all kinds of corners meet, half of the axes run against their neighbours.
  QuadMesh cube;
  for (int k = 0; k < 8; ++k) cube.vertices.emplace_back(80 * (k & 1), 80 * ((k >> 1) & 1), 80 * ((k >> 2) & 1));
  cube.quads = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  const ControlMesh mesh = ControlMesh::Make(ControlMeshOfQuads(cube).value(), FamilyRule::kCut).value();
  for (const CornerJoin join : {CornerJoin::kPaper, CornerJoin::kRounded}) {
    const WrinklySurface surface = WrinklySurface::Make(mesh, {.join = join}).value();
    SamplingOptions options;
    options.view = ViewFrom(130.0);
    options.view->half_height = 4.0;
    const TriangleMesh plain = InDoubles(SampleSurface(surface, options, {}).value());
    EXPECT_EQ(CountOpenEdges(plain), 0U);
    EXPECT_GT(SignedVolume(plain), 0.0);
  }
}

TEST(SampleSurface, ClosesSurfacesOfAnyCrossings) {
  for (const WrinklyOptions& crossings : std::vector<WrinklyOptions>{
           {.crossing_u = 2, .crossing_v = 1}, {.crossing_u = 0, .crossing_v = 1}, {.structure = {1, 2, 1}}}) {
    const WrinklySurface surface = RoughTorus(2.0, crossings);
    SamplingOptions options;
    options.view = ViewFrom(300.0);
    options.view->half_height = 1.0;
    options.triangle_px = 6.0;
    const TriangleMesh plain = InDoubles(SampleSurface(surface, options, {}).value());
    EXPECT_GT(plain.faces.size(), 1000U);
    EXPECT_EQ(CountOpenEdges(plain), 0U);
  }
}

TEST(SampleSurface, WithoutCrossingsIsTheSmoothSurfaceWhateverK) {
  const WrinklySurface still = RoughTorus(2.0, {.crossing_u = 0, .crossing_v = 0});
  const WrinklySurface moved = RoughTorus(2.0);
  SamplingOptions options;
  options.depth = 2;
  options.iterations = 2.0;
  const WrinklyMesh without = SampleSurface(still, options, {}).value();
  options.iterations = 0.0;
  const WrinklyMesh smooth = SampleSurface(moved, options, {}).value();
  ASSERT_EQ(without.positions.size(), smooth.positions.size());
  for (std::size_t k = 0; k < smooth.positions.size(); ++k) {
    ASSERT_LT((without.positions[k] - smooth.positions[k]).norm(), 1e-4F);
  }
}

TEST(SampleSurface, KeepsCellsBelowTheirSizeOnTheScreen) {
  SamplingOptions options;
  options.view = ViewFrom(300.0);
  options.triangle_px = 3.0;
  const WrinklyMesh mesh = SampleSurface(RoughTorus(0.0), options, {}).value();
  const double pixels = options.view->height / (2.0 * options.view->half_height);
  double longest = 0.0;
  for (const auto& face : mesh.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d a = mesh.positions[face[k]].cast<double>();
      const Vector3d b = mesh.positions[face[(k + 1) % 3]].cast<double>();
      const double depth = 300.0 - std::max(a.y(), b.y());
      longest = std::max(longest, (a - b).norm() * pixels / depth);
    }
  }
  EXPECT_LT(longest, 3.05);
  EXPECT_GT(longest, 1.5);
}

TEST(SampleSurface, GivesTheSameMeshOnOneThreadAndOnFour) {
  SamplingOptions options;
  options.view = ViewFrom(200.0);
  options.threads = 1;
  const WrinklyMesh one = SampleSurface(RoughTorus(2.0), options, {}).value();
  options.threads = 4;
  const WrinklyMesh four = SampleSurface(RoughTorus(2.0), options, {}).value();
  EXPECT_EQ(one.positions, four.positions);
  EXPECT_EQ(one.values, four.values);
  EXPECT_EQ(one.faces, four.faces);
}

/// A rough sheet seen from above, ever nearer: cells per frame, as the camera comes down by `factor` in `frames` steps.
struct Zoom {
  WrinklySurface surface;
  ScreenView view;
};

Zoom MakeZoom() {
  ControlMeshParts parts = RoughNet("regular:60x60", 11);
  ScreenView view;
  view.camera_from_station << 1, 0, 0, 0, 1, 0, 0, 0, -1;
  return {WrinklySurface::Make(ControlMesh::Make(parts).value(), {}).value(), view};
}

TEST(SampleSurface, KeepsTheNumberOfTrianglesInAZoomOfAThousand) {
  Zoom zoom = MakeZoom();
  std::vector<double> faces;
  for (int frame = 0; frame <= 36; ++frame) {
    const double distance = 900.0 * std::pow(1000.0, -frame / 36.0);
    zoom.view.eye_in_station = {301.3, 287.9, distance + 1.0};
    SamplingOptions options;
    options.view = zoom.view;
    options.view->near_mm = 1e-3;
    options.triangle_px = 16.0;
    // Flat, so that the distance of what is seen is that of the sheet: heights stay in the values.
    ControlMeshParts flat = zoom.surface.mesh().parts();
    flat.values.setZero();
    zoom.view.eye_in_station.z() = distance;
    options.view->eye_in_station.z() = distance;
    const WrinklySurface sheet = WrinklySurface::Make(ControlMesh::Make(flat).value(), {}).value();
    const WrinklyMesh mesh = SampleSurface(sheet, options, {}).value();
    faces.push_back(static_cast<double>(mesh.faces.size()));
    if (frame % 6 == 0)
      std::printf("%8.3f mm: %zu triangles, depth %d … %d\n", distance, mesh.faces.size(), mesh.shallowest,
                  mesh.deepest);
  }
  const auto [low, high] = std::minmax_element(faces.begin(), faces.end());
  std::printf("%.0f … %.0f triangles\n", *low, *high);
  double mean = 0.0;
  for (const double count : faces) mean += count / static_cast<double>(faces.size());
  EXPECT_GT(*low, 0.8 * mean);
  EXPECT_LT(*high, 1.2 * mean);
}

TEST(SampleSurface, RefusesWhatItCannotDo) {
  const WrinklySurface surface = RoughTorus(1.0);
  const auto text = [&](const SamplingOptions& options) {
    const auto made = SampleSurface(surface, options, {});
    return made ? std::string() : made.error().Text();
  };
  SamplingOptions options;
  options.iterations = 25.0;
  EXPECT_NE(text(options).find("use 0 to 19"), std::string::npos);
  options.iterations = -1.0;
  EXPECT_FALSE(text(options).empty());
  options.iterations = 8.0;
  options.most_cells = 10'000;
  EXPECT_NE(text(options).find("more than 10000 cells"), std::string::npos);
  options = {};
  options.depth = 40;
  EXPECT_FALSE(text(options).empty());
  options = {};
  options.view = ViewFrom(100.0);
  options.view->half_height = 0.0;
  EXPECT_FALSE(text(options).empty());
  options.view->half_height = 0.1;
  options.triangle_px = 0.0;
  EXPECT_FALSE(text(options).empty());
}

}  // namespace
}  // namespace annulus
