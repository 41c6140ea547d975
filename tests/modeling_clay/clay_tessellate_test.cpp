#include "modeling/clay/clay_tessellate.h"

#include <gtest/gtest.h>

#include <random>

#include "modeling/clay/clay_shapes.h"
#include "tests/modeling_clay/clay_check.h"

namespace annulus {
namespace {

TEST(ClayTessellate, ClosesOverLeavesOfAllSizes) {
  auto mesh = ClayMesh::Make(ClayBlock());
  ASSERT_TRUE(mesh);
  std::mt19937_64 random(2);
  for (int n = 0; n < 60; ++n) {
    const auto index = static_cast<PatchIndex>(random() % mesh->patches().size());
    if (mesh->alive(index) && mesh->patch(index).level < 5) mesh->Split(index);
  }
  for (const std::size_t steps : {std::size_t{1}, std::size_t{2}, std::size_t{5}}) {
    const TriangleMesh triangles = Tessellate(*mesh, steps);
    EXPECT_EQ(CountOpenEdges(triangles), 0U);
    EXPECT_NEAR(SignedVolume(triangles), 108.0, 1e-10);
    EXPECT_NEAR(SurfaceArea(triangles), 144.0, 1e-10);
  }
}

TEST(ClayTessellate, ClosesAtPoles) {
  const auto mesh = ClayMesh::Make(UtahTeapot());
  ASSERT_TRUE(mesh);
  const TriangleMesh triangles = Tessellate(*mesh, 24);
  EXPECT_EQ(CountOpenEdges(triangles), 0U);
  // The volume of the patches, see clay_body_test.cpp, less what chords cut off.
  EXPECT_NEAR(SignedVolume(triangles), 26.18473881628571, 0.03);
}

}  // namespace
}  // namespace annulus
