#include <fmt/format.h>

#include "modeling/mesh/mesh_readers.h"

namespace annulus::mesh_readers {
namespace {

// The vertex of "7", "7/1", "7//2", "7/1/2" or "-1" (counted back from the last one), from 0.
std::optional<std::uint32_t> ParseIndex(std::string_view word, std::size_t vertex_count) {
  const auto index = ParseInteger(word.substr(0, word.find('/')));
  if (!index) return std::nullopt;
  const auto count = static_cast<long long>(vertex_count);
  const long long from_zero = *index > 0 ? *index - 1 : count + *index;
  if (*index == 0 || from_zero < 0 || from_zero >= count) return std::nullopt;
  return static_cast<std::uint32_t>(from_zero);
}

}  // namespace

Result<TriangleMesh> ParseObj(std::string_view text, const std::string& what) {
  TriangleMesh mesh;
  LineReader lines(text);
  while (const auto line = lines.Next()) {
    const std::vector<std::string_view> words = SplitWords(*line);
    if (words.empty()) continue;
    if (words[0] == "v") {
      Eigen::Vector3d vertex;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto value = axis + 1 < words.size() ? ParseCoordinate(words[axis + 1]) : std::nullopt;
        if (!value) {
          return FailRead(what, fmt::format("line {}: '{}' is not a vertex", lines.line_number(), Shown(*line)));
        }
        vertex[static_cast<Eigen::Index>(axis)] = *value;
      }
      mesh.vertices.push_back(vertex);
    } else if (words[0] == "f") {
      std::vector<std::uint32_t> corners;
      for (std::size_t i = 1; i < words.size(); ++i) {
        const auto corner = ParseIndex(words[i], mesh.vertices.size());
        if (!corner) {
          return FailRead(what, fmt::format("line {}: '{}' names none of the {} vertices so far", lines.line_number(),
                                            Shown(words[i]), mesh.vertices.size()));
        }
        corners.push_back(*corner);
      }
      if (corners.size() < 3) {
        return FailRead(what, fmt::format("line {}: a face of {} corners", lines.line_number(), corners.size()));
      }
      for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        mesh.faces.push_back({corners[0], corners[i], corners[i + 1]});
      }
    }
  }
  return mesh;
}

}  // namespace annulus::mesh_readers
