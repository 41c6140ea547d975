#include "modeling/flatten/flat_pattern.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "modeling/flatten/flat_element.h"
#include "modeling/flatten/surface_region.h"

namespace annulus {
namespace {

/// Pieces side by side in one sheet; piece p's vertices begin at first[p].
struct Joined {
  CurvedSheet sheet;
  std::vector<std::uint32_t> first;
  FlattenOptions options;
};

Joined Join(const std::vector<BodyPiece>& pieces, const Pattern& pattern) {
  Joined joined;
  joined.options.material = pattern.material;
  for (const BodyPiece& piece : pieces) {
    const auto first = static_cast<std::uint32_t>(joined.sheet.places.size());
    joined.first.push_back(first);
    for (const auto& face : piece.sheet.faces)
      joined.sheet.faces.push_back({face[0] + first, face[1] + first, face[2] + first});
    joined.sheet.lengths.insert(joined.sheet.lengths.end(), piece.sheet.lengths.begin(), piece.sheet.lengths.end());
    joined.sheet.places.insert(joined.sheet.places.end(), piece.sheet.places.begin(), piece.sheet.places.end());
    joined.options.grain.push_back({piece.grain[0] + first, piece.grain[1] + first});
  }
  return joined;
}

/// One side of a seam.
struct SeamSide {
  std::size_t piece = 0;
  SideChain sides;
};

struct SeamPair {
  std::string name;
  double body_mm = 0.0;
  std::array<SeamSide, 2> sides;
};

/// A line's use by a piece or a part of one.
struct LineSide {
  std::size_t piece;
  const PieceLine* line;

  [[nodiscard]] std::size_t end() const { return line->first + line->sides.size(); }
};

/// The steps of a line that two uses share.
std::optional<SeamPair> SharedSteps(const LineSide& a, const LineSide& b, double line_mm) {
  const std::size_t first = std::max(a.line->first, b.line->first);
  const std::size_t end = std::min(a.end(), b.end());
  if (first >= end) return std::nullopt;
  SeamPair seam;
  const auto cut = [&](const LineSide& side) {
    const auto from = side.line->sides.begin() + static_cast<std::ptrdiff_t>(first - side.line->first);
    return SeamSide{side.piece, {from, from + static_cast<std::ptrdiff_t>(end - first)}};
  };
  seam.sides = {cut(a), cut(b)};
  const std::vector<double>& shares = a.line->shares;
  seam.body_mm = line_mm * (shares[end - a.line->first] - shares[first - a.line->first]);
  return seam;
}

/// Seams along lines: every step that two pieces share.
Status AddLineSeams(const std::vector<BodyPiece>& pieces, const Pattern& pattern, const std::vector<SampledLine>& lines,
                    std::vector<SeamPair>& seams) {
  for (std::size_t k = 0; k < lines.size(); ++k) {
    std::vector<LineSide> uses;
    std::vector<std::size_t> sides(lines[k].shares.size(), 0);
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      for (const PieceLine& line : pieces[p].lines) {
        if (line.use.line != k) continue;
        uses.push_back({p, &line});
        for (std::size_t step = 0; step < line.sides.size(); ++step) ++sides[line.first + step];
      }
    }
    const std::size_t most = *std::max_element(sides.begin(), sides.end());
    if (most > 2) {
      return Fail("sew the pattern", fmt::format("line '{}' has {} sides", pattern.lines[k].id, most),
                  "let two pieces meet in a line, or one with itself");
    }
    for (std::size_t a = 0; a < uses.size(); ++a) {
      for (std::size_t b = a + 1; b < uses.size(); ++b) {
        auto seam = SharedSteps(uses[a], uses[b], lines[k].length_mm);
        if (!seam) continue;
        seam->name = pattern.lines[k].id;
        seams.push_back(std::move(*seam));
      }
    }
  }
  return {};
}

double LengthOnBody(const BodyPiece& piece, const SideChain& sides) {
  double length = 0.0;
  for (const auto& [from, to] : sides) length += (piece.sheet.places[to] - piece.sheet.places[from]).norm();
  return length;
}

Result<std::vector<SeamPair>> FindSeams(const std::vector<BodyPiece>& pieces, const Pattern& pattern,
                                        const std::vector<SampledLine>& lines) {
  std::vector<SeamPair> seams;
  RETURN_IF_ERROR(AddLineSeams(pieces, pattern, lines, seams));
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    for (std::size_t d = 0; d < pieces[p].darts.size(); ++d) {
      const auto& legs = pieces[p].darts[d].legs;
      seams.push_back({fmt::format("{} dart {}", pieces[p].id, d + 1),
                       LengthOnBody(pieces[p], legs[1]),
                       {SeamSide{p, legs[0]}, SeamSide{p, legs[1]}}});
    }
  }
  for (std::size_t a = 0; a < pieces.size(); ++a) {
    for (const PieceDivision& one : pieces[a].divisions) {
      for (std::size_t b = a + 1; b < pieces.size(); ++b) {
        for (const PieceDivision& other : pieces[b].divisions) {
          if (one.piece != other.piece || one.number != other.number) continue;
          seams.push_back({fmt::format("{} division {}", pattern.pieces[one.piece].id, one.number + 1),
                           LengthOnBody(pieces[a], one.sides),
                           {SeamSide{a, one.sides}, SeamSide{b, other.sides}}});
        }
      }
    }
  }
  return seams;
}

