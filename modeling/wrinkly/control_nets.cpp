#include "modeling/wrinkly/control_nets.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "modeling/wrinkly/quad_mesh.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr int kMostPerDirection = 4096;
constexpr std::int64_t kMostPoints = 4'000'000;

Status Check(const char* name, std::initializer_list<std::pair<int, int>> counts_and_least, std::int64_t points) {
  for (const auto& [count, least] : counts_and_least) {
    if (count < least || count > kMostPerDirection || points > kMostPoints) {
      return Fail(fmt::format("make a {} net", name), fmt::format("one of its counts is {}", count),
                  fmt::format("use {} to {}, and at most {} points in all", least, kMostPerDirection, kMostPoints));
    }
  }
  return {};
}

/// Parts of `count` points without links, all attributes 0.
ControlMeshParts Unlinked(std::size_t count) {
  ControlMeshParts parts;
  parts.points.resize(count);
  parts.values = decltype(parts.values)::Zero(static_cast<Eigen::Index>(count), 1);
  return parts;
}

/// Links side `slot` of one point to the opposite side of the other.
void Join(ControlMeshParts& parts, std::size_t from, std::size_t slot, std::size_t to) {
  const std::size_t back = (slot + 2) % 4;
  parts.points[from].link[slot] = {ControlLink::Kind::kPoint, static_cast<std::uint8_t>(back),
                                   static_cast<PointIndex>(to)};
  parts.points[to].link[back] = {ControlLink::Kind::kPoint, static_cast<std::uint8_t>(slot),
                                 static_cast<PointIndex>(from)};
}

/// Where a point of a regular net stands.
Vector3d RegularPlace(const RegularNet& net, double column, double row) {
  if (net.columns_kind == AxisKind::kOpen) return net.spacing * Vector3d(column, row, 0.0);
  const double around = net.columns * net.spacing / (2.0 * std::numbers::pi);
  const double theta = 2.0 * std::numbers::pi * column / net.columns;
  if (net.rows_kind == AxisKind::kOpen) {
    return {around * std::cos(theta), around * std::sin(theta), net.spacing * row};
  }
  const double across = net.rows * net.spacing / (2.0 * std::numbers::pi);
  const double phi = 2.0 * std::numbers::pi * row / net.rows;
  const double radius = std::max(around, 1.5 * across) + across * std::cos(phi);
  return {radius * std::cos(theta), radius * std::sin(theta), across * std::sin(phi)};
}

}  // namespace

Result<ControlMeshParts> MakeNet(const RegularNet& net) {
  RETURN_IF_ERROR(Check("regular", {{net.columns, 1}, {net.rows, 1}}, std::int64_t{net.columns} * net.rows));
  const auto columns = static_cast<std::size_t>(net.columns);
  const auto rows = static_cast<std::size_t>(net.rows);
  ControlMeshParts parts = Unlinked(columns * rows);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t k = row * columns + column;
      parts.points[k].position = RegularPlace(net, static_cast<double>(column), static_cast<double>(row));
      const bool right = column + 1 < columns || net.columns_kind == AxisKind::kCyclic;
      const bool up = row + 1 < rows || net.rows_kind == AxisKind::kCyclic;
      if (right) Join(parts, k, 0, row * columns + (column + 1) % columns);
      if (up) Join(parts, k, 1, (row + 1) % rows * columns + column);
    }
  }
  return parts;
}

Result<ControlMeshParts> MakeBorderedNet(const RegularNet& net) {
  RegularNet whole = net;
  whole.columns += 2;
  whole.rows += 2;
  auto parts = MakeNet(whole);
  if (!parts) return Fail(parts);
  for (int row = 0; row < whole.rows; ++row) {
    for (int column = 0; column < whole.columns; ++column) {
      const bool border = row == 0 || column == 0 || row + 1 == whole.rows || column + 1 == whole.columns;
      parts->points[static_cast<std::size_t>(row * whole.columns + column)].temporary = border;
    }
  }
  return parts;
}

Result<ControlMeshParts> MakeNet(const DirectionsNet& net) {
  if (net.directions < 2 || net.directions > 12) {
    return Fail("make a directions net", fmt::format("it has {} directions", net.directions), "use 2 to 12");
  }
  const int sectors = 2 * net.directions;
  RETURN_IF_ERROR(Check("directions", {{net.rings, 1}}, std::int64_t{sectors} * net.rings * net.rings));
  QuadMesh quads;
  // Vertices by sector and steps along its two sides; a sector's second side is the next one's first.
  std::map<std::array<int, 3>, std::uint32_t> numbers;
  const auto vertex = [&](int sector, int i, int j) {
    if (i == 0 && j == 0) sector = 0;
    if (i == 0 && j > 0) {
      sector = (sector + 1) % sectors;
      std::swap(i, j);
    }
    const auto [at, is_new] = numbers.try_emplace({sector, i, j}, static_cast<std::uint32_t>(quads.vertices.size()));
    if (is_new) {
      const double angle = std::numbers::pi / net.directions;
      const auto ray = [&](int k) { return Vector3d(std::cos(angle * k), std::sin(angle * k), 0.0); };
      quads.vertices.push_back(net.spacing * (i * ray(sector) + j * ray(sector + 1)));
    }
    return at->second;
  };
  for (int sector = 0; sector < sectors; ++sector) {
    for (int i = 0; i < net.rings; ++i) {
      for (int j = 0; j < net.rings; ++j) {
        quads.quads.push_back(
            {vertex(sector, i, j), vertex(sector, i + 1, j), vertex(sector, i + 1, j + 1), vertex(sector, i, j + 1)});
      }
    }
  }
  return ControlMeshOfQuads(quads);
}

