#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace annulus::test {

/// A mesh as a page reads it: written from docs/console_api.md §7 alone.
struct ReadMesh {
  struct Part {
    std::uint32_t first_index = 0;
    std::uint32_t count = 0;
    std::uint32_t kind = 0;
    float colour[4] = {};
  };
  std::vector<float> positions;
  std::vector<float> normals;
  std::vector<std::uint8_t> knowledge;
  std::vector<std::uint32_t> indices;
  std::vector<Part> parts;
};

/// Requires a machine that is little-endian, as the bytes are.
inline ReadMesh ReadMeshBytes(const std::string& bytes) {
  std::size_t at = 0;
  const auto take = [&](void* to, std::size_t size) {
    ASSERT_LE(at + size, bytes.size());
    std::memcpy(to, bytes.data() + at, size);
    at += size;
  };
  std::uint32_t head[4] = {};
  take(head, sizeof head);
  EXPECT_EQ(head[0], 0x4d534e41U);
  EXPECT_EQ(head[1], 1U);
  ReadMesh mesh;
  mesh.positions.resize(3 * std::size_t{head[2]});
  mesh.normals.resize(3 * std::size_t{head[2]});
  mesh.knowledge.resize((head[2] + 3) / 4 * 4);
  mesh.indices.resize(3 * std::size_t{head[3]});
  take(mesh.positions.data(), 4 * mesh.positions.size());
  take(mesh.normals.data(), 4 * mesh.normals.size());
  take(mesh.knowledge.data(), mesh.knowledge.size());
  mesh.knowledge.resize(head[2]);
  take(mesh.indices.data(), 4 * mesh.indices.size());
  std::uint32_t parts = 0;
  take(&parts, 4);
  for (std::uint32_t k = 0; k < parts && !testing::Test::HasFatalFailure(); ++k) {
    ReadMesh::Part part;
    take(&part, sizeof part);
    mesh.parts.push_back(part);
  }
  EXPECT_EQ(at, bytes.size());
  return mesh;
}

}  // namespace annulus::test
