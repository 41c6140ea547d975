#include "modeling/flatten/piece_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace annulus {
namespace {

using Eigen::Vector2d;

/// Part of each vertex; parts are numbered as they come along the outline, so that another body has the same numbers.
struct Parts {
  std::vector<std::uint32_t> of_vertex;
  std::uint32_t count = 0;
};

Parts FindParts(const BodyPiece& piece) {
  const CurvedSheet& sheet = piece.sheet;
  std::vector<std::uint32_t> leader(sheet.places.size());
  std::iota(leader.begin(), leader.end(), 0U);
  const auto find = [&](std::uint32_t v) {
    while (leader[v] != v) v = leader[v] = leader[leader[v]];
    return v;
  };
  for (const auto& face : sheet.faces) {
    for (std::size_t k = 1; k < 3; ++k) leader[find(face[k])] = find(face[0]);
  }
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  Parts parts;
  std::vector<std::uint32_t> number(sheet.places.size(), kNone);
  for (const PieceLine& line : piece.lines) {
    SideChain sides = line.sides;
    if (line.use.way == LineUse::Way::kBackward) std::reverse(sides.begin(), sides.end());
    for (const auto& side : sides) {
      std::uint32_t& part = number[find(side[0])];
      if (part == kNone) part = parts.count++;
    }
  }
  for (std::uint32_t v = 0; v < sheet.places.size(); ++v) parts.of_vertex.push_back(number[find(v)]);
  return parts;
}

/// One part of a piece.
class Extractor {
 public:
  Extractor(const BodyPiece& whole, const Parts& parts, std::uint32_t part)
      : whole_(whole), parts_(parts), part_(part), renumbered_(whole.sheet.places.size(), 0) {}

  BodyPiece Extract(double element_mm) {
    BodyPiece made;
    const std::string suffix = "." + std::to_string(part_ + 1);
    made.id = whole_.id + suffix;
    made.label = whole_.label.empty() ? "" : whole_.label + suffix;
    for (std::uint32_t v = 0; v < renumbered_.size(); ++v) {
      if (!Has(v)) continue;
      renumbered_[v] = static_cast<std::uint32_t>(made.sheet.places.size());
      made.sheet.places.push_back(whole_.sheet.places[v]);
      made.theta_z.push_back(whole_.theta_z[v]);
    }
    for (std::size_t f = 0; f < whole_.sheet.faces.size(); ++f) {
      const auto& face = whole_.sheet.faces[f];
      if (!Has(face[0])) continue;
      made.sheet.faces.push_back({renumbered_[face[0]], renumbered_[face[1]], renumbered_[face[2]]});
      made.sheet.lengths.push_back(whole_.sheet.lengths[f]);
    }
    for (const PieceLine& line : whole_.lines) AddRuns(line, made.lines);
    for (PieceDart dart : whole_.darts) {
      if (!Has(dart.legs[0].front()[0])) continue;
      for (SideChain& leg : dart.legs) leg = Renumbered(leg);
      made.darts.push_back(std::move(dart));
    }
    for (PieceDivision division : whole_.divisions) {
      if (!Has(division.sides.front()[0])) continue;
      division.sides = Renumbered(division.sides);
      made.divisions.push_back(std::move(division));
    }
    made.grain = Grain(made, element_mm);
    return made;
  }

 private:
  [[nodiscard]] bool Has(std::uint32_t vertex) const { return parts_.of_vertex[vertex] == part_; }

  [[nodiscard]] SideChain Renumbered(SideChain sides) const {
    for (auto& side : sides) side = {renumbered_[side[0]], renumbered_[side[1]]};
    return sides;
  }

  /// The stretches of a line that belong to this part.
  void AddRuns(const PieceLine& line, std::vector<PieceLine>& lines) const {
    for (std::size_t k = 0; k < line.sides.size(); ++k) {
      if (!Has(line.sides[k][0])) continue;
      std::size_t end = k + 1;
      while (end < line.sides.size() && Has(line.sides[end][0])) ++end;
      const auto at = [](std::size_t n) { return static_cast<std::ptrdiff_t>(n); };
      const SideChain run(line.sides.begin() + at(k), line.sides.begin() + at(end));
      lines.push_back({line.use,
                       line.first + k,
                       {line.shares.begin() + at(k), line.shares.begin() + at(end) + 1},
                       Renumbered(run)});
      k = end;
    }
  }

  /// The whole piece's grain line if it lies here; else, of the vertices about a quarter and three quarters up, the two
  /// between which it runs most nearly in the same direction.
  [[nodiscard]] std::array<std::uint32_t, 2> Grain(const BodyPiece& made, double element_mm) const {
    if (Has(whole_.grain[0]) && Has(whole_.grain[1])) {
      return {renumbered_[whole_.grain[0]], renumbered_[whole_.grain[1]]};
    }
    const double radius = whole_.sheet.places[whole_.grain[0]].head<2>().norm();
    const auto flat = [&](const Vector2d& place) { return Vector2d(radius * place.x(), place.y()); };
    const Vector2d up = (flat(whole_.theta_z[whole_.grain[1]]) - flat(whole_.theta_z[whole_.grain[0]])).normalized();
    const Vector2d side(up.y(), -up.x());
    std::vector<double> height;
    for (const Vector2d& place : made.theta_z) height.push_back(up.dot(flat(place)));
    const auto [low, high] = std::minmax_element(height.begin(), height.end());
    const double span = *high - *low;
    std::array<std::vector<std::uint32_t>, 2> near;
    for (std::uint32_t v = 0; v < height.size(); ++v) {
      for (std::size_t k = 0; k < 2; ++k) {
        const double wanted = *low + (k == 0 ? 0.25 : 0.75) * span;
        if (std::abs(height[v] - wanted) <= std::max(element_mm, 0.1 * span)) near[k].push_back(v);
      }
    }
    std::array<std::uint32_t, 2> best{static_cast<std::uint32_t>(low - height.begin()),
                                      static_cast<std::uint32_t>(high - height.begin())};
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t a : near[0]) {
      for (const std::uint32_t b : near[1]) {
        const double rise = height[b] - height[a];
        const double lean = std::abs(side.dot(flat(made.theta_z[b]) - flat(made.theta_z[a]))) / rise;
        if (!(rise > 0.2 * span && lean < least)) continue;
        least = lean;
        best = {a, b};
      }
    }
    return best;
  }

  const BodyPiece& whole_;
  const Parts& parts_;
  std::uint32_t part_;
  std::vector<std::uint32_t> renumbered_;
};

}  // namespace

std::vector<BodyPiece> PartsOf(BodyPiece piece, double element_mm) {
  std::vector<BodyPiece> made;
  if (piece.divisions.empty()) {
    made.push_back(std::move(piece));
    return made;
  }
  const Parts parts = FindParts(piece);
  for (std::uint32_t part = 0; part < parts.count; ++part) {
    made.push_back(Extractor(piece, parts, part).Extract(element_mm));
  }
  return made;
}

}  // namespace annulus
