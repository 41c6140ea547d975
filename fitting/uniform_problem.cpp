#include "fitting/uniform_problem.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"
#include "base/frames.h"
#include "fitting/front_kernels.h"
#include "fitting/roughness.h"

namespace annulus {
namespace {

constexpr double kRidge = 1e-10;

/// Forms of one axis over the places of the cells; `step` is their distance.
AxisForms FormsOf(const std::vector<CubicBasis>& places, std::size_t count, double step) {
  const auto n = static_cast<Eigen::Index>(count);
  AxisForms forms{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n)};
  for (const CubicBasis& at : places) {
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        const auto row = static_cast<Eigen::Index>(at.index[a]);
        const auto column = static_cast<Eigen::Index>(at.index[b]);
        forms.gram(row, column) += at.value[a] * at.value[b];
        forms.bend(row, column) += at.second[a] * at.second[b] * std::pow(step, 4);
      }
    }
  }
  return forms;
}

/// Fills the empty places of a row of `count` values, cyclic, by straight lines between the others. False if all are
/// empty.
bool BridgeRow(double* values, const std::vector<char>& seen) {
  const std::size_t count = seen.size();
  const auto first = static_cast<std::size_t>(std::find(seen.begin(), seen.end(), 1) - seen.begin());
  if (first == count) return false;
  std::size_t before = first;
  for (std::size_t step = 1; step <= count; ++step) {
    const std::size_t after = first + step;
    if (seen[after % count] == 0) continue;
    const double from = values[before % count];
    const double rise = (values[after % count] - from) / static_cast<double>(after - before);
    for (std::size_t k = before + 1; k < after; ++k) {
      values[k % count] = from + rise * static_cast<double>(k - before);
    }
    before = after;
  }
  return true;
}

}  // namespace

UniformTensorBasis::UniformTensorBasis(std::size_t theta_count, double z_min, double z_max, std::size_t z_intervals)
    : theta_(theta_count),
      z_(UniformBreakpoints(z_min, z_max, z_intervals)),
      intervals_per_rad_(static_cast<double>(theta_count) / kTwoPi),
      intervals_per_mm_(static_cast<double>(z_intervals) / (z_max - z_min)) {
  for (std::size_t k = 0; k < theta_count + 3; ++k) column_.push_back((k + theta_count - 1) % theta_count);
  for (std::size_t k = 0; k < z_intervals; ++k) {
    const double width = z_.breakpoints()[k + 1] - z_.breakpoints()[k];
    const CubicBasis low = z_.InInterval(k, z_.breakpoints()[k]);
    const CubicBasis high = z_.InInterval(k, z_.breakpoints()[k + 1]);
    std::array<double, 16> powers{};
    for (std::size_t s = 0; s < 4; ++s) {
      powers[s] = low.value[s];
      powers[4 + s] = low.first[s] * width;
      powers[8 + s] = 0.5 * low.second[s] * width * width;
      powers[12 + s] = high.value[s] - powers[s] - powers[4 + s] - powers[8 + s];
    }
    z_polynomials_.push_back(powers);
  }
}

TensorPlace UniformTensorBasis::At(double theta, double z) const {
  TensorPlace place;
  const double u = WrapAngle(theta) * intervals_per_rad_;
  place.theta_interval = std::min(static_cast<std::size_t>(u), theta_.count() - 1);
  const double t = u - static_cast<double>(place.theta_interval);
  const double s = 1.0 - t;
  place.theta = {s * s * s / 6.0, 2.0 / 3.0 - t * t + 0.5 * t * t * t, 2.0 / 3.0 - s * s + 0.5 * s * s * s,
                 t * t * t / 6.0};
  const double last = static_cast<double>(z_polynomials_.size() - 1);
  const double v = std::clamp((z - z_.min()) * intervals_per_mm_, 0.0, last + 1.0);
  place.z_interval = static_cast<std::size_t>(std::min(v, last));
  const double x = v - static_cast<double>(place.z_interval);
  const std::array<double, 16>& p = z_polynomials_[place.z_interval];
  for (std::size_t k = 0; k < 4; ++k) place.z[k] = p[k] + x * (p[4 + k] + x * (p[8 + k] + x * p[12 + k]));
  return place;
}

double UniformTensorBasis::Value(const TensorPlace& place, const Eigen::VectorXd& coefficients) const {
  double value = 0.0;
  const std::size_t* column = &column_[place.theta_interval];
  for (std::size_t b = 0; b < 4; ++b) {
    const double* c = coefficients.data() + (place.z_interval + b) * theta_.count();
    value += place.z[b] * (place.theta[0] * c[column[0]] + place.theta[1] * c[column[1]] +
                           place.theta[2] * c[column[2]] + place.theta[3] * c[column[3]]);
  }
  return value;
}

void UniformTensorBasis::AddTransposed(const TensorPlace& place, double factor, Eigen::VectorXd& coefficients) const {
  const std::size_t* column = &column_[place.theta_interval];
  for (std::size_t b = 0; b < 4; ++b) {
    double* c = coefficients.data() + (place.z_interval + b) * theta_.count();
    const double scale = factor * place.z[b];
    for (std::size_t a = 0; a < 4; ++a) c[column[a]] += scale * place.theta[a];
  }
}

