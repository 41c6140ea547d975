#include "modeling/wrinkly/control_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "modeling/wrinkly/quad_mesh.h"
#include "wrinkly_meshes.h"

namespace annulus {
namespace {

std::map<std::size_t, int> CellSizes(const ControlMesh& mesh) {
  std::map<std::size_t, int> sizes;
  for (const MeshCell& cell : mesh.cells()) {
    if (!cell.open) ++sizes[cell.corners.size()];
  }
  return sizes;
}

std::size_t AxesOf(const ControlMesh& mesh, AxisFamily family) {
  return static_cast<std::size_t>(std::count_if(mesh.axes().begin(), mesh.axes().end(),
                                                [&](const GlobalAxis& axis) { return axis.family == family; }));
}

TEST(ControlMesh, HasEveryPatchOnOneAxisOfEachFamily) {
  for (const std::string& kind : MeshKinds()) {
    const ControlMesh mesh = NetMesh(kind);
    std::array<std::size_t, 2> passed{};
    for (std::size_t number = 0; number < mesh.axes().size(); ++number) {
      const GlobalAxis& axis = mesh.axes()[number];
      for (std::size_t k = 0; k < axis.points.size(); ++k) {
        const AxisInterval& interval = mesh.IntervalOf(axis.points[k], axis.family);
        ASSERT_EQ(interval.axis, static_cast<std::int32_t>(number)) << kind;
        ASSERT_EQ(interval.index, static_cast<std::int32_t>(k)) << kind;
        ++passed[static_cast<std::size_t>(axis.family)];
        // The next patch of the axis lies beyond the + side of this one, and this one beyond its − side.
        if (k + 1 == axis.points.size() && axis.kind == AxisKind::kOpen) continue;
        const std::size_t direction = axis.family == AxisFamily::kU ? 0 : 1;
        const PointIndex next = axis.points[(k + 1) % axis.points.size()];
        const ControlLink& link =
            mesh.parts().points[ControlMesh::Index(axis.points[k])].link[mesh.SlotOf(axis.points[k], direction)];
        ASSERT_EQ(link.point, next) << kind;
        ASSERT_EQ(link.slot, mesh.SlotOf(next, direction + 2)) << kind;
      }
    }
    EXPECT_EQ(passed[0], mesh.patch_count()) << kind;
    EXPECT_EQ(passed[1], mesh.patch_count()) << kind;
    EXPECT_EQ(mesh.cut_count(), 0U);
  }
}

TEST(ControlMesh, CountsAxesAndCellsOfTheNetsThatThePaperShows) {
  // A regular net of 4 columns and 3 rows: a row is a U axis.
  const ControlMesh regular = NetMesh("regular:4x3");
  EXPECT_EQ(AxesOf(regular, AxisFamily::kU), 3U);
  EXPECT_EQ(AxesOf(regular, AxisFamily::kV), 4U);
  EXPECT_EQ(CellSizes(regular), (std::map<std::size_t, int>{{4, 6}}));
  // N directions: 2N sectors of n × n, axes cross the sectors' common sides; a cell of 2N points in the middle.
  for (const int n : {2, 3, 4, 5, 6}) {
    const ControlMesh mesh = NetMesh("directions:" + std::to_string(n) + "x3");
    EXPECT_EQ(mesh.size(), static_cast<std::size_t>(2 * n * 9));
    EXPECT_EQ(mesh.axes().size(), static_cast<std::size_t>(2 * n * 3));
    const auto sizes = CellSizes(mesh);
    if (n > 2) {
      EXPECT_EQ(sizes.at(static_cast<std::size_t>(2 * n)), 1);
    }
    EXPECT_EQ(sizes.size(), n > 2 ? 2U : 1U);
    for (const GlobalAxis& axis : mesh.axes()) EXPECT_EQ(axis.points.size(), 6U);
  }
  // A ring net: rings are cyclic, spokes open; the middle is a closed cell of all spokes.
  const ControlMesh ring = NetMesh("ring:6x3");
  EXPECT_EQ(AxesOf(ring, AxisFamily::kU) + AxesOf(ring, AxisFamily::kV), 9U);
  EXPECT_EQ(
      std::count_if(ring.axes().begin(), ring.axes().end(),
                    [](const GlobalAxis& axis) { return axis.kind == AxisKind::kCyclic && axis.points.size() == 6; }),
      3);
  EXPECT_EQ(std::count_if(ring.cells().begin(), ring.cells().end(),
                          [](const MeshCell& cell) { return cell.closed && cell.corners.size() == 6; }),
            1);
  // A spiral is one long axis, and six across it.
  const ControlMesh spiral = NetMesh("spiral:6x21");
  EXPECT_EQ(spiral.axes().size(), 7U);
  EXPECT_EQ(std::count_if(spiral.axes().begin(), spiral.axes().end(),
                          [](const GlobalAxis& axis) { return axis.points.size() == 21; }),
            1);
}

TEST(ControlMesh, SatisfiesEulersFormulaOnATorus) {
  const ControlMesh torus = NetMesh("torus:3x4");
  // Points − links + cells = 0; every point has two links of its own.
  EXPECT_EQ(torus.cells().size(), torus.size());
}

/// A cube's six faces as patches: three meet at every corner.
QuadMesh Cube() {
  QuadMesh cube;
  for (int k = 0; k < 8; ++k) cube.vertices.emplace_back(k & 1, (k >> 1) & 1, (k >> 2) & 1);
  cube.quads = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  return cube;
}

TEST(ControlMesh, NamesTheLoopThatForbidsTwoFamilies) {
  const ControlMeshParts parts = ControlMeshOfQuads(Cube()).value();
  const auto refused = ControlMesh::Make(parts);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().Text().find("along the loop of control points"), std::string::npos);
  EXPECT_NE(refused.error().Text().find("U turns into V"), std::string::npos);
  // Cut open it is two-family; 8 odd cells cannot be mended by fewer than 4 cuts of 12 links.
  const auto cut = ControlMesh::Make(parts, FamilyRule::kCut);
  ASSERT_TRUE(cut);
  EXPECT_GE(cut->cut_count(), 4U);
  EXPECT_LE(cut->cut_count(), 6U);
  EXPECT_EQ(CellSizes(*cut), (std::map<std::size_t, int>{{3, 8}}));
}

TEST(ControlMesh, RefusesWhatIsNoMesh) {
  const auto text = [](const ControlMeshParts& parts) {
    const auto made = ControlMesh::Make(parts);
    return made ? std::string() : made.error().Text();
  };
  ControlMeshParts parts = MakeNet("regular:3x3").value();
  ControlMeshParts bad = parts;
  bad.points[4].position.x() = std::numeric_limits<double>::infinity();
  EXPECT_NE(text(bad).find("control point 4"), std::string::npos);
  bad = parts;
  bad.points[0].link[0].point = 99;
  EXPECT_NE(text(bad).find("does not exist"), std::string::npos);
  bad = parts;
  bad.points[0].link[0].point = 5;
  EXPECT_NE(text(bad).find("not linked back"), std::string::npos);
  bad = parts;
  bad.points.emplace_back();
  bad.values = Eigen::MatrixXd::Zero(10, 1);
  EXPECT_NE(text(bad).find("linked to no other"), std::string::npos);
  bad = parts;
  bad.values.resize(2, 1);
  EXPECT_NE(text(bad).find("one value"), std::string::npos);
  EXPECT_NE(text({}).find("no control points"), std::string::npos);
}

TEST(QuadMesh, RefusesWhatIsNoControlMesh) {
  const auto text = [](const QuadMesh& mesh) { return ControlMeshOfQuads(mesh).error().Text(); };
  QuadMesh mesh = Cube();
  mesh.quads.push_back({0, 1, 5, 4});
  EXPECT_NE(text(mesh).find("third at the edge"), std::string::npos);
  mesh = Cube();
  std::reverse(mesh.quads[2].begin(), mesh.quads[2].end());
  EXPECT_NE(text(mesh).find("the same way"), std::string::npos);
  mesh.quads[0][0] = 12;
  EXPECT_NE(text(mesh).find("does not exist"), std::string::npos);
}

TEST(QuadMesh, ReadsQuadrilateralsOfAnObj) {
  const auto mesh =
      QuadMeshFromObj("# two\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nf 1/1/1 2 3//2 4\nf 2 5 6 -4\n",
                      "a", PolygonRule::kRefuse);
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->quads, (std::vector<std::array<std::uint32_t, 4>>{{0, 1, 2, 3}, {1, 4, 5, 2}}));
  for (const char* text :
       {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "v 0 0\n", "v 0 0 0\nf 1 2 3 4\n", "f 0 0 0 0\n", "", "v 0 0 nan\n"}) {
    EXPECT_FALSE(QuadMeshFromObj(text, "a", PolygonRule::kRefuse)) << text;
  }
  EXPECT_NE(
      QuadMeshFromObj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a", PolygonRule::kRefuse).error().Text().find("line 4"),
      std::string::npos);
}

TEST(QuadMesh, SplitsPolygonsIntoPatchesThatJoin) {
  // A tetrahedron: 4 triangles become 12 patches; cells are its 4 corners (3), its 4 faces (3) and its 6 edges (4).
  const auto mesh = QuadMeshFromObj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", "a",
                                    PolygonRule::kSplit);
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->quads.size(), 12U);
  const auto made = ControlMesh::Make(ControlMeshOfQuads(*mesh).value(), FamilyRule::kCut);
  ASSERT_TRUE(made);
  EXPECT_EQ(CellSizes(*made), (std::map<std::size_t, int>{{3, 8}, {4, 6}}));
}

}  // namespace
}  // namespace annulus
