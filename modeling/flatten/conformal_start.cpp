#include "modeling/flatten/conformal_start.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cmath>
#include <numbers>

namespace annulus {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Factor = Eigen::SimplicialLDLT<Sparse>;
using Triplets = std::vector<Eigen::Triplet<double>>;

constexpr int kHeld = -1;

/// Unknowns of a linear system of which some are given.
class PartlyGiven {
 public:
  explicit PartlyGiven(std::size_t count) : given_(count, false), value_(Eigen::VectorXd::Zero(Index(count))) {}

  void Give(std::size_t unknown, double value) {
    given_[unknown] = true;
    value_[Index(unknown)] = value;
  }
  /// Adds `entry` at (row, column) of the symmetric matrix; both triangles are to be added.
  void Add(std::size_t row, std::size_t column, double entry) {
    entries_.emplace_back(static_cast<int>(row), static_cast<int>(column), entry);
  }
  /// Solves for what is not given, right side 0.
  [[nodiscard]] Eigen::VectorXd Solve() const {
    std::vector<int> place(given_.size(), kHeld);
    int free = 0;
    for (std::size_t k = 0; k < given_.size(); ++k) {
      if (!given_[k]) place[k] = free++;
    }
    Triplets matrix;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(free);
    for (const auto& entry : entries_) {
      const int row = place[static_cast<std::size_t>(entry.row())];
      const int column = place[static_cast<std::size_t>(entry.col())];
      if (row == kHeld) continue;
      if (column == kHeld) {
        right[row] -= entry.value() * value_[entry.col()];
      } else if (row >= column) {
        matrix.emplace_back(row, column, entry.value());
      }
    }
    Sparse sparse(free, free);
    sparse.setFromTriplets(matrix.begin(), matrix.end());
    const Eigen::VectorXd solved = Factor(sparse).solve(right);
    Eigen::VectorXd all = value_;
    for (std::size_t k = 0; k < given_.size(); ++k) {
      if (place[k] != kHeld) all[Index(k)] = solved[place[k]];
    }
    return all;
  }

 private:
  static Eigen::Index Index(std::size_t k) { return static_cast<Eigen::Index>(k); }

  std::vector<bool> given_;
  Eigen::VectorXd value_;
  Triplets entries_;
};

double FlatArea(const std::array<std::uint32_t, 3>& face, const std::vector<Eigen::Vector2d>& flat) {
  const Eigen::Vector2d u = flat[face[1]] - flat[face[0]];
  const Eigen::Vector2d v = flat[face[2]] - flat[face[0]];
  return 0.5 * (u.x() * v.y() - u.y() * v.x());
}

/// Scales each part about its first grain vertex to the area that it has on the body.
void ScaleToArea(const CurvedSheet& sheet, const SheetTopology& topology, std::vector<Eigen::Vector2d>& flat) {
  std::vector<double> own(topology.parts, 0.0);
  std::vector<double> drawn(topology.parts, 0.0);
  for (std::size_t f = 0; f < sheet.faces.size(); ++f) {
    const std::uint32_t part = topology.part_of_vertex[sheet.faces[f][0]];
    own[part] += LayTriangle(sheet.lengths[f]).Area();
    drawn[part] += FlatArea(sheet.faces[f], flat);
  }
  for (std::size_t v = 0; v < flat.size(); ++v) {
    const std::uint32_t part = topology.part_of_vertex[v];
    if (drawn[part] > 0.0) flat[v] *= std::sqrt(own[part] / drawn[part]);
  }
}

std::vector<Eigen::Vector2d> PointsOf(const Eigen::VectorXd& all) {
  std::vector<Eigen::Vector2d> points(static_cast<std::size_t>(all.size() / 2));
  for (std::size_t v = 0; v < points.size(); ++v) points[v] = all.segment<2>(static_cast<Eigen::Index>(2 * v));
  return points;
}

/// Two rim vertices of each part with half of the rim between them.
std::vector<GrainPair> OppositeRimVertices(const SheetTopology& topology) {
  std::vector<GrainPair> pairs;
  for (const auto& rim : topology.rims) pairs.push_back({rim.front(), rim[rim.size() / 2]});
  return pairs;
}

}  // namespace