FlatSeam Measured(const FlatPattern& flat, const SeamPair& pair) {
  FlatSeam seam{pair.name, {}, pair.body_mm, {}};
  for (std::size_t k = 0; k < 2; ++k) {
    seam.piece[k] = pair.sides[k].piece;
    const auto& points = flat.pieces[pair.sides[k].piece].points;
    for (const auto& [from, to] : pair.sides[k].sides) seam.flat_mm[k] += (points[to] - points[from]).norm();
  }
  return seam;
}

/// The sides of all seams in the numbers of the joined sheet.
std::vector<SewnEdge> SewnEdges(const std::vector<SeamPair>& seams, const std::vector<std::uint32_t>& first) {
  std::vector<SewnEdge> sewn;
  for (const SeamPair& seam : seams) {
    const std::uint32_t a = first[seam.sides[0].piece];
    const std::uint32_t b = first[seam.sides[1].piece];
    for (std::size_t k = 0; k < seam.sides[0].sides.size(); ++k) {
      const auto& one = seam.sides[0].sides[k];
      const auto& other = seam.sides[1].sides[k];
      sewn.push_back({{one[0] + a, one[1] + a}, {other[0] + b, other[1] + b}});
    }
  }
  return sewn;
}

/// The amount that is exceeded on 2 % of the area.
double Exceeded(std::vector<std::array<double, 2>> strain_and_area) {
  std::sort(strain_and_area.begin(), strain_and_area.end(), std::greater<>());
  double total = 0.0;
  for (const auto& [strain, area] : strain_and_area) total += area;
  double above = 0.0;
  for (const auto& [strain, area] : strain_and_area) {
    above += area;
    if (above > 0.02 * total) return strain;
  }
  return 0.0;
}

/// The piece with its numbers.
FlatPiece Judged(const Pattern& pattern, FlatPiece piece) {
  const Eigen::Matrix3d stiffness = Stiffness(pattern.material);
  std::vector<std::array<double, 2>> strains;
  for (std::size_t f = 0; f < piece.strains.size(); ++f) {
    const double area = LayTriangle(piece.body.sheet.lengths[f]).Area();
    const double strain = PrincipalStrains(piece.strains[f]).cwiseAbs().maxCoeff();
    piece.energy += 0.5 * area * piece.strains[f].dot(stiffness * piece.strains[f]);
    piece.body_area_mm2 += area;
    piece.largest_strain = std::max(piece.largest_strain, strain);
    strains.push_back({strain, area});
  }
  piece.strain_98 = Exceeded(std::move(strains));
  std::vector<Eigen::Vector2d> outline;
  for (const std::uint32_t v : piece.rim) outline.push_back(piece.points[v]);
  piece.flat_area_mm2 = 0.5 * TurnedArea(outline);
  return piece;
}