UniformProblem::UniformProblem(const UniformInput& input, std::size_t theta_count, std::size_t z_intervals)
    : input_(input),
      basis_(theta_count, input.cells.z_min(), input.cells.z_max(), z_intervals),
      data_(theta_count, z_intervals + 3),
      right_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(basis_.size()))) {
  ENSURE(input.noise_sigma > 0.0, "the noise scale is positive");
  const CellGrid& cells = input_.cells;
  std::size_t seen = 0;
  std::size_t samples = 0;
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    z_at_row_.push_back(basis_.z().At(cells.z(row)));
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const std::uint32_t count = cells.count(column, row);
      if (count == 0) continue;
      ++seen;
      samples += count;
      mean_radius_ += (cells.mean(column, row) - mean_radius_) / static_cast<double>(seen);
    }
  }
  for (std::size_t column = 0; column < cells.columns(); ++column) {
    theta_at_column_.push_back(basis_.theta().At(cells.theta(column)));
  }
  samples_per_cell_ = static_cast<double>(samples) / static_cast<double>(std::max<std::size_t>(1, seen));
  seen_share_ = static_cast<double>(seen) / static_cast<double>(cells.columns() * cells.rows());
  theta_forms_ = FormsOf(theta_at_column_, basis_.theta().count(), cells.theta_step());
  z_forms_ = FormsOf(z_at_row_, basis_.z().count(), cells.z_step());
  SortByInterval();
  AccumulateData();
}

std::vector<double> UniformProblem::Residuals(const Eigen::VectorXd& coefficients) const {
  std::vector<double> residuals;
  residuals.reserve(used_.size());
  for (const std::uint32_t k : used_) residuals.push_back(Height(k) - basis_.Value(Place(k), coefficients));
  return residuals;
}

void UniformProblem::SortByInterval() {
  const std::size_t intervals = basis_.z().breakpoints().size() - 1;
  first_of_interval_.assign(intervals + 1, 0);
  const double per_mm = static_cast<double>(intervals) / (basis_.z().max() - basis_.z().min());
  const auto interval_of = [&](const SurfaceSample& s) {
    const double v = std::clamp((s.z - basis_.z().min()) * per_mm, 0.0, static_cast<double>(intervals - 1));
    return static_cast<std::size_t>(v);
  };
  for (std::size_t k = 0; k < input_.samples.size(); ++k) {
    if (input_.verdicts[k] == SampleVerdict::kGood) ++first_of_interval_[interval_of(input_.samples[k]) + 1];
  }
  for (std::size_t k = 0; k < intervals; ++k) first_of_interval_[k + 1] += first_of_interval_[k];
  used_.resize(first_of_interval_.back());
  std::vector<std::uint32_t> next(first_of_interval_.begin(), first_of_interval_.end() - 1);
  for (std::size_t k = 0; k < input_.samples.size(); ++k) {
    if (input_.verdicts[k] != SampleVerdict::kGood) continue;
    used_[next[interval_of(input_.samples[k])]++] = static_cast<std::uint32_t>(k);
  }
}

void UniformProblem::AccumulateData() {
  const double scale = 1.0 / (input_.noise_sigma * input_.noise_sigma);
  std::vector<TensorForm> forms(basis_.theta().count());
  std::vector<TensorRow> run;  // consecutive samples of one interval around
  for (std::size_t interval = 0; interval + 1 < first_of_interval_.size(); ++interval) {
    if (first_of_interval_[interval] == first_of_interval_[interval + 1]) continue;
    for (TensorForm& form : forms) form.fill(0.0);
    std::size_t run_interval = 0;
    for (std::size_t n = first_of_interval_[interval]; n < first_of_interval_[interval + 1]; ++n) {
      const TensorPlace place = Place(used_[n]);
      const double weight = scale * static_cast<double>(input_.samples[used_[n]].weight);
      basis_.AddTransposed(place, weight * Height(used_[n]), right_);
      if (place.theta_interval != run_interval) {
        AddTensorRows(run, forms[run_interval]);
        run.clear();
        run_interval = place.theta_interval;
      }
      run.push_back({place.theta, place.z, weight});
    }
    AddTensorRows(run, forms[run_interval]);
    run.clear();
    for (std::size_t i = 0; i < forms.size(); ++i) data_.AddForm(i, interval, forms[i]);
  }
}

