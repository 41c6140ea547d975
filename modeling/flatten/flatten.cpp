#include "modeling/flatten/flatten.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "modeling/flatten/flat_system.h"

namespace annulus {
namespace {

using Points = std::vector<Eigen::Vector2d>;
using Sparse = Eigen::SparseMatrix<double>;

constexpr int kLocalGlobalSteps = 3;
constexpr double kStepTolerance = 1e-9;  ///< Of the sheet's size.

double SizeOf(const Points& flat) {
  Eigen::Array2d low = flat.front();
  Eigen::Array2d high = flat.front();
  for (const Eigen::Vector2d& p : flat) {
    low = low.min(p.array());
    high = high.max(p.array());
  }
  return (high - low).matrix().norm();
}

double LargestMove(const Points& move) {
  double largest = 0.0;
  for (const Eigen::Vector2d& m : move) largest = std::max(largest, m.norm());
  return largest;
}

Points Moved(const Points& flat, const Points& move, double part) {
  Points moved(flat.size());
  for (std::size_t v = 0; v < flat.size(); ++v) moved[v] = flat[v] + part * move[v];
  return moved;
}

/// A grain pair for every part: those given, elsewhere the rim's vertex that is furthest from its first one, and the
/// one furthest from that.
std::vector<GrainPair> CompleteGrain(const CurvedSheet& sheet, const SheetTopology& topology,
                                     const std::vector<GrainPair>& given) {
  std::vector<GrainPair> grain = given;
  std::vector<bool> has(topology.parts, false);
  for (const GrainPair& pair : given) has[topology.part_of_vertex[pair[0]]] = true;
  for (const auto& rim : topology.rims) {
    if (has[topology.part_of_vertex[rim.front()]]) continue;
    const auto furthest = [&](std::uint32_t from) {
      return *std::max_element(rim.begin(), rim.end(), [&](std::uint32_t a, std::uint32_t b) {
        return (sheet.places[a] - sheet.places[from]).norm() < (sheet.places[b] - sheet.places[from]).norm();
      });
    };
    const std::uint32_t one = furthest(rim.front());
    const std::uint32_t other = furthest(one);
    const bool upwards = sheet.places[one].z() <= sheet.places[other].z();
    grain.push_back(upwards ? GrainPair{one, other} : GrainPair{other, one});
  }
  return grain;
}

/// A few steps towards the map whose triangles are nearest to turned ones: turn each triangle (local), then solve
/// Poisson's equation for the points (global). Takes the large differences of area out of a conformal map.
Points LocalGlobal(const CurvedSheet& sheet, const FlatSystem& system, const std::vector<GrainPair>& grain,
                   Points flat) {
  std::vector<bool> held(flat.size(), false);
  for (const GrainPair& pair : grain) held[pair[0]] = true;
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t f = 0; f < sheet.faces.size(); ++f) {
    const FlatElement& element = system.elements()[f];
    const Eigen::Matrix3d dirichlet = element.area() * element.slopes().transpose() * element.slopes();
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t l = 0; l < 3; ++l) {
        const auto row = static_cast<int>(sheet.faces[f][k]);
        const auto column = static_cast<int>(sheet.faces[f][l]);
        if (row < column || held[sheet.faces[f][k]] || held[sheet.faces[f][l]]) continue;
        entries.emplace_back(row, column, dirichlet(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)));
      }
    }
  }
  for (std::size_t v = 0; v < held.size(); ++v) {
    if (held[v]) entries.emplace_back(static_cast<int>(v), static_cast<int>(v), 1.0);  // stays at the origin
  }
  Sparse matrix(static_cast<int>(flat.size()), static_cast<int>(flat.size()));
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Sparse> factor(matrix);
  for (int step = 0; step < kLocalGlobalSteps; ++step) {
    Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(matrix.rows(), 2);
    for (std::size_t f = 0; f < sheet.faces.size(); ++f) {
      const FlatElement& element = system.elements()[f];
      FlatElement::Corners corners;
      for (std::size_t k = 0; k < 3; ++k) corners.col(static_cast<Eigen::Index>(k)) = flat[sheet.faces[f][k]];
      const Eigen::Matrix2d gradient = element.Gradient(corners);
      const double a = gradient(0, 0) + gradient(1, 1);
      const double b = gradient(1, 0) - gradient(0, 1);
      const double length = std::max(std::hypot(a, b), 1e-300);
      Eigen::Matrix2d turn;
      turn << a / length, -b / length, b / length, a / length;
      const Eigen::Matrix<double, 2, 3> pull = element.area() * turn * element.slopes();
      for (std::size_t k = 0; k < 3; ++k) {
        if (!held[sheet.faces[f][k]])
          right.row(sheet.faces[f][k]) += pull.col(static_cast<Eigen::Index>(k)).transpose();
      }
    }
    const Eigen::MatrixX2d solved = factor.solve(right);
    for (std::size_t v = 0; v < flat.size(); ++v) flat[v] = solved.row(static_cast<Eigen::Index>(v)).transpose();
  }
  return flat;
}

