#include "fitting/spline_transfer.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "base/ensure.h"

namespace annulus {
namespace {

using Eigen::Index;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double kMostProducts = 1e8;  ///< A precision takes a second and some 100 MB then.

/// Shares of a cell at which a polynomial is read: Chebyshev's, well within.
constexpr std::array<double, 4> kAt{0.0380602337443566, 0.3086582838174551, 0.6913417161825449, 0.9619397662556434};

/// Level of a function, and its number there.
using Function = std::pair<std::uint8_t, std::size_t>;

/// An active coefficient as the local one of a leaf.
struct Reading {
  std::size_t leaf = 0;
  std::uint16_t local = 0;
  bool found = false;
};

Function FunctionOf(const HierarchicalSpline& spline, const Reading& reading) {
  const SplineLeaf& leaf = spline.leaves()[reading.leaf];
  const SplineLevel& level = spline.levels()[leaf.level];
  const double theta = (leaf.theta_cell + 0.5) * level.theta.spacing();
  const std::size_t around = level.theta.InInterval(leaf.theta_cell, theta).index[reading.local % 4];
  const std::size_t up = level.z.InInterval(leaf.z_cell, level.z.breakpoints()[leaf.z_cell]).index[reading.local / 4];
  return {leaf.level, up * level.theta_cells() + around};
}

/// Of each active coefficient a leaf on which a local one is just it. There is one: a function of a level acts on a
/// cell of that level.
std::vector<Reading> ReadingsOf(const HierarchicalSpline& spline) {
  std::vector<Reading> readings(spline.size());
  for (std::size_t n = 0; n < spline.leaves().size(); ++n) {
    const SplineLeaf& leaf = spline.leaves()[n];
    const auto active = spline.Active(leaf);
    const auto read = [&](std::size_t local, std::size_t which) {
      Reading& reading = readings[active[which]];
      if (!reading.found) reading = {n, static_cast<std::uint16_t>(local), true};
    };
    if (leaf.plain) {
      for (std::size_t k = 0; k < 16; ++k) read(k, k);
      continue;
    }
    std::array<int, 16> parts{};
    for (const ExtractionEntry& e : spline.Extraction(leaf)) ++parts[e.local];
    for (const ExtractionEntry& e : spline.Extraction(leaf)) {
      if (parts[e.local] == 1 && e.weight == 1.0) read(e.local, e.active);
    }
  }
  return readings;
}

/// Weights of the values at kAt of an interval with which they give the k-th coefficient.
std::array<double, 4> ReadingWeights(const IntervalCubics& cubics, std::size_t k) {
  Eigen::Matrix4d values;
  for (std::size_t p = 0; p < 4; ++p) {
    const std::array<double, 4> at = ValuesAt(cubics, kAt[p]);
    for (std::size_t n = 0; n < 4; ++n) values(static_cast<Index>(p), static_cast<Index>(n)) = at[n];
  }
  const Eigen::Matrix4d inverse = values.inverse();
  std::array<double, 4> weights{};
  for (std::size_t p = 0; p < 4; ++p) weights[p] = inverse(static_cast<Index>(k), static_cast<Index>(p));
  return weights;
}

/// Zeros where two functions act at one place: entries that SurfaceCovariance::LocalVariance wants to be there.
Sparse NeighboursOf(const HierarchicalSpline& spline) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const SplineLeaf& leaf : spline.leaves()) {
    for (const std::uint32_t a : spline.Active(leaf)) {
      for (const std::uint32_t b : spline.Active(leaf)) {
        entries.emplace_back(static_cast<int>(a), static_cast<int>(b), 0.0);
      }
    }
  }
  Sparse zeros(static_cast<Index>(spline.size()), static_cast<Index>(spline.size()));
  zeros.setFromTriplets(entries.begin(), entries.end());
  return zeros;
}