void UniformProblem::AddHoles(TensorMatrix& matrix) const {
  const CellGrid& cells = input_.cells;
  const double theta_weight = std::pow(cells.theta_step() / kHoleSlope, 2);
  const double z_weight = std::pow(cells.z_step() / kHoleSlope, 2);
  std::vector<TensorForm> forms(basis_.theta().count());
  std::vector<char> touched(forms.size(), 0);
  std::array<TensorRow, 2> slopes{};
  slopes[0].weight = theta_weight;
  slopes[1].weight = z_weight;
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const CubicBasis& z = z_at_row_[row];
    slopes[0].z = z.value;
    slopes[1].z = z.first;
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      if (cells.count(column, row) > 0) continue;
      const CubicBasis& theta = theta_at_column_[column];
      const std::size_t interval = (theta.index[0] + 1) % basis_.theta().count();
      if (touched[interval] == 0) forms[interval].fill(0.0);
      touched[interval] = 1;
      slopes[0].theta = theta.first;
      slopes[1].theta = theta.value;
      AddTensorRows(slopes, forms[interval]);
    }
    if (row + 1 < cells.rows() && z_at_row_[row + 1].index[0] == z.index[0]) continue;  // more rows of this interval
    for (std::size_t i = 0; i < forms.size(); ++i) {
      if (touched[i] != 0) matrix.AddForm(i, z.index[0], forms[i]);
      touched[i] = 0;
    }
  }
}

GridData UniformProblem::ProjectCells() const {
  const CellGrid& cells = input_.cells;
  const auto columns = static_cast<Eigen::Index>(cells.columns());
  const auto rows = static_cast<Eigen::Index>(cells.rows());
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(columns, rows);
  std::vector<char> seen(cells.columns());
  std::vector<Eigen::Index> held;  // rows that hold anything
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    double* value = values.data() + row * cells.columns();
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      seen[column] = cells.count(column, row) > 0 ? 1 : 0;
      if (seen[column] != 0) value[column] = cells.mean(column, row) - mean_radius_;
    }
    if (BridgeRow(value, seen)) held.push_back(static_cast<Eigen::Index>(row));
  }
  // The lowest and highest rows hold samples: the cells span them.
  for (std::size_t k = 0; k + 1 < held.size(); ++k) {
    for (Eigen::Index row = held[k] + 1; row < held[k + 1]; ++row) {
      const double share = static_cast<double>(row - held[k]) / static_cast<double>(held[k + 1] - held[k]);
      values.col(row) = (1.0 - share) * values.col(held[k]) + share * values.col(held[k + 1]);
    }
  }
  GridData data;
  data.squares = values.squaredNorm();
  data.cells = static_cast<double>(values.size());
  data.projected = Eigen::MatrixXd::Zero(theta_forms_.gram.rows(), z_forms_.gram.rows());
  Eigen::VectorXd around(theta_forms_.gram.rows());
  for (Eigen::Index row = 0; row < rows; ++row) {
    around.setZero();
    for (Eigen::Index column = 0; column < columns; ++column) {
      const CubicBasis& theta = theta_at_column_[static_cast<std::size_t>(column)];
      for (std::size_t a = 0; a < 4; ++a) {
        around[static_cast<Eigen::Index>(theta.index[a])] += theta.value[a] * values(column, row);
      }
    }
    const CubicBasis& z = z_at_row_[static_cast<std::size_t>(row)];
    for (std::size_t b = 0; b < 4; ++b)
      data.projected.col(static_cast<Eigen::Index>(z.index[b])) += z.value[b] * around;
  }
  return data;
}

SmoothingWeights UniformProblem::ChooseSmoothing() const {
  return ChooseSeparableSmoothing(FindModes(theta_forms_), FindMirroredModes(z_forms_), ProjectCells());
}

TensorMatrix UniformProblem::Penalty(const SmoothingWeights& weights) const {
  TensorMatrix penalty(basis_.theta().count(), basis_.z().count());
  const double scale = samples_per_cell_ / (input_.noise_sigma * input_.noise_sigma);
  penalty.AddProduct(scale * weights.theta, z_forms_.gram, theta_forms_.bend);
  penalty.AddProduct(scale * weights.z, z_forms_.bend, theta_forms_.gram);
  AddHoles(penalty);
  penalty.AddToDiagonal(kRidge * data_.MeanDiagonal());
  return penalty;
}

void UniformProblem::ForPenaltyRows(const SmoothingWeights& weights,
                                    const std::function<void(const TensorPlace& row, double weight)>& visit) const {
  const CellGrid& cells = input_.cells;
  const double scale = samples_per_cell_ / (input_.noise_sigma * input_.noise_sigma);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const CubicBasis& z = z_at_row_[row];
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const CubicBasis& theta = theta_at_column_[column];
      TensorPlace place;
      place.theta_interval = (theta.index[0] + 1) % basis_.theta().count();
      place.z_interval = z.index[0];
      const auto visit_as = [&](const std::array<double, 4>& around, const std::array<double, 4>& up, double weight) {
        place.theta = around;
        place.z = up;
        visit(place, weight);
      };
      visit_as(theta.second, z.value, scale * weights.theta * std::pow(cells.theta_step(), 4));
      visit_as(theta.value, z.second, scale * weights.z * std::pow(cells.z_step(), 4));
      if (cells.count(column, row) > 0) continue;
      visit_as(theta.first, z.value, std::pow(cells.theta_step() / kHoleSlope, 2));
      visit_as(theta.value, z.first, std::pow(cells.z_step() / kHoleSlope, 2));
    }
  }
}

}  // namespace annulus
