#include "modeling/wrinkly/quad_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <unordered_map>
#include <utility>

#include "modeling/mesh/mesh_readers.h"

namespace annulus {
namespace {

using mesh_readers::FailRead;
using mesh_readers::LineReader;
using mesh_readers::ParseCoordinate;
using mesh_readers::ParseInteger;
using mesh_readers::Shown;
using mesh_readers::SplitWords;

/// One side of a face, waiting for its other face.
struct OpenSide {
  PointIndex face = -1;
  std::uint8_t slot = 0;
  std::uint32_t from = 0;
  bool joined = false;
};

tl::unexpected<Error> RefuseFace(std::size_t face, const std::string& seen, const char* advice) {
  return Fail("make a control mesh of quadrilaterals", fmt::format("face {} {}", face, seen), advice);
}

/// Joins the faces at their common edges.
class SideJoiner {
 public:
  explicit SideJoiner(ControlMeshParts& parts) : parts_(parts) {}

  Status Add(PointIndex face, std::uint8_t slot, std::array<std::uint32_t, 2> ends) {
    const auto [low, high] = std::minmax(ends[0], ends[1]);
    const std::uint64_t key = (std::uint64_t{low} << 32U) | high;
    const auto [at, is_new] = sides_.try_emplace(key, OpenSide{face, slot, ends[0]});
    if (is_new) return {};
    OpenSide& other = at->second;
    if (other.joined) {
      return RefuseFace(ControlMesh::Index(face), fmt::format("is the third at the edge {}-{}", low, high),
                        "mend the mesh: an edge has at most two faces");
    }
    if (other.from == ends[0]) {
      return RefuseFace(ControlMesh::Index(face),
                        fmt::format("runs along the edge {}-{} the same way as face {}", low, high, other.face),
                        "turn one of them round");
    }
    other.joined = true;
    LinkTo(face, slot, other.face, other.slot);
    LinkTo(other.face, other.slot, face, slot);
    return {};
  }

 private:
  void LinkTo(PointIndex face, std::uint8_t slot, PointIndex other, std::uint8_t other_slot) {
    parts_.points[ControlMesh::Index(face)].link[slot] = {ControlLink::Kind::kPoint, other_slot, other};
  }

  ControlMeshParts& parts_;
  std::unordered_map<std::uint64_t, OpenSide> sides_;
};

/// The vertex index of "7", "7/1", "7/1/3" or "-2"; from 0.
std::optional<std::uint32_t> VertexOf(std::string_view word, std::size_t vertices) {
  const auto number = ParseInteger(word.substr(0, word.find('/')));
  if (!number || *number == 0) return std::nullopt;
  const long long index = *number > 0 ? *number - 1 : static_cast<long long>(vertices) + *number;
  if (index < 0 || index >= static_cast<long long>(vertices)) return std::nullopt;
  return static_cast<std::uint32_t>(index);
}

}  // namespace

Result<ControlMeshParts> ControlMeshOfQuads(const QuadMesh& mesh) {
  ControlMeshParts parts;
  parts.points.resize(mesh.quads.size());
  parts.values = decltype(parts.values)::Zero(static_cast<Eigen::Index>(mesh.quads.size()), 1);
  SideJoiner joiner(parts);
  for (std::size_t face = 0; face < mesh.quads.size(); ++face) {
    const auto& quad = mesh.quads[face];
    if (*std::max_element(quad.begin(), quad.end()) >= mesh.vertices.size()) {
      return RefuseFace(face, "has a vertex that does not exist", "mend the mesh");
    }
    ControlPoint& point = parts.points[face];
    for (std::uint8_t slot = 0; slot < 4; ++slot) {
      point.position += 0.25 * mesh.vertices[quad[slot]];
      const std::array<std::uint32_t, 2> ends{quad[slot], quad[(slot + 1U) % 4]};
      if (ends[0] == ends[1]) {
        point.link[slot].kind = ControlLink::Kind::kClosed;
      } else {
        RETURN_IF_ERROR(joiner.Add(static_cast<PointIndex>(face), slot, ends));
      }
    }
  }
  return parts;
}

namespace {

/// A face's corners, any number of them.
using Polygon = std::vector<std::uint32_t>;

/// Cuts polygons into quadrilaterals; the middles of edges are shared.
QuadMesh Split(std::vector<Eigen::Vector3d> vertices, const std::vector<Polygon>& polygons) {
  QuadMesh mesh{std::move(vertices), {}};
  std::unordered_map<std::uint64_t, std::uint32_t> middles;
  const auto middle_of = [&](std::uint32_t a, std::uint32_t b) {
    const auto [low, high] = std::minmax(a, b);
    const std::uint64_t key = (std::uint64_t{low} << 32U) | high;
    const auto [at, is_new] = middles.try_emplace(key, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back(0.5 * (mesh.vertices[low] + mesh.vertices[high]));
    return at->second;
  };
  for (const Polygon& polygon : polygons) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const std::uint32_t corner : polygon) centre += mesh.vertices[corner] / static_cast<double>(polygon.size());
    const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(centre);
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const std::uint32_t corner = polygon[k];
      mesh.quads.push_back({corner, middle_of(corner, polygon[(k + 1) % polygon.size()]), middle,
                            middle_of(polygon[(k + polygon.size() - 1) % polygon.size()], corner)});
    }
  }
  return mesh;
}

}  // namespace

Result<QuadMesh> QuadMeshFromObj(std::string_view text, const std::string& what, PolygonRule rule) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Polygon> polygons;
  LineReader lines(text);
  while (const auto line = lines.Next()) {
    const std::vector<std::string_view> words = SplitWords(*line);
    if (words.empty()) continue;
    const auto refuse = [&](const std::string& seen) {
      return FailRead(what, fmt::format("line {}: {}", lines.line_number(), seen));
    };
    if (words[0] == "v") {
      Eigen::Vector3d vertex;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto value = k + 1 < words.size() ? ParseCoordinate(words[k + 1]) : std::nullopt;
        if (!value) return refuse("a vertex is not three numbers");
        vertex[static_cast<Eigen::Index>(k)] = *value;
      }
      vertices.push_back(vertex);
    } else if (words[0] == "f") {
      if (words.size() < 4 || (words.size() != 5 && rule == PolygonRule::kRefuse)) {
        return refuse(
            fmt::format("a face has {} corners; every patch of a control mesh has four, unless polygons are "
                        "to be split",
                        words.size() - 1));
      }
      Polygon polygon;
      for (std::size_t k = 1; k < words.size(); ++k) {
        const auto vertex = VertexOf(words[k], vertices.size());
        if (!vertex) return refuse(fmt::format("'{}' is none of the vertices so far", Shown(words[k])));
        polygon.push_back(*vertex);
      }
      polygons.push_back(std::move(polygon));
    }
  }
  if (polygons.empty()) return FailRead(what, "it has no face");
  if (rule == PolygonRule::kSplit) return Split(std::move(vertices), polygons);
  QuadMesh mesh{std::move(vertices), {}};
  for (const Polygon& polygon : polygons) mesh.quads.push_back({polygon[0], polygon[1], polygon[2], polygon[3]});
  return mesh;
}

}  // namespace annulus
