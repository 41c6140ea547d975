#include "modeling/flatten/flat_pattern.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

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
  std::size_t piece;
  const SideChain* sides;
};

struct SeamPair {
  std::string name;
  double body_mm;
  SeamSide one, other;
};

Result<std::vector<SeamPair>> FindSeams(const std::vector<BodyPiece>& pieces, const Pattern& pattern,
                                        const std::vector<SampledLine>& lines) {
  std::vector<std::vector<SeamSide>> uses(pattern.lines.size());
  std::vector<SeamPair> seams;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    for (const PieceLine& line : pieces[p].lines) uses[line.use.line].push_back({p, &line.sides});
  }
  for (std::size_t k = 0; k < uses.size(); ++k) {
    if (uses[k].size() > 2) {
      return Fail("sew the pattern", fmt::format("line '{}' has {} sides", pattern.lines[k].id, uses[k].size()),
                  "let two pieces meet in a line, or one with itself");
    }
    if (uses[k].size() == 2) seams.push_back({pattern.lines[k].id, lines[k].length_mm, uses[k][0], uses[k][1]});
  }
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    for (std::size_t d = 0; d < pieces[p].darts.size(); ++d) {
      const auto& legs = pieces[p].darts[d].legs;
      double length = 0.0;
      for (const auto& [from, to] : legs[1])
        length += (pieces[p].sheet.places[to] - pieces[p].sheet.places[from]).norm();
      seams.push_back({fmt::format("{} dart {}", pattern.pieces[p].id, d + 1), length, {p, &legs[0]}, {p, &legs[1]}});
    }
  }
  return seams;
}

FlatSeam Measured(const FlatPattern& flat, const SeamPair& pair) {
  FlatSeam seam{pair.name, {}, pair.body_mm, {}};
  const std::array<SeamSide, 2> sides{pair.one, pair.other};
  for (std::size_t k = 0; k < 2; ++k) {
    seam.piece[k] = sides[k].piece;
    const auto& points = flat.pieces[sides[k].piece].points;
    for (const auto& [from, to] : *sides[k].sides) seam.flat_mm[k] += (points[to] - points[from]).norm();
  }
  return seam;
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
    piece.id = pattern.pieces[p].id;
    piece.label = pattern.pieces[p].label;
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

/// The grain line of a mesh.
std::array<std::uint32_t, 2> LowestAndHighest(const TriangleMesh& mesh) {
  std::array<std::uint32_t, 2> ends{};
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t v : face) {
      if (mesh.vertices[v].z() < mesh.vertices[ends[0]].z()) ends[0] = v;
      if (mesh.vertices[v].z() > mesh.vertices[ends[1]].z()) ends[1] = v;
    }
  }
  if (ends[0] == ends[1]) ends = {mesh.faces.front()[0], mesh.faces.front()[1]};
  return ends;
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

Result<FlatPattern> FlattenPattern(const Pattern& pattern, const PatternBody& body, const TaskContext& task) {
  const auto lines = SampleLines(pattern, body);
  if (!lines) return Fail(lines);
  std::vector<BodyPiece> bodies;
  for (std::size_t p = 0; p < pattern.pieces.size(); ++p) {
    if (task.stop.stop_requested()) return Fail("lay the pattern flat", "it was stopped", "start it again");
    task.Report("cut", static_cast<double>(p), static_cast<double>(pattern.pieces.size()));
    auto piece = CutPiece(pattern, p, *lines, body);
    if (!piece) return Fail(piece);
    bodies.push_back(std::move(*piece));
  }
  const auto seams = FindSeams(bodies, pattern, *lines);
  if (!seams) return Fail(seams);
  Joined joined = Join(bodies, pattern);
  for (const SeamPair& seam : *seams) {
    for (std::size_t k = 0; k < seam.one.sides->size(); ++k) {
      const auto& one = (*seam.one.sides)[k];
      const auto& other = (*seam.other.sides)[k];
      const std::uint32_t a = joined.first[seam.one.piece];
      const std::uint32_t b = joined.first[seam.other.piece];
      joined.options.sewn.push_back({{one[0] + a, one[1] + a}, {other[0] + b, other[1] + b}});
    }
  }
  task.Report("flatten", 0.0, 1.0);
  const auto shape = Flatten(joined.sheet, joined.options);
  if (!shape) return Fail(shape);
  if (!shape->converged) {
    return Fail(
        "lay the pattern flat",
        fmt::format("no balance of forces after {} steps (seams differ by {:g} mm)", shape->steps, shape->seam_gap_mm),
        "cut strongly curved pieces by seams, or take smaller elements");
  }
  std::vector<SeamPair> pairs = *seams;
  // The chains move with their pieces: keep them by value first.
  std::vector<std::array<SideChain, 2>> chains;
  for (const SeamPair& pair : pairs) chains.push_back({*pair.one.sides, *pair.other.sides});
  FlatPattern flat{pattern.name, Part(pattern, bodies, joined, *shape), {}, shape->energy, shape->steps};
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    pairs[k].one.sides = &chains[k][0];
    pairs[k].other.sides = &chains[k][1];
    flat.seams.push_back(Measured(flat, pairs[k]));
  }
  RETURN_IF_ERROR(CheckOverlaps(flat));
  return flat;
}

Result<FlatPattern> FlattenMesh(const TriangleMesh& mesh, const Pattern& pattern) {
  Pattern alone = pattern;
  alone.lines.clear();
  alone.pieces = {{"mesh", pattern.name, {}, {}, {}}};
  std::vector<BodyPiece> bodies(1);
  bodies.front().sheet = SheetOfMesh(mesh);
  for (const Eigen::Vector3d& p : mesh.vertices) bodies.front().theta_z.emplace_back(std::atan2(p.y(), p.x()), p.z());
  const auto topology = CheckSheet(bodies.front().sheet);
  if (!topology) return Fail(topology);
  bodies.front().grain = LowestAndHighest(mesh);
  const Joined joined = Join(bodies, alone);
  const auto shape = Flatten(joined.sheet, joined.options);
  if (!shape) return Fail(shape);
  FlatPattern flat{alone.name, Part(alone, bodies, joined, *shape), {}, shape->energy, shape->steps};
  RETURN_IF_ERROR(CheckOverlaps(flat));
  return flat;
}

}  // namespace annulus
