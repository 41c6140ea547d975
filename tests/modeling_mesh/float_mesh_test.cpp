#include "modeling/mesh/float_mesh.h"

#include <gtest/gtest.h>

namespace annulus {
namespace {

TriangleMesh Tetrahedron(double size, double at) {
  TriangleMesh mesh;
  mesh.vertices = {{at, at, at}, {at + size, at, at}, {at, at + size, at}, {at, at, at + size}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

TEST(FloatMesh, KeepsWhatFloatsCanTell) {
  const TriangleMesh rounded = InFloats(Tetrahedron(1.0, 0.1));
  EXPECT_EQ(rounded.faces.size(), 4U);
  EXPECT_EQ(CountOpenEdges(rounded), 0U);
  for (const Eigen::Vector3d& v : rounded.vertices) {
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(v[axis], static_cast<double>(static_cast<float>(v[axis])));
  }
}

TEST(FloatMesh, WhatIsSmallerThanFloatsVanishesWhole) {
  // At 100 mm floats are 7.6e-6 apart.
  EXPECT_TRUE(InFloats(Tetrahedron(1e-7, 100.0)).faces.empty());
  EXPECT_TRUE(InFloats(Tetrahedron(1e-7, 100.0)).vertices.empty());
}

TEST(FloatMesh, ASliverIsLeftOutAndTheMeshStaysClosed) {
  // A tetrahedron with a fifth vertex beside vertex 3, nearer than floats can tell: the edge 3–4 has two slivers.
  TriangleMesh mesh = Tetrahedron(1.0, 100.0);
  mesh.vertices.emplace_back(100.0, 100.0 + 1e-7, 101.0);
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {0, 4, 2}, {1, 2, 4}, {0, 3, 4}, {1, 4, 3}};
  ASSERT_EQ(CountOpenEdges(mesh), 0U);
  const TriangleMesh rounded = InFloats(mesh);
  EXPECT_EQ(rounded.faces.size(), 4U);
  EXPECT_EQ(rounded.vertices.size(), 4U);
  EXPECT_EQ(CountOpenEdges(rounded), 0U);
}

TEST(FloatMesh, MinusZeroIsZero) {
  TriangleMesh mesh = Tetrahedron(1.0, 0.0);
  mesh.vertices.emplace_back(-0.0, 0.0, 0.0);
  mesh.faces[0] = {4, 2, 1};
  EXPECT_EQ(InFloats(mesh).vertices.size(), 4U);
  EXPECT_EQ(CountOpenEdges(InFloats(mesh)), 0U);
}

}  // namespace
}  // namespace annulus