Result<ControlMeshParts> MakeNet(const RingNet& net) {
  RETURN_IF_ERROR(Check("ring", {{net.spokes, 3}, {net.rings, 2}}, std::int64_t{net.spokes} * net.rings));
  const auto spokes = static_cast<std::size_t>(net.spokes);
  const auto rings = static_cast<std::size_t>(net.rings);
  ControlMeshParts parts = Unlinked(spokes * rings);
  for (std::size_t ring = 0; ring < rings; ++ring) {
    for (std::size_t spoke = 0; spoke < spokes; ++spoke) {
      const std::size_t k = ring * spokes + spoke;
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(spoke) / static_cast<double>(spokes);
      const double radius = net.spacing * (static_cast<double>(ring) + 0.5);
      // Round is slot 1, outward slot 0: counter-clockwise seen from +z.
      parts.points[k].position = radius * Vector3d(std::cos(angle), std::sin(angle), 0.0);
      Join(parts, k, 1, ring * spokes + (spoke + 1) % spokes);
      if (ring + 1 < rings) Join(parts, k, 0, k + spokes);
      if (ring == 0) parts.points[k].link[2].kind = ControlLink::Kind::kClosed;
    }
  }
  return parts;
}

Result<ControlMeshParts> MakeNet(const SpiralNet& net) {
  RETURN_IF_ERROR(Check("spiral", {{net.per_turn, 3}, {net.points, net.per_turn + 1}}, net.points));
  const auto turn = static_cast<std::size_t>(net.per_turn);
  const auto count = static_cast<std::size_t>(net.points);
  ControlMeshParts parts = Unlinked(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double turns = static_cast<double>(k) / static_cast<double>(turn);
    const double angle = 2.0 * std::numbers::pi * turns;
    parts.points[k].position = net.spacing * (turns + 0.25) * Vector3d(std::cos(angle), std::sin(angle), 0.0);
    if (k + 1 < count) Join(parts, k, 1, k + 1);
    if (k + turn < count) Join(parts, k, 0, k + turn);
    if (k < turn) parts.points[k].link[2].kind = ControlLink::Kind::kClosed;
  }
  parts.points.front().link[3].kind = ControlLink::Kind::kClosed;
  return parts;
}

Result<ControlMeshParts> MakeNet(std::string_view name) {
  const auto refuse = [&] {
    return Fail("make a control net", fmt::format("it is called '{}'", name.substr(0, 40)),
                "use regular:CxR, tube:CxR, torus:CxR, bordered:CxR, directions:NxRINGS, ring:SPOKESxRINGS or "
                "spiral:PER_TURNxPOINTS");
  };
  const std::size_t colon = name.find(':');
  const std::size_t cross = name.find('x', colon == std::string_view::npos ? 0 : colon);
  if (colon == std::string_view::npos || cross == std::string_view::npos) return refuse();
  const auto number = [&](std::string_view text) {
    int value = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() ? value : -1;
  };
  const int a = number(name.substr(colon + 1, cross - colon - 1));
  const int b = number(name.substr(cross + 1));
  if (a < 0 || b < 0) return refuse();
  const std::string_view kind = name.substr(0, colon);
  if (kind == "regular") return MakeNet(RegularNet{a, b});
  if (kind == "tube") return MakeNet(RegularNet{a, b, AxisKind::kCyclic});
  if (kind == "torus") return MakeNet(RegularNet{a, b, AxisKind::kCyclic, AxisKind::kCyclic});
  if (kind == "bordered") return MakeBorderedNet(RegularNet{a, b});
  if (kind == "directions") return MakeNet(DirectionsNet{a, b});
  if (kind == "ring") return MakeNet(RingNet{a, b});
  if (kind == "spiral") return MakeNet(SpiralNet{a, b});
  return refuse();
}

double ScatteredNumber(std::uint64_t seed, std::uint64_t index) {
  // SplitMix64's finaliser: every bit of the input reaches every bit of the output.
  std::uint64_t x = seed * 0x9e3779b97f4a7c15ULL + index + 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  x ^= x >> 31U;
  return static_cast<double>(x >> 11U) * 0x1.0p-53;
}

}  // namespace annulus
