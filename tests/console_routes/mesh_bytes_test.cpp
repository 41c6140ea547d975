#include "station/console/mesh_bytes.h"

#include <gtest/gtest.h>

#include "tests/console_routes/mesh_reader.h"

namespace annulus {
namespace {

/// A triangle in the plane z = `height`, its normal up.
TriangleMesh TriangleAt(double height) {
  return {{{0.0, 0.0, height}, {2.0, 0.0, height}, {0.0, 3.0, height}}, {{0, 1, 2}}};
}

TEST(MeshBytes, ReadBackAsTheContractSays) {
  MeshPart body{MeshKind::kBody,
                TriangleAt(5.0),
                {},
                {Knowledge::kMeasured, Knowledge::kInferred, Knowledge::kUnknown},
                {0.25F, 0.5F, 0.75F, 1.0F}};
  MeshPart lens{MeshKind::kLens, TriangleAt(-7.0), {}, {}, {0.0F, 1.0F, 0.0F, 0.5F}};
  const test::ReadMesh mesh = test::ReadMeshBytes(MeshBytes({body, lens}));
  EXPECT_EQ(mesh.positions, (std::vector<float>{0, 0, 5, 2, 0, 5, 0, 3, 5, 0, 0, -7, 2, 0, -7, 0, 3, -7}));
  EXPECT_EQ(mesh.normals, (std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}));
  EXPECT_EQ(mesh.knowledge, (std::vector<std::uint8_t>{0, 1, 2, 0, 0, 0}));
  EXPECT_EQ(mesh.indices, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
  ASSERT_EQ(mesh.parts.size(), 2U);
  EXPECT_EQ(mesh.parts[0].first_index, 0U);
  EXPECT_EQ(mesh.parts[0].count, 3U);
  EXPECT_EQ(mesh.parts[0].kind, 0U);
  EXPECT_EQ(mesh.parts[0].colour[2], 0.75F);
  EXPECT_EQ(mesh.parts[1].first_index, 3U);
  EXPECT_EQ(mesh.parts[1].kind, 2U);
  EXPECT_EQ(mesh.parts[1].colour[3], 0.5F);
}

TEST(MeshBytes, OfNothingAreAHeadAndNoParts) {
  const test::ReadMesh mesh = test::ReadMeshBytes(MeshBytes({}));
  EXPECT_TRUE(mesh.positions.empty());
  EXPECT_TRUE(mesh.parts.empty());
}

TEST(MeshBytes, KeepNormalsThatAreGiven) {
  MeshPart part{MeshKind::kFrame, TriangleAt(0.0), {3, Eigen::Vector3d::UnitX()}, {}, {1, 1, 1, 1}};
  const test::ReadMesh mesh = test::ReadMeshBytes(MeshBytes({part}));
  EXPECT_EQ(mesh.normals[3], 1.0F);
  EXPECT_EQ(mesh.normals[5], 0.0F);
}

}  // namespace
}  // namespace annulus