std::vector<FlatElement> ElementsOf(const CurvedSheet& sheet) {
  std::vector<FlatElement> elements;
  elements.reserve(sheet.faces.size());
  for (const auto& lengths : sheet.lengths) elements.emplace_back(LayTriangle(lengths));
  return elements;
}

std::vector<Eigen::Vector2d> ConformalMap(const CurvedSheet& sheet, const SheetTopology& topology,
                                          const std::vector<GrainPair>& grain) {
  // Conformal energy = Dirichlet's less the area: ½ xᵀLx + ½ yᵀLy − A(x, y), zero for similarities only.
  PartlyGiven system(2 * sheet.places.size());
  for (std::size_t f = 0; f < sheet.faces.size(); ++f) {
    const auto& face = sheet.faces[f];
    const FlatElement element(LayTriangle(sheet.lengths[f]));
    const Eigen::Matrix3d dirichlet = element.area() * element.slopes().transpose() * element.slopes();
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t l = 0; l < 3; ++l) {
        const double entry = dirichlet(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l));
        system.Add(2 * face[k], 2 * face[l], entry);
        system.Add(2 * face[k] + 1, 2 * face[l] + 1, entry);
      }
      const std::uint32_t next = face[(k + 1) % 3];  // ½ (x_k y_next − x_next y_k)
      system.Add(2 * face[k], 2 * next + 1, -0.5);
      system.Add(2 * next + 1, 2 * face[k], -0.5);
      system.Add(2 * next, 2 * face[k] + 1, 0.5);
      system.Add(2 * face[k] + 1, 2 * next, 0.5);
    }
  }
  for (const GrainPair& pair : OppositeRimVertices(topology)) {
    system.Give(2 * pair[0], 0.0);
    system.Give(2 * pair[0] + 1, 0.0);
    system.Give(2 * pair[1], 0.0);
    system.Give(2 * pair[1] + 1, 1.0);
  }
  std::vector<Eigen::Vector2d> flat = PointsOf(system.Solve());
  ScaleToArea(sheet, topology, flat);
  TurnUpright(topology, grain, flat);
  return flat;
}

std::vector<Eigen::Vector2d> TutteMap(const CurvedSheet& sheet, const SheetTopology& topology,
                                      const std::vector<GrainPair>& grain) {
  PartlyGiven system(2 * sheet.places.size());
  for (const auto& edge : topology.edges) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const std::size_t a = 2 * edge[0] + axis;
      const std::size_t b = 2 * edge[1] + axis;
      system.Add(a, a, 1.0);
      system.Add(b, b, 1.0);
      system.Add(a, b, -1.0);
      system.Add(b, a, -1.0);
    }
  }
  for (const auto& rim : topology.rims) {
    for (std::size_t k = 0; k < rim.size(); ++k) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(rim.size());
      system.Give(2 * rim[k], std::cos(angle));
      system.Give(2 * rim[k] + 1, std::sin(angle));
    }
  }
  std::vector<Eigen::Vector2d> flat = PointsOf(system.Solve());
  ScaleToArea(sheet, topology, flat);
  TurnUpright(topology, grain, flat);
  return flat;
}

void TurnUpright(const SheetTopology& topology, const std::vector<GrainPair>& grain,
                 std::vector<Eigen::Vector2d>& flat) {
  std::vector<Eigen::Vector2d> up(topology.parts, Eigen::Vector2d::UnitY());
  std::vector<Eigen::Vector2d> origin(topology.parts, Eigen::Vector2d::Zero());
  for (const GrainPair& pair : grain) {
    const std::uint32_t part = topology.part_of_vertex[pair[0]];
    const Eigen::Vector2d along = flat[pair[1]] - flat[pair[0]];
    if (along.norm() > 0.0) up[part] = along.normalized();
    origin[part] = flat[pair[0]];
  }
  for (std::size_t v = 0; v < flat.size(); ++v) {
    const std::uint32_t part = topology.part_of_vertex[v];
    const Eigen::Vector2d from = flat[v] - origin[part];
    flat[v] = {up[part].y() * from.x() - up[part].x() * from.y(), up[part].dot(from)};
  }
}

std::size_t CountFlips(const CurvedSheet& sheet, const std::vector<Eigen::Vector2d>& flat) {
  std::size_t flips = 0;
  for (const auto& face : sheet.faces) {
    if (!(FlatArea(face, flat) > 0.0)) ++flips;
  }
  return flips;
}

}  // namespace annulus
