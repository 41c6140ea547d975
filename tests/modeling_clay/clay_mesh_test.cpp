#include "modeling/clay/clay_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "modeling/clay/clay_body.h"
#include "modeling/clay/clay_shapes.h"
#include "tests/modeling_clay/clay_check.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

TEST(ClayMesh, JoinsABlock) {
  const auto mesh = ClayMesh::Make(ClayBlock());
  ASSERT_TRUE(mesh) << mesh.error().Text();
  EXPECT_EQ(mesh->base_count(), 36U + 36U + 4U * 18U);
  // Euler: V − E + F = 2, every patch has 4 edges, every edge 2 patches.
  EXPECT_EQ(mesh->vertex_slots(), 2U + mesh->leaf_count());
  EXPECT_TRUE(test::MeshIsSound(*mesh));
}

TEST(ClayMesh, RefusesAnOpenSkinAndNumbersThatAreNone) {
  PatchShell open = ClayBlock();
  open.patches.pop_back();
  const auto mesh = ClayMesh::Make(open);
  ASSERT_FALSE(mesh);
  EXPECT_NE(mesh.error().seen.find("meets 0 others"), std::string::npos) << mesh.error().Text();
  PatchShell bad = ClayBlock();
  BezierPatch::ControlNet net = bad.patches[3].patch.control_net();
  net[1][2].y() = std::nan("");
  bad.patches[3].patch = BezierPatch(net);
  EXPECT_FALSE(ClayMesh::Make(bad));
  EXPECT_FALSE(ClayMesh::Make({}));
}

TEST(ClayMesh, SplitsAndMergesWithoutATrace) {
  auto mesh = ClayMesh::Make(test::RoundBlock());
  ASSERT_TRUE(mesh) << mesh.error().Text();
  const std::size_t bases = mesh->base_count();
  std::mt19937_64 random(7);
  for (int n = 0; n < 200; ++n) {
    PatchIndex index = static_cast<PatchIndex>(random() % mesh->patches().size());
    while (!mesh->alive(index) || mesh->patch(index).level > 5) {
      index = static_cast<PatchIndex>(random() % mesh->patches().size());
    }
    mesh->Split(index);
    ASSERT_EQ(test::Unsound(*mesh, 1e-12), "");
  }
  EXPECT_GT(mesh->leaf_count(), bases + 600U);
  for (bool merged = true; merged;) {
    merged = false;
    for (PatchIndex index = 0; index < mesh->patches().size(); ++index) {
      if (mesh->alive(index) && !mesh->Merge(index, 1e-9).made.empty()) merged = true;
    }
    ASSERT_EQ(test::Unsound(*mesh, 1e-9), "");
  }
  EXPECT_EQ(mesh->leaf_count(), bases);
}

TEST(ClayMesh, FindsTheLeafOfAnAddress) {
  auto mesh = ClayMesh::Make(test::RoundBlock());
  ASSERT_TRUE(mesh);
  const auto point = [&](const ClayAddress& address) {
    const ClayMesh::Leaf leaf = mesh->Locate(address);
    return BezierPatch(mesh->patch(leaf.patch).net).Point(leaf.u, leaf.v);
  };
  const ClayAddress address{5, 0.31, 0.77};
  const Vector3d before = point(address);
  for (int n = 0; n < 4; ++n) mesh->Split(mesh->Locate(address).patch);
  EXPECT_EQ(mesh->patch(mesh->Locate(address).patch).level, 4U);
  EXPECT_LT((point(address) - before).norm(), 1e-12);
  EXPECT_EQ(mesh->Locate({5, 1.0, 1.0}).u, 1.0);
}

}  // namespace
}  // namespace annulus
