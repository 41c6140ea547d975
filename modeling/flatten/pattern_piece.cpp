#include "modeling/flatten/pattern_piece.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "modeling/flatten/geodesic_side.h"
#include "modeling/flatten/piece_parts.h"
#include "modeling/flatten/sheet_cut.h"
#include "modeling/flatten/surface_region.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Way = LineUse::Way;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kMeet = 1e-6;  ///< rad and mm

/// A piece's rim before triangles: its corners, and for each line the numbers of the corners along it.
struct Rim {
  std::vector<Vector2d> places;
  std::vector<std::vector<std::uint32_t>> corners;  ///< Per use, in the line's own direction.
};

class Cutter {
 public:
  Cutter(const Pattern& pattern, std::size_t piece, const std::vector<SampledLine>& lines, const PatternBody& body)
      : pattern_(pattern), number_(piece), piece_(pattern.pieces[piece]), lines_(lines), body_(body) {}

  Result<std::vector<BodyPiece>> Cut() {
    auto rim = MakeRim();
    if (!rim) return Fail(rim);
    RegionLines region;
    region.points = rim->places;
    region.rim_count = rim->places.size();
    for (const PatternDart& dart : piece_.darts) RETURN_IF_ERROR(AddDart(dart, *rim, region));
    for (const PatternDivision& division : piece_.divisions) RETURN_IF_ERROR(AddDivision(division, *rim, region));
    const auto grain = AddGrain(region);
    if (!grain) return Fail(grain);
    auto filled = FillRegion(body_.segment, region, pattern_.element_mm);
    if (!filled) return Within(filled.error());
    BodyPiece made;
    made.id = piece_.id;
    made.label = piece_.label;
    made.sheet = std::move(filled->sheet);
    made.theta_z = std::move(filled->theta_z);
    made.grain = *grain;
    CutDarts(region, made);
    CutDivisions(region, made);
    NameSides(*rim, made);
    return PartsOf(std::move(made), pattern_.element_mm);
  }

 private:
  [[nodiscard]] tl::unexpected<Error> Within(const Error& error) const {
    return Fail("piece '" + piece_.id + "': " + error.attempted, error.seen, error.advice);
  }
  [[nodiscard]] tl::unexpected<Error> Refuse(std::string seen, const char* advice) const {
    return Fail("cut piece '" + piece_.id + "'", std::move(seen), advice);
  }

  Result<Rim> MakeRim() const {
    Rim rim;
    for (const LineUse& use : piece_.outline) {
      std::vector<Vector2d> places = lines_[use.line].places;
      if (use.way == Way::kBackward) std::reverse(places.begin(), places.end());
      Vector2d shift = Vector2d::Zero();
      if (!rim.places.empty()) {
        const Vector2d gap = rim.places.back() - places.front();
        shift.x() = kTurn * std::round(gap.x() / kTurn);
        if (!((gap - shift).cwiseAbs().maxCoeff() < kMeet)) return NotMeeting(use);
        rim.places.pop_back();
      }
      std::vector<std::uint32_t> corners;
      for (const Vector2d& place : places) {
        corners.push_back(static_cast<std::uint32_t>(rim.places.size()));
        rim.places.push_back(place + shift);
      }
      if (use.way == Way::kBackward) std::reverse(corners.begin(), corners.end());
      rim.corners.push_back(std::move(corners));
    }
    if (rim.places.size() < 4) return Refuse("its outline has fewer than three sides", "give it more lines");
    const Vector2d gap = rim.places.back() - rim.places.front();
    if (std::abs(std::abs(gap.x()) - kTurn) < kMeet && std::abs(gap.y()) < kMeet) {
      return Refuse("its outline goes around the body and does not close",
                    "cut it open along a line that it uses twice");
    }
    if (!(gap.cwiseAbs().maxCoeff() < kMeet)) return NotMeeting(piece_.outline.front());
    rim.places.pop_back();
    const auto count = static_cast<std::uint32_t>(rim.places.size());
    const bool clockwise = TurnedArea(rim.places) < 0.0;
    if (clockwise) std::reverse(rim.places.begin(), rim.places.end());
    for (auto& corners : rim.corners) {
      for (std::uint32_t& corner : corners) corner = clockwise ? count - 1 - corner % count : corner % count;
    }
    return rim;
  }

  [[nodiscard]] tl::unexpected<Error> NotMeeting(const LineUse& use) const {
    return Refuse("line '" + pattern_.lines[use.line].id + "' does not begin where the line before it ends",
                  "list the outline's lines end to end; '-ID' runs a line backwards");
  }

  /// The rim's corner at a share of a line.
  [[nodiscard]] std::optional<std::uint32_t> CornerAt(std::size_t line, double share, const Rim& rim) const {
    const std::vector<double>& shares = lines_[line].shares;
    for (std::size_t k = 0; k < piece_.outline.size(); ++k) {
      if (piece_.outline[k].line != line) continue;
      for (std::size_t j = 1; j + 1 < shares.size(); ++j) {
        if (std::abs(shares[j] - share) < 2e-6) return rim.corners[k][j];
      }
    }
    return {};
  }

