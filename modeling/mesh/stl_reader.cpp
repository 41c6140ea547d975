#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#include "modeling/mesh/mesh_readers.h"

namespace annulus::mesh_readers {
namespace {

constexpr std::size_t kHeaderSize = 84;
constexpr std::size_t kFacetSize = 50;

// Gives corners at exactly the same place one vertex, numbered by first use; drops triangles that collapse.
TriangleMesh Weld(const std::vector<Eigen::Vector3d>& corners) {
  std::vector<std::uint32_t> order(corners.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto less = [&corners](std::uint32_t a, std::uint32_t b) {
    const Eigen::Vector3d& p = corners[a];
    const Eigen::Vector3d& q = corners[b];
    if (p.x() != q.x()) return p.x() < q.x();
    if (p.y() != q.y()) return p.y() < q.y();
    if (p.z() != q.z()) return p.z() < q.z();
    return a < b;
  };
  std::sort(order.begin(), order.end(), less);
  std::vector<std::uint32_t> first(corners.size());  // the first corner at the same place
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && corners[order[i]] == corners[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  TriangleMesh mesh;
  std::vector<std::uint32_t> number(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (first[i] == i) {
      number[i] = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(corners[i]);
    } else {
      number[i] = number[first[i]];
    }
  }
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    const std::array<std::uint32_t, 3> face{number[i], number[i + 1], number[i + 2]};
    if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) mesh.faces.push_back(face);
  }
  return mesh;
}

std::uint32_t CountOf(std::string_view bytes) {
  std::uint32_t count = 0;  // little-endian, as our processors
  std::memcpy(&count, bytes.data() + 80, sizeof(count));
  return count;
}

Result<TriangleMesh> ParseBinary(std::string_view bytes, const std::string& what) {
  const std::uint32_t count = CountOf(bytes);
  std::vector<Eigen::Vector3d> corners;
  corners.reserve(std::size_t{3} * count);
  for (std::size_t facet = 0; facet < count; ++facet) {
    std::array<float, 9> values{};
    std::memcpy(values.data(), bytes.data() + kHeaderSize + facet * kFacetSize + 12, sizeof(values));
    for (const float value : values) {
      if (!(std::abs(static_cast<double>(value)) <= kLargestCoordinate)) {
        return FailRead(what, fmt::format("triangle {} has a coordinate that is not a number or too large", facet + 1));
      }
    }
    for (std::size_t k = 0; k < 9; k += 3) corners.emplace_back(values[k], values[k + 1], values[k + 2]);
  }
  return Weld(corners);
}

Result<TriangleMesh> ParseAscii(std::string_view text, const std::string& what) {
  std::vector<Eigen::Vector3d> corners;
  LineReader lines(text);
  std::size_t in_facet = 0;
  bool ended = false;
  while (const auto line = lines.Next()) {
    const std::vector<std::string_view> words = SplitWords(*line);
    if (words.empty()) continue;
    const auto complain = [&](const std::string& why) {
      return FailRead(what, fmt::format("line {}: {}", lines.line_number(), why));
    };
    if (words[0] == "vertex") {
      Eigen::Vector3d vertex;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto value = axis + 1 < words.size() ? ParseCoordinate(words[axis + 1]) : std::nullopt;
        if (!value) return complain("'" + Shown(*line) + "' is not a vertex");
        vertex[static_cast<Eigen::Index>(axis)] = *value;
      }
      corners.push_back(vertex);
      ++in_facet;
    } else if (words[0] == "facet") {
      if (in_facet != 0) return complain("a facet begins within a facet");
    } else if (words[0] == "endfacet") {
      if (in_facet != 3) return complain(fmt::format("a facet of {} vertices", in_facet));
      in_facet = 0;
    } else if (words[0] == "endsolid") {
      ended = true;
    } else if (words[0] != "solid" && words[0] != "outer" && words[0] != "endloop") {
      return complain("'" + Shown(words[0]) + "' does not belong into an STL file");
    }
  }
  if (!ended || in_facet != 0) {
    return FailRead(what, fmt::format("line {}: the file ends before 'endsolid'", lines.line_number()));
  }
  return Weld(corners);
}

}  // namespace

Result<TriangleMesh> ParseStl(std::string_view bytes, const std::string& what) {
  // Some programs begin binary files with "solid" too: a size that fits the count decides.
  if (bytes.size() >= kHeaderSize && bytes.size() == kHeaderSize + kFacetSize * std::size_t{CountOf(bytes)}) {
    return ParseBinary(bytes, what);
  }
  if (bytes.starts_with("solid")) {
    return ParseAscii(bytes, what);
  }
  if (bytes.size() < kHeaderSize) return FailRead(what, fmt::format("{} bytes are no STL file", bytes.size()));
  return FailRead(
      what, fmt::format("{} triangles announced, but {} bytes of them", CountOf(bytes), bytes.size() - kHeaderSize));
}

}  // namespace annulus::mesh_readers