Status CheckOptions(const CurvedSheet& sheet, const SheetTopology& topology, const FlattenOptions& options) {
  RETURN_IF_ERROR(CheckMaterial(options.material));
  const std::size_t count = sheet.places.size();
  const auto there = [count](std::uint32_t a, std::uint32_t b) { return a < count && b < count && a != b; };
  bool good = options.most_steps >= 1 && options.seam_tolerance_mm > 0.0;
  std::vector<int> grains(topology.parts, 0);
  for (const GrainPair& pair : options.grain) {
    good = good && there(pair[0], pair[1]) && topology.part_of_vertex[pair[0]] == topology.part_of_vertex[pair[1]];
    good = good && ++grains[topology.part_of_vertex[pair[0]]] == 1;
  }
  for (const SewnEdge& seam : options.sewn) {
    good = good && there(seam.one[0], seam.one[1]) && there(seam.other[0], seam.other[1]);
  }
  if (good) return {};
  return Fail("lay the sheet flat", "a grain line or seam names vertices that are not there or of two parts",
              "give one grain line per part, and sides of triangles as seams");
}

/// Newton's method; the multipliers of the seams are moved whenever the steps have become small.
void Relax(FlatSystem& system, const FlattenOptions& options, FlatShape& shape) {
  const double size = SizeOf(shape.points);
  for (; shape.steps < options.most_steps && !shape.converged; ++shape.steps) {
    const auto step = system.Newton(shape.points);
    if (!step) return;
    const double largest = LargestMove(step->move);
    double part = system.LargestPart(shape.points, step->move);
    const double before = system.Total(shape.points);
    Points next = Moved(shape.points, step->move, part);
    // Below this the energy's own rounding decides, not the step.
    while (largest > 1e-6 * size && part > 1e-12 && !(system.Total(next) <= before + 1e-4 * part * step->slope)) {
      part *= 0.5;
      next = Moved(shape.points, step->move, part);
    }
    shape.points = std::move(next);
    const bool small = part == 1.0 && largest <= (options.sewn.empty() ? kStepTolerance : 1e-5) * size;
    if (!small) continue;
    const bool sewn = system.SeamGap(shape.points) <= options.seam_tolerance_mm;
    shape.converged = sewn && largest <= kStepTolerance * size;
    if (!sewn) system.UpdateMultipliers(shape.points);
  }
}

/// Where two segments properly cross.
bool Crosses(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
  const auto side = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q, const Eigen::Vector2d& r) {
    return (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
  };
  return side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0;
}

}  // namespace

Result<FlatShape> Flatten(const CurvedSheet& sheet, const FlattenOptions& options) {
  auto topology = CheckSheet(sheet);
  if (!topology) return Fail(topology);
  RETURN_IF_ERROR(CheckOptions(sheet, *topology, options));
  const std::vector<GrainPair> grain = CompleteGrain(sheet, *topology, options.grain);
  FlatSystem system(sheet, options, grain);
  FlatShape shape;
  shape.points = ConformalMap(sheet, *topology, grain);
  if (CountFlips(sheet, shape.points) > 0) {
    shape.points = TutteMap(sheet, *topology, grain);
    shape.from_tutte = true;
  }
  shape.start_energy = system.Elastic(shape.points);
  Points nearer = LocalGlobal(sheet, system, grain, shape.points);
  TurnUpright(*topology, grain, nearer);
  if (CountFlips(sheet, nearer) == 0 && system.Elastic(nearer) < shape.start_energy) shape.points = std::move(nearer);
  Relax(system, options, shape);

  shape.energy = system.Elastic(shape.points);
  shape.seam_gap_mm = system.SeamGap(shape.points);
  shape.strains.reserve(sheet.faces.size());
  for (std::size_t f = 0; f < sheet.faces.size(); ++f) {
    FlatElement::Corners corners;
    for (std::size_t k = 0; k < 3; ++k) corners.col(static_cast<Eigen::Index>(k)) = shape.points[sheet.faces[f][k]];
    shape.strains.push_back(LinearStrain(system.elements()[f].Gradient(corners)));
  }
  shape.rim_crossings = CountRimCrossings(topology->rims, shape.points);
  shape.topology = std::move(*topology);
  return shape;
}

std::size_t CountRimCrossings(const std::vector<std::vector<std::uint32_t>>& rims, const Points& flat) {
  std::size_t crossings = 0;
  for (const auto& rim : rims) {
    const std::size_t n = rim.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector2d& a = flat[rim[i]];
      const Eigen::Vector2d& b = flat[rim[(i + 1) % n]];
      const Eigen::Array2d low = a.array().min(b.array());
      const Eigen::Array2d high = a.array().max(b.array());
      for (std::size_t j = i + 2; j < n; ++j) {
        const Eigen::Vector2d& c = flat[rim[j]];
        const Eigen::Vector2d& d = flat[rim[(j + 1) % n]];
        if ((c.array().max(d.array()) < low).any() || (c.array().min(d.array()) > high).any()) continue;
        if (Crosses(a, b, c, d)) ++crossings;
      }
    }
  }
  return crossings;
}

}  // namespace annulus