  /// The same, if no other cut has an end there.
  Result<std::uint32_t> Mouth(std::size_t line, double share, const Rim& rim, const RegionLines& region) const {
    const auto mouth = CornerAt(line, share, rim);
    if (!mouth) {
      return Refuse("a dart or division does not begin within a line of its outline",
                    "name a line of the piece and a share in (0, 1)");
    }
    const bool taken = std::any_of(region.chains.begin(), region.chains.end(), [&](const PlaneMesh::Chain& chain) {
      return chain.front() == *mouth || chain.back() == *mouth;
    });
    if (taken) return Refuse("two cuts begin at the same place", "let them begin apart");
    return *mouth;
  }

  /// Goes on with a chain, straight to `place` (nearest to where it is, around), in steps of an element, the last point
  /// excluded. Returns that.
  Vector2d Continue(PlaneMesh::Chain& chain, Vector2d place, RegionLines& region) const {
    const Vector2d from = region.points[chain.back()];
    place.x() += kTurn * std::round((from.x() - place.x()) / kTurn);
    const double length = StraightLength(body_.segment, from, place);
    const double count = std::clamp(std::ceil(length / pattern_.element_mm - 1e-9), 1.0, 1e4);
    for (double step = 1.0; step < count; step += 1.0) {
      chain.push_back(static_cast<std::uint32_t>(region.points.size()));
      region.points.emplace_back(from + step / count * (place - from));
    }
    return place;
  }

  /// The same, `place` included.
  void ContinueTo(PlaneMesh::Chain& chain, const Vector2d& place, RegionLines& region) const {
    const Vector2d end = Continue(chain, place, region);
    chain.push_back(static_cast<std::uint32_t>(region.points.size()));
    region.points.push_back(end);
  }

  Status AddDart(const PatternDart& dart, const Rim& rim, RegionLines& region) const {
    const auto mouth = Mouth(dart.line, dart.share, rim, region);
    if (!mouth) return Fail(mouth);
    const auto tip = PlaceOn(body_, dart.tip);
    if (!tip) return Fail(tip);
    PlaneMesh::Chain chain{*mouth};
    ContinueTo(chain, *tip, region);
    region.chains.push_back(std::move(chain));
    return {};
  }

  Status AddDivision(const PatternDivision& division, const Rim& rim, RegionLines& region) const {
    std::array<std::uint32_t, 2> mouths{};
    for (std::size_t k = 0; k < 2; ++k) {
      const auto mouth = Mouth(division.ends[k].line, division.ends[k].share, rim, region);
      if (!mouth) return Fail(mouth);
      mouths[k] = *mouth;
    }
    if (mouths[0] == mouths[1]) return Refuse("a division ends where it begins", "let its ends differ");
    PlaneMesh::Chain chain{mouths[0]};
    for (const PatternPlace& place : division.through) {
      const auto at = PlaceOn(body_, place);
      if (!at) return Fail(at);
      ContinueTo(chain, *at, region);
    }
    Continue(chain, rim.places[mouths[1]], region);
    chain.push_back(mouths[1]);
    region.chains.push_back(std::move(chain));
    return {};
  }

  /// The grain line's two places: corners of the region that lie there, or points of their own.
  Result<std::array<std::uint32_t, 2>> AddGrain(RegionLines& region) const {
    std::array<Vector2d, 2> ends;
    const auto middle = [&](double share) {
      double low = region.points.front().y(), high = low, sum = 0.0;
      for (std::size_t k = 0; k < region.rim_count; ++k) {
        low = std::min(low, region.points[k].y());
        high = std::max(high, region.points[k].y());
        sum += region.points[k].x() / static_cast<double>(region.rim_count);
      }
      return Vector2d(sum, low + share * (high - low));
    };
    for (std::size_t k = 0; k < 2; ++k) {
      if (!piece_.grain) {
        ends[k] = middle(k == 0 ? 0.25 : 0.75);
        continue;
      }
      const auto at = PlaceOn(body_, (*piece_.grain)[k]);
      if (!at) return Fail(at);
      ends[k] = *at;
      ends[k].x() += kTurn * std::round((middle(0.5).x() - at->x()) / kTurn);
    }
    std::array<std::uint32_t, 2> grain{};
    for (std::size_t k = 0; k < 2; ++k) grain[k] = Corner(ends[k], region);
    if (grain[0] == grain[1]) return Refuse("its grain line has no length", "give it two places further apart");
    return grain;
  }