/// Products of entries in rowsᵀ · middle · rows.
double ProductsOf(const Sparse& rows, const Sparse& middle) {
  std::vector<double> entries(static_cast<std::size_t>(rows.rows()), 0.0);
  for (Index column = 0; column < rows.outerSize(); ++column) {
    for (Sparse::InnerIterator entry(rows, column); entry; ++entry) ++entries[static_cast<std::size_t>(entry.row())];
  }
  double products = 0.0;
  for (Index column = 0; column < middle.outerSize(); ++column) {
    for (Sparse::InnerIterator entry(middle, column); entry; ++entry) {
      products += entries[static_cast<std::size_t>(entry.row())] * entries[static_cast<std::size_t>(column)];
    }
  }
  return products;
}

}  // namespace

Sparse CoefficientTransfer(const HierarchicalSpline& from, const HierarchicalSpline& to) {
  const std::vector<Reading> readings = ReadingsOf(to);
  std::map<Function, std::size_t> known;
  for (const Reading& reading : ReadingsOf(from)) known.emplace(FunctionOf(from, reading), known.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t row = 0; row < readings.size(); ++row) {
    ENSURE(readings[row].found, "every active coefficient is a local one of some leaf");
    if (const auto same = known.find(FunctionOf(to, readings[row])); same != known.end()) {
      entries.emplace_back(static_cast<int>(row), static_cast<int>(same->second), 1.0);
      continue;
    }
    const SplineLeaf& leaf = to.leaves()[readings[row].leaf];
    const SplineLevel& level = to.levels()[leaf.level];
    const double z = level.z.breakpoints()[leaf.z_cell];
    const double height = level.z.breakpoints()[leaf.z_cell + 1] - z;
    const auto around = ReadingWeights(PeriodicCubicBasis::Cubics(), readings[row].local % 4);
    const auto up = ReadingWeights(level.z.Cubics(leaf.z_cell), readings[row].local / 4);
    for (std::size_t n = 0; n < 16; ++n) {
      const double weight = around[n % 4] * up[n / 4];
      const double theta = (leaf.theta_cell + kAt[n % 4]) * level.theta.spacing();
      for (const CoefficientWeight& entry : from.ActiveRow(theta, z + kAt[n / 4] * height)) {
        entries.emplace_back(static_cast<int>(row), static_cast<int>(entry.index), weight * entry.weight);
      }
    }
  }
  Sparse transfer(static_cast<Index>(to.size()), static_cast<Index>(from.size()));
  transfer.setFromTriplets(entries.begin(), entries.end());
  transfer.prune([](Index, Index, double value) { return std::abs(value) > 1e-11; });
  return transfer;
}

ControlledSurface ControlledBy(const SurfaceSegment& segment) {
  if (segment.hierarchy != nullptr) return {segment.hierarchy, segment.active};
  auto spline = std::make_shared<const HierarchicalSpline>(segment.surface.theta_basis().count(),
                                                           segment.surface.z_basis().breakpoints(), RefinementFlags{});
  return {std::move(spline), segment.surface.coefficients()};
}

SurfaceSegment Refined(const SurfaceSegment& segment, std::shared_ptr<const HierarchicalSpline> finer) {
  const ControlledSurface old = ControlledBy(segment);
  SurfaceSegment refined = segment;
  refined.active = CoefficientTransfer(*old.spline, *finer) * old.active;
  refined.surface = finer->Surface(refined.active);
  refined.paper = nullptr;
  refined.normal_matrix.resize(0, 0);
  refined.hierarchy = std::move(finer);
  return refined;
}

Sparse RefinedPrecision(const Sparse& upper, const HierarchicalSpline& coarser, const HierarchicalSpline& finer) {
  const Sparse undo = CoefficientTransfer(finer, coarser);
  const Sparse precision = upper.selfadjointView<Eigen::Upper>();
  if (ProductsOf(undo, precision) > kMostProducts) return {};
  const Sparse refine = CoefficientTransfer(coarser, finer);
  Sparse identity(refine.rows(), refine.rows());
  identity.setIdentity();
  const Sparse apart = identity - Sparse(refine * undo);
  const double held = 1e5 * Eigen::VectorXd(precision.diagonal()).maxCoeff();
  const Sparse lifted = Sparse(undo.transpose() * precision * undo) + held * Sparse(apart.transpose() * apart);
  return Sparse((lifted + NeighboursOf(finer)).triangularView<Eigen::Upper>());
}

}  // namespace annulus
