#include "modeling/wrinkly/control_mesh_json.h"

#include <gtest/gtest.h>

#include <string>

#include "wrinkly_meshes.h"

namespace annulus {
namespace {

TEST(ControlMeshJson, ReadsBackWhatItWrote) {
  for (const std::string& kind : MeshKinds()) {
    const ControlMeshParts parts = RoughNet(kind);
    const std::string text = ControlMeshToJson(parts);
    const auto back = ControlMeshFromJson(text, "a.json");
    ASSERT_TRUE(back) << kind << ' ' << back.error().Text();
    EXPECT_EQ(back->values, parts.values);
    ASSERT_TRUE(ControlMesh::Make(*back)) << kind;
    EXPECT_EQ(ControlMeshToJson(*back), text);
  }
}

TEST(ControlMeshJson, FindsTheSideByWhichAPointIsLinkedBack) {
  // Three in a row; the third is turned by a quarter, so its link back is its side 3.
  const char* const text = R"({"format": "annulus wrinkly mesh", "version": 1, "attributes": ["height"], "points": [
    {"position_mm": [0, 0, 0], "links": [1, null, null, null], "values": [1]},
    {"position_mm": [9, 0, 0], "links": [2, null, 0, null], "values": [2]},
    {"position_mm": [18, 0, 0], "links": [null, null, null, 1], "values": [3]}]})";
  const auto parts = ControlMeshFromJson(text, "a.json");
  ASSERT_TRUE(parts) << parts.error().Text();
  EXPECT_EQ(parts->points[0].link[0].slot, 2);
  EXPECT_EQ(parts->points[1].link[0].slot, 3);
  EXPECT_EQ(parts->points[2].link[3].slot, 0);
  const ControlMesh mesh = ControlMesh::Make(*parts).value();
  EXPECT_EQ(mesh.axes().size(), 4U);
}

TEST(ControlMeshJson, RefusesWhatItDoesNotKnow) {
  const std::string good = ControlMeshToJson(MakeNet("regular:2x1").value());
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    const auto read = ControlMeshFromJson(text, "a.json");
    return read ? std::string() : read.error().Text();
  };
  EXPECT_TRUE(with("\"version\": 1", "\"version\": 1").empty());
  EXPECT_FALSE(with("\"version\": 1", "\"version\": 2").empty());
  EXPECT_FALSE(with("\"values\"", "\"valeus\"").empty());
  EXPECT_FALSE(with("\"height\"", "1").empty());
  EXPECT_NE(with("null", "\"open\"").find("points[0] links[1]"), std::string::npos);
  EXPECT_NE(with("null", "17").find("does not exist"), std::string::npos);
  EXPECT_FALSE(with("position_mm\": [", "position_mm\": [1e999,").empty());
}

}  // namespace
}  // namespace annulus
