#include "modeling/flatten/curved_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

namespace annulus {
namespace {

constexpr double kThinnest = 1e-9;  ///< Height of a triangle over its longest side.
constexpr std::uint32_t kNone = 0xffffffffU;

std::uint64_t KeyOf(std::uint32_t from, std::uint32_t to) { return (std::uint64_t{from} << 32U) | to; }

tl::unexpected<Error> Refuse(std::string seen, const char* advice) {
  return Fail("lay the sheet flat", std::move(seen), advice);
}

/// Every side in the direction in which its triangle runs, with the face.
using Sides = std::unordered_map<std::uint64_t, std::uint32_t>;

Result<Sides> SidesOf(const CurvedSheet& sheet) {
  Sides sides;
  sides.reserve(4 * sheet.faces.size());
  for (std::size_t f = 0; f < sheet.faces.size(); ++f) {
    const auto& face = sheet.faces[f];
    const auto& l = sheet.lengths[f];
    for (std::size_t k = 0; k < 3; ++k) {
      if (face[k] >= sheet.places.size() || face[k] == face[(k + 1) % 3]) {
        return Refuse(fmt::format("triangle {} has a corner that is not there or two that are one", f),
                      "repair the mesh");
      }
      if (!sides.emplace(KeyOf(face[k], face[(k + 1) % 3]), static_cast<std::uint32_t>(f)).second) {
        return Refuse(fmt::format("triangle {} shares a side with two others, or is turned over", f),
                      "repair the mesh, or cut it where three sheets meet");
      }
    }
    const double longest = std::max({l[0], l[1], l[2]});
    const LaidTriangle laid = longest > 0.0 && std::isfinite(longest) ? LayTriangle(l) : LaidTriangle{};
    if (!(laid.base > 0.0 && laid.apex.y() > kThinnest * longest)) {
      return Refuse(fmt::format("triangle {} has no area (sides {:g}, {:g}, {:g} mm)", f, l[0], l[1], l[2]),
                    "remove triangles without area, or take another element size");
    }
  }
  return sides;
}

/// The next rim side after each rim vertex.
Result<std::vector<std::uint32_t>> RimSteps(const CurvedSheet& sheet, const Sides& sides) {
  std::vector<std::uint32_t> next(sheet.places.size(), kNone);
  for (const auto& face : sheet.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = face[k];
      const std::uint32_t to = face[(k + 1) % 3];
      if (sides.contains(KeyOf(to, from))) continue;
      if (next[from] != kNone) return Refuse(fmt::format("only a point joins it at vertex {}", from), "cut it there");
      next[from] = to;
    }
  }
  return next;
}

void NameParts(const CurvedSheet& sheet, SheetTopology& topology) {
  std::vector<std::uint32_t> root(sheet.places.size());
  for (std::size_t v = 0; v < root.size(); ++v) root[v] = static_cast<std::uint32_t>(v);
  const auto find = [&root](std::uint32_t v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const auto& face : sheet.faces) {
    root[find(face[1])] = find(face[0]);
    root[find(face[2])] = find(face[0]);
  }
  std::vector<std::uint32_t> number(root.size(), kNone);
  topology.part_of_vertex.resize(root.size());
  for (std::size_t v = 0; v < root.size(); ++v) {
    std::uint32_t& part = number[find(static_cast<std::uint32_t>(v))];
    if (part == kNone) part = static_cast<std::uint32_t>(topology.parts++);
    topology.part_of_vertex[v] = part;
  }
}

/// Each part must be a disk: one rim, and Euler's V − E + F = 1.
Status CheckDisks(const CurvedSheet& sheet, const SheetTopology& topology) {
  std::vector<long> euler(topology.parts, 0);
  std::vector<int> rims(topology.parts, 0);
  for (const std::uint32_t part : topology.part_of_vertex) ++euler[part];
  for (const auto& edge : topology.edges) --euler[topology.part_of_vertex[edge[0]]];
  for (const auto& face : sheet.faces) ++euler[topology.part_of_vertex[face[0]]];
  for (const auto& rim : topology.rims) ++rims[topology.part_of_vertex[rim.front()]];
  for (std::size_t p = 0; p < topology.parts; ++p) {
    if (euler[p] == 1 && rims[p] == 1) continue;
    return Refuse(fmt::format("a part of it has {} rims and Euler's number {}", rims[p], euler[p]),
                  "cut it open so that each piece has one rim and no hole or handle; remove loose points");
  }
  return {};
}

}  // namespace

