#include "modeling/mesh/mesh_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>

#include "shapes.h"

namespace annulus {
namespace {

using ::testing::HasSubstr;

Result<TriangleMesh> Parse(const std::string& text, MeshFormat format) {
  return ParseMesh(std::as_bytes(std::span(text.data(), text.size())), format, "it");
}

std::string ErrorOf(const std::string& text, MeshFormat format) {
  const Result<TriangleMesh> mesh = Parse(text, format);
  return mesh ? "no error" : mesh.error().Text();
}

template <class T>
std::string Bytes(T value, bool big = false) {
  std::string raw(sizeof(T), '\0');
  std::memcpy(raw.data(), &value, sizeof(T));
  if (big) std::reverse(raw.begin(), raw.end());
  return raw;
}

TEST(MeshIo, ReadsBackWhatItWrites) {
  const TriangleMesh torus = test_shapes::Torus(20.0, 6.0, 24, 12);
  for (const auto& [bytes, format, tolerance] :
       {std::tuple{WriteStl(torus, "torus"), MeshFormat::kStl, 1e-5},
        std::tuple{WritePly(torus), MeshFormat::kPly, 0.0}, std::tuple{WriteObj(torus), MeshFormat::kObj, 1e-6}}) {
    const Result<TriangleMesh> read = Parse(bytes, format);
    ASSERT_TRUE(read) << read.error().Text();
    EXPECT_EQ(read->vertices.size(), torus.vertices.size());  // the STL's corners are welded
    EXPECT_EQ(read->faces.size(), torus.faces.size());
    EXPECT_EQ(CountOpenEdges(*read), 0U);
    EXPECT_NEAR(SignedVolume(*read), SignedVolume(torus), 5e-3);
    for (std::size_t i = 0; format != MeshFormat::kStl && i < torus.vertices.size(); ++i) {
      EXPECT_LE((read->vertices[i] - torus.vertices[i]).norm(), tolerance);
    }
  }
}

TEST(MeshIo, WritesTheBinaryStlOfItsDefinition) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}};
  mesh.faces = {{0, 1, 2}};
  const std::string bytes = WriteStl(mesh, "solid frame");
  ASSERT_EQ(bytes.size(), 134U);
  EXPECT_EQ(bytes.substr(0, 12), "Solid frame ");  // a small "solid" would mean text
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  EXPECT_EQ(count, 1U);
  float values[12];
  std::memcpy(values, bytes.data() + 84, sizeof(values));
  const float expected[12] = {0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0};
  for (int i = 0; i < 12; ++i) EXPECT_EQ(values[i], expected[i]);
  EXPECT_EQ(bytes, WriteStl(mesh, "solid frame"));
}

TEST(MeshIo, ReadsObjWithPolygonsTexturesAndCountsFromTheEnd) {
  const auto mesh =
      Parse("# c\r\nmtllib a.mtl\nv 0 0 0 1\nv 1 0 0\nv 1 1 0\nv 0 +1 0\nvn 0 0 1\nf 1/1/1 2//1 3 4\nf -4 -3 -2\n",
            MeshFormat::kObj);
  ASSERT_TRUE(mesh) << mesh.error().Text();
  EXPECT_EQ(mesh->faces.size(), 3U);
  EXPECT_EQ(mesh->faces[2], (std::array<std::uint32_t, 3>{0, 1, 2}));
  EXPECT_DOUBLE_EQ(SurfaceArea(*mesh), 1.5);
}

TEST(MeshIo, ReadsAsciiPlyAndSkipsWhatItDoesNotNeed) {
  const auto mesh = Parse(
      "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty float y\nproperty uchar red\n"
      "property float z\nelement edge 1\nproperty int v1\nproperty int v2\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 9 0\n1 0 9 0\n1 1 9 0\n0 1 9 0\n0 1\n4 0 1 2 3\n",
      MeshFormat::kPly);
  ASSERT_TRUE(mesh) << mesh.error().Text();
  EXPECT_DOUBLE_EQ(SurfaceArea(*mesh), 1.0);
}

TEST(MeshIo, ReadsBinaryPlyOfEitherEndianness) {
  for (const bool big : {false, true}) {
    std::string text = std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
                       " 1.0\nelement vertex 3\nproperty float x\nproperty double y\nproperty short z\nelement face 1\n"
                       "property list uchar ushort vertex_index\nproperty int tag\nend_header\n";
    const int corners[3][3] = {{0, 0, 7}, {3, 0, 7}, {0, 4, 7}};
    for (const auto& c : corners) {
      text += Bytes(static_cast<float>(c[0]), big) + Bytes(static_cast<double>(c[1]), big) +
              Bytes(static_cast<std::int16_t>(c[2]), big);
    }
    text += Bytes(std::uint8_t{3});
    for (std::uint16_t i = 0; i < 3; ++i) text += Bytes(i, big);
    text += Bytes(std::int32_t{5}, big);
    const auto mesh = Parse(text, MeshFormat::kPly);
    ASSERT_TRUE(mesh) << mesh.error().Text();
    EXPECT_DOUBLE_EQ(SurfaceArea(*mesh), 6.0);
    EXPECT_DOUBLE_EQ(mesh->vertices[2].z(), 7.0);
    EXPECT_THAT(ErrorOf(text.substr(0, text.size() - 5), MeshFormat::kPly), HasSubstr("read mesh it"));
  }
}

TEST(MeshIo, RefusesABinaryPlyWithANaN) {  // once accepted; found by the fuzz target
  TriangleMesh mesh = test_shapes::Box({0, 0, 0}, {1, 1, 1});
  mesh.vertices[4].y() = std::nan("");
  EXPECT_THAT(ErrorOf(WritePly(mesh), MeshFormat::kPly), HasSubstr("vertex 5 has a coordinate that is not a number"));
}

