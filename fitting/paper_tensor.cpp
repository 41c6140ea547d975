#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>

#include "base/ensure.h"
#include "fitting/paper_surface.h"

namespace annulus {
namespace {

constexpr double kLargestError = 0.01;  // mm
constexpr double kErrorPlaces = 32768.0;
constexpr std::size_t kMostCoefficients = std::size_t{1} << 19;

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Breakpoints: every z knot, and `parts` equal parts between two.
std::vector<double> Subdivide(const std::vector<double>& knots, std::size_t parts) {
  std::vector<double> points;
  for (std::size_t j = 0; j + 1 < knots.size(); ++j) {
    for (std::size_t k = 0; k < parts; ++k) {
      points.push_back(knots[j] + (knots[j + 1] - knots[j]) * static_cast<double>(k) / static_cast<double>(parts));
    }
  }
  points.push_back(knots.back());
  return points;
}

/// Coefficients in z of splines through values at the breakpoints, with given slopes at both ends: rows of `values` are
/// the lower slope, the values upwards, the upper slope.
Eigen::MatrixXd InterpolateAlong(const ClampedCubicBasis& basis, const Eigen::MatrixXd& values) {
  Triplets entries;
  int row = 0;
  const auto add = [&](double z, bool slope) {
    const CubicBasis at = basis.At(z);
    for (std::size_t k = 0; k < 4; ++k) {
      entries.emplace_back(row, static_cast<int>(at.index[k]), slope ? at.first[k] : at.value[k]);
    }
    ++row;
  };
  add(basis.min(), true);
  for (const double z : basis.breakpoints()) add(z, false);
  add(basis.max(), true);
  Eigen::SparseMatrix<double> matrix(values.rows(), values.rows());
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseLU<Eigen::SparseMatrix<double>> factor(matrix);
  ENSURE(factor.info() == Eigen::Success, "an interpolating spline exists");
  return factor.solve(values);
}

SplineSurface InterpolateOn(const PaperSurface& surface, std::size_t theta_count, std::size_t parts) {
  PeriodicCubicBasis theta(theta_count);
  ClampedCubicBasis z(Subdivide(surface.z_knots(), parts));
  const auto columns = static_cast<Eigen::Index>(theta_count);
  const auto rows = static_cast<Eigen::Index>(z.count());
  Eigen::MatrixXd values(rows, columns);
  for (Eigen::Index i = 0; i < columns; ++i) {
    const double angle = theta.spacing() * static_cast<double>(i);
    values(0, i) = surface.Jet(angle, z.min()).r_z;
    for (Eigen::Index j = 1; j + 1 < rows; ++j) {
      values(j, i) = surface.Radius(angle, z.breakpoints()[static_cast<std::size_t>(j - 1)]);
    }
    values(rows - 1, i) = surface.Jet(angle, z.max()).r_z;
  }
  const Eigen::MatrixXd along = InterpolateAlong(z, values);
  const Eigen::MatrixXd control = ClosedControlPoints(along.transpose());  // theta × z: theta fastest, as wanted
  return {std::move(theta), std::move(z), control.reshaped()};
}

/// Distance of the two along the normal, mm, at one place (to first order).
double DistanceAt(const PaperSurface& surface, const SplineSurface& tensor, double theta, double z) {
  const RadiusJet jet = tensor.Jet(theta, z);
  const double steepness = std::sqrt(1.0 + std::pow(jet.r_theta / jet.r, 2) + jet.r_z * jet.r_z);
  return std::abs(jet.r - surface.Radius(theta, z)) / steepness;
}

/// Largest errors half-way between grid lines in theta, and in z.
struct GridErrors {
  double theta = 0.0;
  double z = 0.0;
};

GridErrors ErrorsOf(const PaperSurface& surface, const SplineSurface& tensor) {
  GridErrors errors;
  const double step = tensor.theta_basis().spacing();
  const std::vector<double>& points = tensor.z_basis().breakpoints();
  // Every place of a small grid, about 2^15 of a large one: odd strides, so that they fall on all parts of the spans.
  const std::size_t size = tensor.theta_basis().count() * points.size();
  const auto stride = static_cast<std::size_t>(std::sqrt(static_cast<double>(size) / kErrorPlaces)) | 1U;
  for (std::size_t i = 0; i < tensor.theta_basis().count(); i += stride) {
    const double angle = step * static_cast<double>(i);
    for (std::size_t j = 0; j + 1 < points.size(); j += stride) {
      errors.theta = std::max(errors.theta, DistanceAt(surface, tensor, angle + 0.5 * step, points[j]));
      errors.z = std::max(errors.z, DistanceAt(surface, tensor, angle, 0.5 * (points[j] + points[j + 1])));
    }
  }
  return errors;
}

}  // namespace

TensorApproximation ApproximateByTensor(const PaperSurface& surface) {
  std::size_t theta_count = 3 * surface.theta_knots().size();
  std::size_t parts = 2;
  while (true) {
    TensorApproximation form{InterpolateOn(surface, theta_count, parts), 0.0};
    const GridErrors errors = ErrorsOf(surface, form.surface);
    form.largest_error = errors.theta + errors.z;
    const bool finer_theta = errors.theta > 0.5 * kLargestError;
    const bool finer_z = errors.z > 0.5 * kLargestError;
    const std::size_t next_theta = theta_count * (finer_theta ? 2 : 1);
    const std::size_t next_parts = parts * (finer_z ? 2 : 1);
    const std::size_t size = next_theta * ((surface.z_knots().size() - 1) * next_parts + 3);
    if ((!finer_theta && !finer_z) || size > kMostCoefficients) return form;
    theta_count = next_theta;
    parts = next_parts;
  }
}

}  // namespace annulus
