#include "modeling/flatten/pattern_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "modeling/flatten/cut_outline.h"

namespace annulus {
namespace {

using Eigen::Vector2d;

constexpr double kGap = 20.0;         ///< Between pieces, mm.
constexpr double kLeastNotch = 5.0;   ///< mm
constexpr double kArrow = 6.0;        ///< mm
constexpr double kRowWidth = 1200.0;  ///< A row of pieces ends behind this, mm.

class Drawer {
 public:
  Drawer(const Pattern& pattern, const FlatPiece& piece) : pattern_(pattern), piece_(piece) {}

  DrawnPiece Draw() {
    DrawnPiece drawn;
    drawn.id = piece_.id;
    drawn.label = {piece_.label.empty() ? piece_.id : piece_.label, pattern_.name,
                   fmt::format("seam allowance {:g} mm", pattern_.allowance_mm)};
    drawn.cut = {CutLine(), DrawnChain::End::kClosed};
    for (const PieceLine& line : piece_.body.lines) {
      AddSewn(line.sides, drawn.sew);
      AddNotches(line, drawn.notches);
    }
    for (const PieceDart& dart : piece_.body.darts) {
      for (const SideChain& leg : dart.legs) AddSewn(leg, drawn.sew);
    }
    for (const PieceDivision& division : piece_.body.divisions) {
      AddSewn(division.sides, drawn.sew);
      AddDivisionNotch(division, drawn.notches);
    }
    if (piece_.body.lines.empty()) drawn.sew.push_back({RimPoints(), DrawnChain::End::kClosed});
    AddGrain(drawn.grain);
    drawn.label_at = Middle();
    Box(drawn);
    return drawn;
  }

 private:
  [[nodiscard]] double AllowanceOf(std::size_t line) const {
    if (line == PieceDart::kNoLine) return pattern_.allowance_mm;
    return pattern_.lines[line].allowance_mm.value_or(pattern_.allowance_mm);
  }

  [[nodiscard]] std::vector<Vector2d> RimPoints() const {
    std::vector<Vector2d> points;
    for (const std::uint32_t v : piece_.rim) points.push_back(piece_.points[v]);
    return points;
  }

  /// The outline without its darts, moved outwards.
  [[nodiscard]] std::vector<Vector2d> CutLine() const {
    std::map<std::uint32_t, double> allowance;  // by the vertex at which a rim side begins
    std::map<std::uint32_t, std::size_t> place;
    for (std::size_t k = 0; k < piece_.rim.size(); ++k) place[piece_.rim[k]] = k;
    for (const PieceLine& line : piece_.body.lines) {
      for (const auto& [from, to] : line.sides) {
        const bool along = (place[from] + 1) % piece_.rim.size() == place[to];
        allowance[along ? from : to] = AllowanceOf(line.use.line);
      }
    }
    std::map<std::uint32_t, double> mouths;
    std::vector<bool> dart(piece_.points.size(), false);
    for (const PieceDart& one : piece_.body.darts) {
      mouths[one.legs[0].front()[0]] = AllowanceOf(one.line);
      for (const SideChain& leg : one.legs) {
        for (const auto& [from, to] : leg) dart[to] = true;
      }
    }
    std::vector<Vector2d> outline;
    std::vector<double> distance;
    for (const std::uint32_t v : piece_.rim) {
      if (dart[v]) continue;
      const auto mouth = mouths.find(v);
      outline.push_back(piece_.points[v]);
      const auto own = allowance.find(v);
      distance.push_back(mouth != mouths.end()    ? mouth->second
                         : own != allowance.end() ? own->second
                                                  : pattern_.allowance_mm);
    }
    return OffsetOutline(outline, distance);
  }

  /// Chains of sides that follow each other; a dart's mouth interrupts them.
  void AddSewn(const SideChain& sides, std::vector<DrawnChain>& sew) const {
    std::uint32_t end = 0;
    for (std::size_t k = 0; k < sides.size(); ++k) {
      if (k == 0 || sides[k][0] != end) sew.push_back({{piece_.points[sides[k][0]]}, DrawnChain::End::kOpen});
      sew.back().points.push_back(piece_.points[sides[k][1]]);
      end = sides[k][1];
    }
  }

