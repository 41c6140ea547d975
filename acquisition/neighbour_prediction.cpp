#include "acquisition/neighbour_prediction.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

constexpr double kMostGain = 6.0;
constexpr double kFar = 4.0;  // steps; a neighbour that far away counts nothing

/// Tricube (Cleveland 1979).
double Nearness(double place) {
  const double share = std::abs(place) / kFar;
  if (!(share < 1.0)) return 0.0;
  const double rest = 1.0 - share * share * share;
  return rest * rest * rest;
}

/// The value at 0 of the polynomial with so many coefficients that fits the neighbours best.
template <int kTerms>
std::optional<NeighbourStencil> ValueOfPolynomial(const std::array<double, kNeighbours>& place,
                                                  const std::array<double, kNeighbours>& nearness) {
  using Row = Eigen::Matrix<double, kTerms, 1>;
  Eigen::Matrix<double, kTerms, kTerms> normal = Eigen::Matrix<double, kTerms, kTerms>::Zero();
  std::array<Row, kNeighbours> rows;
  for (std::size_t k = 0; k < kNeighbours; ++k) {
    if (nearness[k] <= 0.0) continue;
    rows[k](0) = 1.0;
    for (int power = 1; power < kTerms; ++power) rows[k](power) = rows[k](power - 1) * place[k] / kFar;
    normal += nearness[k] * rows[k] * rows[k].transpose();
  }
  const Eigen::LDLT<Eigen::Matrix<double, kTerms, kTerms>> solver(normal);
  if (!(solver.vectorD().minCoeff() > 1e-12)) return std::nullopt;
  const Row value = solver.solve(Row::UnitX());
  NeighbourStencil stencil;
  for (std::size_t k = 0; k < kNeighbours; ++k) {
    if (nearness[k] <= 0.0) continue;
    stencil.weight[k] = nearness[k] * rows[k].dot(value);
    stencil.gain += stencil.weight[k] * stencil.weight[k];
  }
  if (!(stencil.gain <= kMostGain)) return std::nullopt;
  return stencil;
}

}  // namespace

std::optional<NeighbourStencil> StencilFor(const std::array<double, kNeighbours>& place) {
  std::array<double, kNeighbours> nearness{};
  int before = 0;
  int behind = 0;
  for (std::size_t k = 0; k < kNeighbours; ++k) {
    if (std::isnan(place[k])) continue;
    nearness[k] = Nearness(place[k]);
    if (nearness[k] > 0.0) (place[k] < 0.0 ? before : behind) += 1;
  }
  if (before < 1 || behind < 1) return std::nullopt;
  const bool cubic = before >= 2 && behind >= 2;
  std::optional<NeighbourStencil> stencil;
  if (cubic) stencil = ValueOfPolynomial<4>(place, nearness);
  // Where beams cross, a cubic may hang on two points that all but coincide.
  if (!stencil && before + behind >= 3) stencil = ValueOfPolynomial<3>(place, nearness);
  return stencil;
}

const NeighbourStencil& RegularStencil() {
  static const NeighbourStencil kRegular = *StencilFor({-5.0, -4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0, 5.0});
  return kRegular;
}

std::optional<ColumnWindow::Residual> ColumnWindow::At(std::size_t level) const {
  constexpr double kRegularWithin = 0.02;  // steps
  const float own = entries_[kNeighbourReach].column->radius[level];
  if (std::isnan(own)) return std::nullopt;
  const double turn = entries_[kNeighbourReach].column->turn[level];
  std::array<double, kNeighbours> place{};
  std::array<double, kNeighbours> radius{};
  bool regular = true;
  for (std::size_t k = 0; k < kNeighbours; ++k) {
    const std::size_t at = k < kNeighbourReach ? k : k + 1;
    const Entry& entry = entries_[at];
    radius[k] = entry.column->radius[level];
    const double off = entry.direction_steps + (entry.column->turn[level] - turn) / step_;
    place[k] = std::isnan(radius[k]) ? radius[k] : off;
    const double nominal = static_cast<double>(at) - static_cast<double>(kNeighbourReach);
    const bool counts = std::abs(nominal) < kFar;
    regular = regular && (!counts || std::abs(place[k] - nominal) < kRegularWithin);  // false for NaN
  }
  std::optional<NeighbourStencil> fitted;
  if (!regular && !(fitted = StencilFor(place))) return std::nullopt;
  const NeighbourStencil& stencil = regular ? RegularStencil() : *fitted;
  double predicted = 0.0;
  for (std::size_t k = 0; k < kNeighbours; ++k) {
    if (stencil.weight[k] != 0.0) predicted += stencil.weight[k] * radius[k];
  }
  return Residual{own - predicted, stencil};
}

ColumnWindow WindowAt(const RingProfile& profile, std::size_t column) {
  const std::size_t n = profile.columns();
  const double step = kTwoPi / static_cast<double>(n);
  std::array<ColumnWindow::Entry, kNeighbours + 1> entries;
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const std::size_t other = (column + n + k - kNeighbourReach) % n;
    entries[k] = {&profile.Column(other), AngleDifference(profile.Direction(other), profile.Direction(column)) / step};
  }
  return {entries, step};
}

}  // namespace annulus
