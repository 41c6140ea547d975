#pragma once

#include <Eigen/SparseLU>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include "fitting/surface_model.h"

namespace annulus::test {

using RadiusFunction = std::function<double(double theta, double z)>;

/// Solves the square collocation system Σ_k N_k(x_i) c_k = y_i for many right-hand sides.
inline Eigen::MatrixXd Collocate(const std::vector<CubicBasis>& at, std::size_t count, const Eigen::MatrixXd& y) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t row = 0; row < at.size(); ++row) {
    for (std::size_t k = 0; k < 4; ++k) {
      entries.emplace_back(static_cast<int>(row), static_cast<int>(at[row].index[k]), at[row].value[k]);
    }
  }
  const auto n = static_cast<Eigen::Index>(count);
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseLU<Eigen::SparseMatrix<double>> solver(matrix);
  if (solver.info() != Eigen::Success) throw std::runtime_error("the collocation system is singular");
  return solver.solve(y);
}

/// A model whose surface goes through `radius` at the theta knots and at the Greville abscissas in z. All measured, no
/// normal matrix. With enough knots it is the closed form to O(h⁴).
inline SurfaceModel InterpolatedBody(const RadiusFunction& radius, std::size_t theta_count,
                                     const std::vector<double>& breakpoints) {
  const PeriodicCubicBasis theta(theta_count);
  const ClampedCubicBasis z(breakpoints);
  std::vector<double> knots(3, breakpoints.front());
  knots.insert(knots.end(), breakpoints.begin(), breakpoints.end());
  knots.insert(knots.end(), 3, breakpoints.back());
  std::vector<CubicBasis> theta_at;
  std::vector<CubicBasis> z_at;
  const auto columns = static_cast<Eigen::Index>(theta.count());
  const auto rows = static_cast<Eigen::Index>(z.count());
  Eigen::MatrixXd values(columns, rows);
  for (std::size_t i = 0; i < theta.count(); ++i) theta_at.push_back(theta.At(theta.spacing() * double(i)));
  for (std::size_t j = 0; j < z.count(); ++j) {
    const double height = (knots[j + 1] + knots[j + 2] + knots[j + 3]) / 3.0;
    z_at.push_back(z.At(height));
    for (std::size_t i = 0; i < theta.count(); ++i) {
      values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = radius(theta.spacing() * double(i), height);
    }
  }
  const Eigen::MatrixXd around = Collocate(theta_at, theta.count(), values);
  const Eigen::MatrixXd c = Collocate(z_at, z.count(), around.transpose()).transpose();
  KnowledgeMap knowledge(36, 40, breakpoints.front(), breakpoints.back());
  for (std::size_t row = 0; row < knowledge.rows(); ++row) {
    for (std::size_t column = 0; column < knowledge.columns(); ++column) {
      knowledge.SetCell(column, row, Knowledge::kMeasured);
    }
  }
  SurfaceModel model;
  model.segments.push_back(
      {"body", {theta, z, Eigen::Map<const Eigen::VectorXd>(c.data(), c.size())}, knowledge, {}, {}, {}});
  return model;
}

}  // namespace annulus::test