  /// The line's own notches, and one where a division of a neighbour ends.
  void AddNotches(const PieceLine& line, std::vector<DrawnStroke>& notches) const {
    std::vector<double> shares = pattern_.lines[line.use.line].notches;
    for (const PatternPiece& piece : pattern_.pieces) {
      for (const PatternDivision& division : piece.divisions) {
        for (const PatternDivision::End& end : division.ends) {
          if (end.line == line.use.line) shares.push_back(end.share);
        }
      }
    }
    const double margin = 2e-6;  // a notch at a corner is none
    for (const double share : shares) {
      if (!(share > line.shares.front() + margin && share < line.shares.back() - margin)) continue;
      const auto after = std::upper_bound(line.shares.begin(), line.shares.end(), share);
      const auto k = static_cast<std::size_t>(after - line.shares.begin()) - 1;
      const double part = (share - line.shares[k]) / (line.shares[k + 1] - line.shares[k]);
      AddNotch(line.sides[k], part, AllowanceOf(line.use.line), notches);
    }
  }

  /// At a third of its steps, the same on both sides; not the middle, so that no side is sewn the wrong way round.
  void AddDivisionNotch(const PieceDivision& division, std::vector<DrawnStroke>& notches) const {
    AddNotch(division.sides[division.sides.size() / 3], 0.0, pattern_.allowance_mm, notches);
  }

  /// At a part of a side, out to the cut line.
  void AddNotch(const std::array<std::uint32_t, 2>& side, double part, double allowance,
                std::vector<DrawnStroke>& notches) const {
    const Vector2d along = piece_.points[side[1]] - piece_.points[side[0]];
    const Vector2d at = piece_.points[side[0]] + part * along;
    Vector2d out(along.y(), -along.x());
    if (!RunsAlongRim(side[0], side[1])) out = -out;
    notches.push_back({at, at + std::max(allowance, kLeastNotch) * out.normalized()});
  }

  [[nodiscard]] bool RunsAlongRim(std::uint32_t from, std::uint32_t to) const {
    const auto at = std::find(piece_.rim.begin(), piece_.rim.end(), from);
    const auto next = at + 1 == piece_.rim.end() ? piece_.rim.begin() : at + 1;
    return *next == to;
  }

  void AddGrain(std::vector<DrawnStroke>& grain) const {
    const Vector2d from = piece_.points[piece_.body.grain[0]];
    const Vector2d to = piece_.points[piece_.body.grain[1]];
    grain.push_back({from, to});
    const Vector2d up = (to - from).normalized();
    const Vector2d side(up.y(), -up.x());
    for (const double sign : {-1.0, 1.0}) {
      grain.push_back({to, to - kArrow * up + 0.4 * sign * kArrow * side});
      grain.push_back({from, from + kArrow * up + 0.4 * sign * kArrow * side});
    }
  }

  [[nodiscard]] Vector2d Middle() const {
    Vector2d sum = Vector2d::Zero();
    for (const Vector2d& p : piece_.points) sum += p;
    return sum / static_cast<double>(piece_.points.size());
  }

  static void Box(DrawnPiece& drawn) {
    Eigen::Array2d low = drawn.cut.points.front();
    Eigen::Array2d high = low;
    for (const Vector2d& p : drawn.cut.points) {
      low = low.min(p.array());
      high = high.max(p.array());
    }
    drawn.low = low;
    drawn.high = high;
  }

  const Pattern& pattern_;
  const FlatPiece& piece_;
};

void Move(DrawnPiece& piece, const Vector2d& by) {
  for (Vector2d& p : piece.cut.points) p += by;
  for (DrawnChain& chain : piece.sew) {
    for (Vector2d& p : chain.points) p += by;
  }
  for (auto* strokes : {&piece.grain, &piece.notches}) {
    for (DrawnStroke& stroke : *strokes) {
      for (Vector2d& p : stroke) p += by;
    }
  }
  piece.label_at += by;
  piece.low += by;
  piece.high += by;
}

}  // namespace

std::vector<DrawnPiece> DrawPattern(const Pattern& pattern, const FlatPattern& flat) {
  std::vector<DrawnPiece> drawn;
  Vector2d corner = Vector2d::Zero();
  double top = 0.0;
  for (const FlatPiece& piece : flat.pieces) {
    DrawnPiece next = Drawer(pattern, piece).Draw();
    const Vector2d size = next.high - next.low;
    if (corner.x() > 0.0 && corner.x() + size.x() > kRowWidth) corner = {0.0, top + kGap};
    Move(next, corner - next.low);
    corner.x() += size.x() + kGap;
    top = std::max(top, next.high.y());
    drawn.push_back(std::move(next));
  }
  return drawn;
}

}  // namespace annulus
