#include "sim/section_spline.h"

#include <algorithm>

#include "base/ensure.h"

namespace annulus::sim {
namespace {

SectionSpline::Values ValuesOf(const TubeRow& row) {
  return {row.half_width, (row.front - row.back) / 2.0, row.x_centre, (row.front + row.back) / 2.0, row.squareness,
          row.egg};
}

// Second derivatives of the natural cubic spline through (x, y), by the Thomas algorithm.
std::vector<double> SecondDerivatives(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  std::vector<double> second(n, 0.0);
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double left = x[i] - x[i - 1];
    const double right = x[i + 1] - x[i];
    const double slope_change = (y[i + 1] - y[i]) / right - (y[i] - y[i - 1]) / left;
    const double pivot = 2.0 * (left + right) - left * upper[i - 1];
    upper[i] = right / pivot;
    second[i] = (6.0 * slope_change - left * second[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) second[i] -= upper[i] * second[i + 1];
  return second;
}

}  // namespace

SectionSpline::SectionSpline(const std::vector<TubeRow>& rows) {
  ENSURE(rows.size() >= 3, "a tube needs three rows");
  for (const TubeRow& row : rows) {
    ENSURE(knots_.empty() || row.z > knots_.back(), "rows go upwards");
    knots_.push_back(row.z);
  }
  pieces_.resize(rows.size() - 1);
  for (std::size_t parameter = 0; parameter < kParameterCount; ++parameter) {
    std::vector<double> y;
    for (const TubeRow& row : rows) y.push_back(ValuesOf(row)[parameter]);
    const std::vector<double> second = SecondDerivatives(knots_, y);
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
      const double h = knots_[i + 1] - knots_[i];
      pieces_[i][0][parameter] = y[i];
      pieces_[i][1][parameter] = (y[i + 1] - y[i]) / h - h * (2.0 * second[i] + second[i + 1]) / 6.0;
      pieces_[i][2][parameter] = second[i] / 2.0;
      pieces_[i][3][parameter] = (second[i + 1] - second[i]) / (6.0 * h);
    }
  }
}

SectionSpline::Values SectionSpline::At(double z) const {
  const double inside = std::clamp(z, knots_.front(), knots_.back());
  const auto above = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, inside);
  const auto piece = static_cast<std::size_t>(above - knots_.begin()) - 1;
  const double u = inside - knots_[piece];
  const Cubic& cubic = pieces_[piece];
  Values values{};
  for (std::size_t k = 0; k < kParameterCount; ++k) {
    values[k] = cubic[0][k] + u * (cubic[1][k] + u * (cubic[2][k] + u * cubic[3][k]));
  }
  return values;
}

}  // namespace annulus::sim