/// Takes the pieces apart again.
std::vector<FlatPiece> Part(const Pattern& pattern, std::vector<BodyPiece>& bodies, const Joined& joined,
                            const FlatShape& shape) {
  std::vector<FlatPiece> pieces;
  std::size_t face = 0;
  for (std::size_t p = 0; p < bodies.size(); ++p) {
    FlatPiece piece;
    piece.id = bodies[p].id;
    piece.label = bodies[p].label;
    const std::uint32_t first = joined.first[p];
    const std::size_t vertices = bodies[p].sheet.places.size();
    piece.points.assign(shape.points.begin() + first,
                        shape.points.begin() + first + static_cast<std::ptrdiff_t>(vertices));
    const std::size_t faces = bodies[p].sheet.faces.size();
    for (std::size_t k = 0; k < faces; ++k) piece.strains.push_back(shape.strains[face++]);
    for (const auto& rim : shape.topology.rims) {
      if (rim.front() < first || rim.front() >= first + vertices) continue;
      for (const std::uint32_t v : rim) piece.rim.push_back(v - first);
    }
    piece.body = std::move(bodies[p]);
    pieces.push_back(Judged(pattern, std::move(piece)));
  }
  return pieces;
}

Status CheckOverlaps(const FlatPattern& flat) {
  for (const FlatPiece& piece : flat.pieces) {
    if (CountRimCrossings({piece.rim}, piece.points) == 0) continue;
    return Fail("lay piece '" + piece.id + "' flat", "it would overlap itself",
                "cut it into two pieces by a seam, or move the dart that does not open");
  }
  return {};
}

}  // namespace

Result<FlatPattern> LayFlat(const Pattern& pattern, std::vector<BodyPiece> bodies,
                            const std::vector<SampledLine>& lines) {
  const auto seams = FindSeams(bodies, pattern, lines);
  if (!seams) return Fail(seams);
  Joined joined = Join(bodies, pattern);
  joined.options.sewn = SewnEdges(*seams, joined.first);
  const auto shape = Flatten(joined.sheet, joined.options);
  if (!shape) return Fail(shape);
  if (!shape->converged) {
    return Fail(
        "lay the pattern flat",
        fmt::format("no balance of forces after {} steps (seams differ by {:g} mm)", shape->steps, shape->seam_gap_mm),
        "cut strongly curved pieces by seams, or take smaller elements");
  }
  FlatPattern flat{pattern.name, Part(pattern, bodies, joined, *shape), {}, shape->energy, shape->steps};
  for (const SeamPair& seam : *seams) flat.seams.push_back(Measured(flat, seam));
  RETURN_IF_ERROR(CheckOverlaps(flat));
  return flat;
}

Result<FlatPattern> FlattenPattern(const Pattern& pattern, const PatternBody& body, const TaskContext& task) {
  const auto lines = SampleLines(pattern, body);
  if (!lines) return Fail(lines);
  std::vector<BodyPiece> bodies;
  for (std::size_t p = 0; p < pattern.pieces.size(); ++p) {
    if (task.stop.stop_requested()) return Fail("lay the pattern flat", "it was stopped", "start it again");
    task.Report("cut", static_cast<double>(p), static_cast<double>(pattern.pieces.size()));
    auto parts = CutPiece(pattern, p, *lines, body);
    if (!parts) return Fail(parts);
    for (BodyPiece& part : *parts) bodies.push_back(std::move(part));
  }
  task.Report("flatten", 0.0, 1.0);
  return LayFlat(pattern, std::move(bodies), *lines);
}

}  // namespace annulus
