#include "sim/mesh_subject.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "base/storage.h"
#include "base/units.h"
#include "modeling/mesh/mesh_io.h"

namespace annulus::sim {
namespace {

// A ball of radius r about (0, 0, 0) by longitude and latitude.
TriangleMesh Ball(double r, std::uint32_t columns, std::uint32_t rows) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0, 0, -r);
  for (std::uint32_t j = 1; j < rows; ++j) {
    const double latitude = kPi * (static_cast<double>(j) / rows - 0.5);
    for (std::uint32_t i = 0; i < columns; ++i) {
      mesh.vertices.push_back(
          PointFromCylindrical(kTwoPi * i / columns, r * std::cos(latitude), r * std::sin(latitude)));
    }
  }
  mesh.vertices.emplace_back(0, 0, r);
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return 1 + (j - 1) * columns + i % columns; };
  const auto top = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  for (std::uint32_t i = 0; i < columns; ++i) {
    mesh.faces.push_back({0, at(i + 1, 1), at(i, 1)});
    mesh.faces.push_back({top, at(i, rows - 1), at(i + 1, rows - 1)});
    for (std::uint32_t j = 1; j + 1 < rows; ++j) {
      mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

TEST(MeshSubject, IsTheBallItWasMadeOf) {
  MeshPlacement placement;
  placement.x_mm = 5.0;
  placement.bottom_mm = 1000.0;
  const MeshSubject ball(Ball(100.0, 256, 128), placement, "ball");
  EXPECT_NEAR(ball.bottom_mm(), 1000.0, 1e-9);
  EXPECT_NEAR(ball.top_mm(), 1200.0, 1e-9);
  // Chords of 2 pi/256 fall 100 (1 - cos(pi/256)) = 0.008 mm short, in both directions.
  for (int i = 0; i < 90; ++i) {
    const double theta = 0.01 + kTwoPi * i / 90.0;
    const Eigen::Vector3d direction = PointFromCylindrical(theta, 1.0, 0.0);
    const auto hit = ball.Cast({Eigen::Vector3d(5.0, 0.0, 1130.0) + 500.0 * direction, -direction}, 0.0, 1000.0);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance_mm, 500.0 - std::sqrt(1e4 - 900.0), 0.03);
    EXPECT_NEAR(hit->normal.dot(direction), std::sqrt(1.0 - 0.09), 0.01);
  }
  const std::vector<SectionTruth> sections = ball.Sections(1130.0);
  ASSERT_EQ(sections.size(), 1U);
  const double radius = std::sqrt(1e4 - 900.0);
  EXPECT_NEAR(sections[0].perimeter_mm, kTwoPi * radius, 0.2);
  EXPECT_NEAR(sections[0].tape_mm, kTwoPi * radius, 0.2);
  EXPECT_NEAR(sections[0].area_mm2, kPi * radius * radius, 12.0);
  EXPECT_NEAR(ball.Volume(0.0, 2000.0), 4.0 / 3.0 * kPi * 1e6, 5e-4 * 4.2e6);
  // The cap above z = 1130, height 70: pi h² (3 r - h) / 3.
  EXPECT_NEAR(ball.Volume(1130.0, 2000.0), kPi * 4900.0 * 230.0 / 3.0, 1e-3 * 1.2e6);
}

TEST(MeshSubject, TurnsAFileWhoseYIsUp) {
  TriangleMesh mesh;  // a tetrahedron; +z is the file's front
  mesh.vertices = {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {0, 0, 0}};
  mesh.faces = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}};
  MeshPlacement placement;
  placement.up = UpAxis::kY;
  placement.scale = 10.0;
  const MeshSubject subject(mesh, placement, "tetrahedron");
  EXPECT_EQ(subject.mesh().vertices[0], Eigen::Vector3d(-10, 0, 0));  // the subject's left
  EXPECT_EQ(subject.mesh().vertices[1], Eigen::Vector3d(0, 0, 20));   // up
  EXPECT_EQ(subject.mesh().vertices[2], Eigen::Vector3d(0, 30, 0));   // front
  EXPECT_NEAR(SignedVolume(subject.mesh()), 1000.0, 1e-9);            // still outward
}

TEST(MeshSubject, IsNamedAfterItsFile) {
  PosixStorage storage;
  const std::string folder = std::filesystem::temp_directory_path().string() + "/annulus_mesh_subject_test";
  ASSERT_TRUE(storage.CreateFolder(folder));
  ASSERT_TRUE(WriteFileAtomically(storage, folder + "/small.ball.stl", WriteStl(Ball(10.0, 12, 6), "ball")));
  const Result<MeshSubject> subject = MeshSubject::Load(storage, folder + "/small.ball.stl", {});
  ASSERT_TRUE(subject) << subject.error().Text();
  EXPECT_EQ(subject->name(), "small.ball");
  EXPECT_FALSE(MeshSubject::Load(storage, folder + "/missing.stl", {}));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace annulus::sim