TEST(MeshIo, ReadsAsciiStl) {
  const auto mesh = Parse(
      "solid a\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n  endloop\n "
      "endfacet\n"
      " facet normal 0 0 1\n  outer loop\n   vertex 1 0 0\n   vertex 1 1 0\n   vertex 0 1 -0.0\n  endloop\n endfacet\n"
      "endsolid a\n",
      MeshFormat::kStl);
  ASSERT_TRUE(mesh) << mesh.error().Text();
  EXPECT_EQ(mesh->vertices.size(), 4U);
  EXPECT_DOUBLE_EQ(SurfaceArea(*mesh), 1.0);
}

TEST(MeshIo, SaysWhatIsWrongAndWhere) {
  const auto obj = MeshFormat::kObj;
  EXPECT_THAT(ErrorOf("v 0 0 0\nv 1 x 0\n", obj), HasSubstr("line 2: 'v 1 x 0' is not a vertex"));
  EXPECT_THAT(ErrorOf("v 0 0 inf\n", obj), HasSubstr("line 1"));
  EXPECT_THAT(ErrorOf("v 0 0\n", obj), HasSubstr("line 1"));
  EXPECT_THAT(ErrorOf("v 0 0 1e300\n", obj), HasSubstr("line 1"));
  EXPECT_THAT(ErrorOf("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", obj), HasSubstr("line 4: '4' names none of the 3"));
  EXPECT_THAT(ErrorOf("v 0 0 0\nv 1 0 0\nf 1 2\n", obj), HasSubstr("line 3: a face of 2 corners"));
  EXPECT_THAT(ErrorOf("v 0 0 0\nf 0 1 1\n", obj), HasSubstr("line 2"));
  EXPECT_THAT(ErrorOf("", obj), HasSubstr("no triangle"));
  const auto ply = MeshFormat::kPly;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  EXPECT_THAT(ErrorOf("plx\n", ply), HasSubstr("line 1: not 'ply'"));
  EXPECT_THAT(ErrorOf("ply\nformat ascii 2.0\n", ply), HasSubstr("line 2"));
  EXPECT_THAT(ErrorOf("ply\nelement vertex -3\n", ply), HasSubstr("line 2"));
  EXPECT_THAT(ErrorOf("ply\nproperty float x\n", ply), HasSubstr("before any element"));
  EXPECT_THAT(ErrorOf(head, ply), HasSubstr("the header has no end"));
  EXPECT_THAT(ErrorOf(head + "property quark q\nend_header\n", ply), HasSubstr("line 7"));
  EXPECT_THAT(ErrorOf(head + "end_header\n0 nan 0\n", ply), HasSubstr("line 8"));
  EXPECT_THAT(ErrorOf(head + "element face 999999999\nproperty list uchar int vertex_index\nend_header\n0 0 0\n", ply),
              HasSubstr("999999999 records 'face' announced"));
  EXPECT_THAT(
      ErrorOf(head + "element face 1\nproperty list int int vertex_index\nend_header\n0 0 0\n100000000 0\n", ply),
      HasSubstr("length of a list"));
  EXPECT_THAT(ErrorOf(head + "element face 1\nproperty list int int vertex_index\nend_header\n0 0 0\n3 0 0 1\n", ply),
              HasSubstr("names vertex 1 of 1"));
  EXPECT_THAT(ErrorOf(head + "element nothing 4000000000\nend_header\n0 0 0\n", ply), HasSubstr("announced"));
  EXPECT_THAT(ErrorOf("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n", ply),
              HasSubstr("no element 'vertex' with x, y and z"));
  const auto stl = MeshFormat::kStl;
  EXPECT_THAT(ErrorOf("no", stl), HasSubstr("2 bytes"));
  EXPECT_THAT(ErrorOf("solid a\nfacet\nvertex 1 2\n", stl), HasSubstr("line 3"));
  EXPECT_THAT(ErrorOf("solid a\nfacet\nvertex 1 2 3\nendfacet\n", stl), HasSubstr("line 4: a facet of 1 vertices"));
  EXPECT_THAT(ErrorOf("solid a\n", stl), HasSubstr("before 'endsolid'"));
  EXPECT_THAT(ErrorOf("solid a\n<html>\n", stl), HasSubstr("line 2"));
  std::string binary = WriteStl(test_shapes::Box({0, 0, 0}, {1, 1, 1}), "box");
  EXPECT_THAT(ErrorOf(binary.substr(0, 200), stl), HasSubstr("12 triangles announced, but 116 bytes"));
  const float nan = std::nanf("");
  std::memcpy(binary.data() + 84 + 50 + 12, &nan, 4);
  EXPECT_THAT(ErrorOf(binary, stl), HasSubstr("triangle 2"));
}

TEST(MeshIo, TakesTheFormatFromTheExtension) {
  PosixStorage storage;
  const std::string folder = std::filesystem::temp_directory_path().string() + "/annulus_mesh_io_test";
  ASSERT_TRUE(storage.CreateFolder(folder));
  const TriangleMesh box = test_shapes::Box({0, 0, 0}, {1, 1, 1});
  ASSERT_TRUE(WriteFileAtomically(storage, folder + "/a.PLY", WritePly(box)));
  ASSERT_TRUE(WriteFileAtomically(storage, folder + "/a.step", WritePly(box)));
  EXPECT_TRUE(ReadMesh(storage, folder + "/a.PLY"));
  EXPECT_THAT(ReadMesh(storage, folder + "/a.step").error().Text(), HasSubstr("the extension is '.step'"));
  EXPECT_FALSE(ReadMesh(storage, folder + "/missing.stl"));
  EXPECT_FALSE(ReadMesh(storage, folder + "/no_extension"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace annulus