CurvedSheet SheetOfMesh(const TriangleMesh& mesh) {
  CurvedSheet sheet{mesh.faces, {}, mesh.vertices};
  sheet.lengths.reserve(mesh.faces.size());
  for (const auto& face : mesh.faces) {
    std::array<double, 3> lengths{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t from = face[k];
      const std::size_t to = face[(k + 1) % 3];
      if (std::max(from, to) < mesh.vertices.size()) lengths[k] = (mesh.vertices[to] - mesh.vertices[from]).norm();
    }
    sheet.lengths.push_back(lengths);
  }
  return sheet;
}

LaidTriangle LayTriangle(const std::array<double, 3>& lengths) {
  const auto [c, a, b] = lengths;  // sides 01, 12, 20
  LaidTriangle laid{c, {}};
  laid.apex.x() = (b * b + c * c - a * a) / (2.0 * c);
  // Kahan's form of Heron's formula keeps thin triangles exact.
  std::array<double, 3> s{a, b, c};
  std::sort(s.begin(), s.end(), std::greater<>());
  const double product =
      (s[0] + (s[1] + s[2])) * (s[2] - (s[0] - s[1])) * (s[2] + (s[0] - s[1])) * (s[0] + (s[1] - s[2]));
  laid.apex.y() = product > 0.0 ? 0.5 * std::sqrt(product) / c : 0.0;
  return laid;
}

Result<SheetTopology> CheckSheet(const CurvedSheet& sheet) {
  if (sheet.faces.empty() || sheet.lengths.size() != sheet.faces.size()) {
    return Refuse("it has no triangles", "give a mesh with a rim");
  }
  const auto sides = SidesOf(sheet);
  if (!sides) return Fail(sides);
  SheetTopology topology;
  for (const auto& face : sheet.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = face[k];
      const std::uint32_t to = face[(k + 1) % 3];
      if (from < to || !sides->contains(KeyOf(to, from)))
        topology.edges.push_back({std::min(from, to), std::max(from, to)});
    }
  }
  NameParts(sheet, topology);
  auto next = RimSteps(sheet, *sides);
  if (!next) return Fail(next);
  for (std::size_t v = 0; v < next->size(); ++v) {
    std::vector<std::uint32_t> rim;
    for (auto at = static_cast<std::uint32_t>(v); (*next)[at] != kNone;) {
      rim.push_back(at);
      at = std::exchange((*next)[at], kNone);
    }
    if (!rim.empty()) topology.rims.push_back(std::move(rim));
  }
  RETURN_IF_ERROR(CheckDisks(sheet, topology));
  return topology;
}

std::vector<double> AngleDefects(const CurvedSheet& sheet, const SheetTopology& topology) {
  std::vector<double> defect(sheet.places.size(), 2.0 * std::numbers::pi);
  for (std::size_t f = 0; f < sheet.faces.size(); ++f) {
    const LaidTriangle laid = LayTriangle(sheet.lengths[f]);
    const double first = std::atan2(laid.apex.y(), laid.apex.x());
    const double second = std::atan2(laid.apex.y(), laid.base - laid.apex.x());
    defect[sheet.faces[f][0]] -= first;
    defect[sheet.faces[f][1]] -= second;
    defect[sheet.faces[f][2]] -= std::numbers::pi - first - second;
  }
  for (const auto& rim : topology.rims) {
    for (const std::uint32_t v : rim) defect[v] = 0.0;
  }
  return defect;
}

double SheetArea(const CurvedSheet& sheet) {
  double area = 0.0;
  for (const auto& lengths : sheet.lengths) area += LayTriangle(lengths).Area();
  return area;
}

}  // namespace annulus