  std::uint32_t Corner(const Vector2d& place, RegionLines& region) const {
    const double radius = std::max(body_.segment.surface.Radius(place.x(), place.y()), 1.0);
    const auto distance = [&](const Vector2d& p) {
      return std::hypot(radius * (p.x() - place.x()), p.y() - place.y());
    };
    const auto nearest = std::min_element(region.points.begin(), region.points.end(),
                                          [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
    if (distance(*nearest) >= 0.3 * pattern_.element_mm && IsInside(place, region)) {
      region.points.push_back(place);
      return static_cast<std::uint32_t>(region.points.size() - 1);
    }
    return static_cast<std::uint32_t>(nearest - region.points.begin());
  }

  static bool IsInside(const Vector2d& p, const RegionLines& region) {
    bool inside = false;
    for (std::size_t i = 0, j = region.rim_count - 1; i < region.rim_count; j = i++) {
      const Vector2d& a = region.points[i];
      const Vector2d& b = region.points[j];
      const bool straddles = (a.y() > p.y()) != (b.y() > p.y());
      if (straddles && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x()) inside = !inside;
    }
    return inside;
  }

  void CutDarts(const RegionLines& region, BodyPiece& made) const {
    for (std::size_t d = 0; d < piece_.darts.size(); ++d) {
      const PlaneMesh::Chain& chain = region.chains[d];
      const auto first = static_cast<std::uint32_t>(made.sheet.places.size());
      made.sheet = CutAlong(std::move(made.sheet), chain, SheetCutEnd::kTip);
      PieceDart dart{piece_.darts[d].line, piece_.darts[d].share, region.points[chain.back()], {}};
      for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
        made.theta_z.push_back(region.points[chain[k]]);
        const auto copy = static_cast<std::uint32_t>(first + k);
        dart.legs[0].push_back({copy, k + 2 < chain.size() ? copy + 1 : chain.back()});
        dart.legs[1].push_back({chain[k], chain[k + 1]});
      }
      made.darts.push_back(std::move(dart));
    }
  }

  void CutDivisions(const RegionLines& region, BodyPiece& made) const {
    for (std::size_t d = 0; d < piece_.divisions.size(); ++d) {
      const PlaneMesh::Chain& chain = region.chains[piece_.darts.size() + d];
      const auto first = static_cast<std::uint32_t>(made.sheet.places.size());
      made.sheet = CutAlong(std::move(made.sheet), chain, SheetCutEnd::kRim);
      std::array<PieceDivision, 2> sides{PieceDivision{number_, d, {}}, PieceDivision{number_, d, {}}};
      for (std::size_t k = 0; k < chain.size(); ++k) {
        made.theta_z.push_back(region.points[chain[k]]);
        if (k + 1 == chain.size()) break;
        const auto copy = static_cast<std::uint32_t>(first + k);
        sides[0].sides.push_back({copy, copy + 1});
        sides[1].sides.push_back({chain[k], chain[k + 1]});
      }
      for (PieceDivision& side : sides) made.divisions.push_back(std::move(side));
    }
  }

  /// Finds the rim's sides along each line. Where a cut begins, the side before it has got the copied vertex; where a
  /// division ends, the side after it.
  void NameSides(const Rim& rim, BodyPiece& made) const {
    const auto count = static_cast<std::uint32_t>(rim.places.size());
    using Copies = std::map<std::uint32_t, std::uint32_t>;
    Copies at_begin;
    Copies at_end;
    for (const PieceDart& dart : made.darts) at_begin[dart.legs[1].front()[0]] = dart.legs[0].front()[0];
    for (std::size_t d = 0; d + 1 < made.divisions.size(); d += 2) {
      const SideChain& copied = made.divisions[d].sides;
      const SideChain& kept = made.divisions[d + 1].sides;
      at_begin[kept.front()[0]] = copied.front()[0];
      at_end[kept.back()[1]] = copied.back()[1];
    }
    const auto of = [](const Copies& copies, std::uint32_t corner) {
      const auto copy = copies.find(corner);
      return copy == copies.end() ? corner : copy->second;
    };
    for (std::size_t k = 0; k < piece_.outline.size(); ++k) {
      PieceLine line{piece_.outline[k], 0, lines_[piece_.outline[k].line].shares, {}};
      const auto& corners = rim.corners[k];
      for (std::size_t j = 0; j + 1 < corners.size(); ++j) {
        const std::uint32_t from = corners[j];
        const std::uint32_t to = corners[j + 1];
        const bool along_rim = (from + 1) % count == to;
        line.sides.push_back(along_rim ? std::array{of(at_end, from), of(at_begin, to)}
                                       : std::array{of(at_begin, from), of(at_end, to)});
      }
      made.lines.push_back(std::move(line));
    }
  }

  const Pattern& pattern_;
  std::size_t number_;
  const PatternPiece& piece_;
  const std::vector<SampledLine>& lines_;
  const PatternBody& body_;
};

}  // namespace

Result<std::vector<BodyPiece>> CutPiece(const Pattern& pattern, std::size_t piece,
                                        const std::vector<SampledLine>& lines, const PatternBody& body) {
  return Cutter(pattern, piece, lines, body).Cut();
}

}  // namespace annulus
