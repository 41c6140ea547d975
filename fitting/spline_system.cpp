#include "fitting/spline_system.h"

#include <algorithm>
#include <numeric>

#include "base/ensure.h"
#include "fitting/front_kernels.h"

namespace annulus {
namespace {

/// Share of the mean data weight of a coefficient that keeps coefficients over holes determined.
constexpr double kRidge = 1e-9;

/// Places of items sorted by key: items of key k are order[first[k]] … order[first[k + 1] − 1], in their given order.
struct Buckets {
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> first;
};

Buckets SortByKey(const std::vector<std::uint32_t>& key, std::size_t keys) {
  Buckets buckets{std::vector<std::uint32_t>(key.size()), std::vector<std::uint32_t>(keys + 1, 0)};
  for (const std::uint32_t k : key) ++buckets.first[k + 1];
  std::partial_sum(buckets.first.begin(), buckets.first.end(), buckets.first.begin());
  std::vector<std::uint32_t> next(buckets.first.begin(), buckets.first.end() - 1);
  for (std::size_t n = 0; n < key.size(); ++n) buckets.order[next[key[n]]++] = static_cast<std::uint32_t>(n);
  return buckets;
}

}  // namespace

/// Makes the equations of one leaf after the other.
class SplineSystem::LeafEquations {
 public:
  LeafEquations(const SplineSystem& system, const RoughnessWeights& weights, std::span<const double> factors)
      : system_(system), weights_(weights), factors_(factors) {
    const CellGrid& cells = system.cells_;
    uu_scale_ = std::pow(cells.theta_step(), 4);
    vv_scale_ = std::pow(cells.z_step(), 4);
    uv_scale_ = std::pow(cells.theta_step() * cells.z_step(), 2);
    hole_theta_ = HoleWeight(cells.theta_step());
    hole_z_ = HoleWeight(cells.z_step());
  }

  /// The leaf's matrix over its active coefficients; valid until the next call.
  FrontalCholesky::LeafView Matrix(std::size_t l) {
    const SplineLeaf& leaf = system_.basis_.leaves()[l];
    tensor_rows_.clear();
    AppendData(l);
    ForCells(l, [&](const CellRows& rows) {
      tensor_rows_.insert(tensor_rows_.end(), {rows.uu, rows.vv, rows.uv});
      if (rows.hole) tensor_rows_.insert(tensor_rows_.end(), {rows.hole_theta, rows.hole_z});
    });
    TensorForm form{};
    AddTensorRows(tensor_rows_, form);
    local_ = Expanded(form);
    if (leaf.plain) return {local_.data(), 16};
    const std::size_t stride = (leaf.count + kFrontLanes - 1) / kFrontLanes * kFrontLanes;
    matrix_.resize(std::max(matrix_.size(), stride * leaf.count));
    extraction_.assign(std::size_t{16} * leaf.count, 0.0);
    for (const ExtractionEntry& e : system_.basis_.Extraction(leaf)) {
      extraction_[std::size_t{16} * e.active + e.local] = e.weight;
    }
    ProjectForm(local_.data(), extraction_.data(), leaf.count, matrix_.data(), stride);
    return {matrix_.data(), stride};
  }

  TensorForm Data(std::size_t l) {
    tensor_rows_.clear();
    AppendData(l);
    TensorForm form{};
    AddTensorRows(tensor_rows_, form);
    return form;
  }

 private:
  /// The rows of one cell's penalty.
  struct CellRows {
    TensorRow uu, vv, uv;
    bool hole = false;
    TensorRow hole_theta, hole_z;
  };

  static double HoleWeight(double step) { return std::pow(step / kHoleSlope, 2); }

  void AppendData(std::size_t l) {
    const double scale = 1.0 / (system_.noise_sigma_ * system_.noise_sigma_);
    const SplineLeaf& leaf = system_.basis_.leaves()[l];
    for (std::uint32_t k = system_.row_first_[l]; k < system_.row_first_[l + 1]; ++k) {
      const SampleRow& row = system_.rows_[k];
      const double factor = factors_.empty() ? 1.0 : factors_[k];
      const RowSplines at = system_.SplinesAt(row, leaf);
      tensor_rows_.push_back({at.theta, at.z, scale * static_cast<double>(row.weight) * factor});
    }
  }

  template <class Visit>
  void ForCells(std::size_t l, Visit visit) const {
    const std::uint8_t level = system_.basis_.leaves()[l].level;
    const CellGrid& cells = system_.cells_;
    for (std::uint32_t k = system_.cell_first_[l]; k < system_.cell_first_[l + 1]; ++k) {
      const std::uint32_t cell = system_.cell_order_[k];
      const std::size_t column = cell % cells.columns();
      const std::size_t row = cell / cells.columns();
      const CubicBasis& theta = system_.cell_bases_.theta[level][column];
      const CubicBasis& z = system_.cell_bases_.z[level][row];
      const CellBend& w = weights_.cells[cell];
      visit(CellRows{{theta.second, z.value, w.uu * uu_scale_},
                     {theta.value, z.second, w.vv * vv_scale_},
                     {theta.first, z.first, w.uv * uv_scale_},
                     cells.count(column, row) == 0,
                     {theta.first, z.value, hole_theta_},
                     {theta.value, z.first, hole_z_}});
    }
  }

  const SplineSystem& system_;
  const RoughnessWeights& weights_;
  std::span<const double> factors_;
  double uu_scale_ = 0.0, vv_scale_ = 0.0, uv_scale_ = 0.0, hole_theta_ = 0.0, hole_z_ = 0.0;
  std::vector<TensorRow> tensor_rows_;
  std::array<double, 256> local_{};  ///< 16 × 16
  std::vector<double> extraction_;   ///< 16 × count
  std::vector<double> matrix_;
};

SplineSystem::SplineSystem(const HierarchicalSpline& basis, const UsedSamples& used, const CellGrid& cells)
    : basis_(basis), cells_(cells), noise_sigma_(used.noise_sigma) {
  ENSURE(used.noise_sigma > 0.0, "the noise scale is positive");
  std::vector<std::uint32_t> samples;
  std::vector<std::uint32_t> leaf_of;
  for (std::size_t k = 0; k < used.samples.size(); ++k) {
    if (used.use[k] == 0) continue;
    samples.push_back(static_cast<std::uint32_t>(k));
    leaf_of.push_back(static_cast<std::uint32_t>(basis.LeafAt(used.samples[k].theta, used.samples[k].z)));
  }
  Buckets buckets = SortByKey(leaf_of, basis.leaves().size());
  row_first_ = std::move(buckets.first);
  rows_.resize(samples.size());
  for (std::size_t n = 0; n < rows_.size(); ++n) {
    SampleRow& row = rows_[n];
    row.sample = samples[buckets.order[n]];
    row.leaf = leaf_of[buckets.order[n]];
    const SurfaceSample& s = used.samples[row.sample];
    const SplineLeaf& leaf = basis.leaves()[row.leaf];
    const SplineLevel& level = basis.levels()[leaf.level];
    row.theta = WrapAngle(s.theta) / level.theta.spacing() - static_cast<double>(leaf.theta_cell);
    const std::vector<double>& z = level.z.breakpoints();
    row.z = (s.z - z[leaf.z_cell]) / (z[leaf.z_cell + 1] - z[leaf.z_cell]);
    row.radius = s.radius;
    row.weight = used.weights.empty() ? s.weight : used.weights[row.sample];
    row.cell = static_cast<std::uint32_t>(cells.IndexOf(s));
  }

  std::vector<std::uint32_t> leaf_of_cell(cells.columns() * cells.rows());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      leaf_of_cell[cells.Index(column, row)] =
          static_cast<std::uint32_t>(basis.LeafAt(cells.theta(column), cells.z(row)));
    }
  }
  Buckets by_leaf = SortByKey(leaf_of_cell, basis.leaves().size());
  cell_order_ = std::move(by_leaf.order);
  cell_first_ = std::move(by_leaf.first);
  for (const SplineLevel& level : basis.levels()) {
    std::vector<CubicBasis>& around = cell_bases_.theta.emplace_back();
    for (std::size_t c = 0; c < cells.columns(); ++c) around.push_back(level.theta.At(cells.theta(c)));
    std::vector<CubicBasis>& up = cell_bases_.z.emplace_back();
    for (std::size_t r = 0; r < cells.rows(); ++r) up.push_back(level.z.At(cells.z(r)));
    std::vector<IntervalCubics>& cubics = z_cubics_.emplace_back();
    for (std::size_t cell = 0; cell < level.z_cells(); ++cell) cubics.push_back(level.z.Cubics(cell));
  }
}

std::vector<TensorForm> SplineSystem::DataForms(std::span<const double> factors) const {
  const RoughnessWeights none;
  LeafEquations equations(*this, none, factors);
  std::vector<TensorForm> forms;
  forms.reserve(basis_.leaves().size());
  for (std::size_t l = 0; l < basis_.leaves().size(); ++l) forms.push_back(equations.Data(l));
  return forms;
}

double SplineSystem::ridge() const {
  return kRidge * static_cast<double>(rows_.size()) / static_cast<double>(basis_.size()) /
         (noise_sigma_ * noise_sigma_);
}

std::vector<CellBend> SplineSystem::Bends(const Eigen::VectorXd& coefficients) const {
  std::vector<CellBend> bends(cell_order_.size());
  const double uu_scale = std::pow(cells_.theta_step(), 2);
  const double vv_scale = std::pow(cells_.z_step(), 2);
  const double uv_scale = cells_.theta_step() * cells_.z_step();
  for (std::size_t l = 0; l + 1 < cell_first_.size(); ++l) {
    if (cell_first_[l] == cell_first_[l + 1]) continue;
    const SplineLeaf& leaf = basis_.leaves()[l];
    const Eigen::Matrix<double, 16, 1> local = basis_.Local(leaf, coefficients);
    for (std::uint32_t k = cell_first_[l]; k < cell_first_[l + 1]; ++k) {
      const std::uint32_t cell = cell_order_[k];
      const CubicBasis& theta = cell_bases_.theta[leaf.level][cell % cells_.columns()];
      const CubicBasis& z = cell_bases_.z[leaf.level][cell / cells_.columns()];
      CellBend& bend = bends[cell];
      for (std::size_t j = 0; j < 4; ++j) {
        const double* c = local.data() + 4 * j;
        const auto along = [c](const std::array<double, 4>& w) {
          return w[0] * c[0] + w[1] * c[1] + w[2] * c[2] + w[3] * c[3];
        };
        bend.uu += uu_scale * z.value[j] * along(theta.second);
        bend.vv += vv_scale * z.second[j] * along(theta.value);
        bend.uv += uv_scale * z.first[j] * along(theta.first);
      }
    }
  }
  return bends;
}

Eigen::VectorXd SplineSystem::Predict(const Eigen::VectorXd& coefficients) const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t l = 0; l + 1 < row_first_.size(); ++l) {
    if (row_first_[l] == row_first_[l + 1]) continue;
    const SplineLeaf& leaf = basis_.leaves()[l];
    const Eigen::Matrix<double, 16, 1> local = basis_.Local(leaf, coefficients);
    for (std::uint32_t k = row_first_[l]; k < row_first_[l + 1]; ++k) {
      const RowSplines row = SplinesAt(rows_[k], leaf);
      double value = 0.0;
      for (std::size_t j = 0; j < 4; ++j) {
        const double* c = local.data() + 4 * j;
        value += row.z[j] * (row.theta[0] * c[0] + row.theta[1] * c[1] + row.theta[2] * c[2] + row.theta[3] * c[3]);
      }
      values[static_cast<Eigen::Index>(k)] = value;
    }
  }
  return values;
}

Eigen::VectorXd SplineSystem::Radii() const {
  Eigen::VectorXd radii(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t k = 0; k < rows_.size(); ++k) radii[static_cast<Eigen::Index>(k)] = rows_[k].radius;
  return radii;
}

Eigen::VectorXd SplineSystem::Residuals(const Eigen::VectorXd& coefficients) const {
  Eigen::VectorXd residuals = Predict(coefficients);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    double& value = residuals[static_cast<Eigen::Index>(k)];
    value = rows_[k].radius - value;
  }
  return residuals;
}

Eigen::VectorXd SplineSystem::Transpose(const Eigen::VectorXd& values) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(basis_.size()));
  for (std::size_t l = 0; l + 1 < row_first_.size(); ++l) {
    if (row_first_[l] == row_first_[l + 1]) continue;
    const SplineLeaf& leaf = basis_.leaves()[l];
    Eigen::Matrix<double, 16, 1> local = Eigen::Matrix<double, 16, 1>::Zero();
    for (std::uint32_t k = row_first_[l]; k < row_first_[l + 1]; ++k) {
      const RowSplines row = SplinesAt(rows_[k], leaf);
      for (std::size_t j = 0; j < 4; ++j) {
        const double left = values[static_cast<Eigen::Index>(k)] * row.z[j];
        for (std::size_t i = 0; i < 4; ++i) local[static_cast<Eigen::Index>(4 * j + i)] += left * row.theta[i];
      }
    }
    const std::span<const std::uint32_t> active = basis_.Active(leaf);
    if (leaf.plain) {
      for (std::size_t k = 0; k < 16; ++k) {
        sum[static_cast<Eigen::Index>(active[k])] += local[static_cast<Eigen::Index>(k)];
      }
    }
    for (const ExtractionEntry& e : basis_.Extraction(leaf)) {
      sum[static_cast<Eigen::Index>(active[e.active])] += e.weight * local[e.local];
    }
  }
  return sum;
}

Eigen::VectorXd SplineSystem::WeightedTranspose(const Eigen::VectorXd& values, std::span<const double> factors) const {
  Eigen::VectorXd weighted(values.size());
  const double scale = 1.0 / (noise_sigma_ * noise_sigma_);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const double factor = factors.empty() ? 1.0 : factors[k];
    const auto index = static_cast<Eigen::Index>(k);
    weighted[index] = scale * static_cast<double>(rows_[k].weight) * factor * values[index];
  }
  return Transpose(weighted);
}

std::optional<FrontalCholesky> SplineSystem::Factor(std::shared_ptr<const EliminationTree> tree,
                                                    const RoughnessWeights& weights,
                                                    std::span<const double> factors) const {
  LeafEquations equations(*this, weights, factors);
  return FrontalCholesky::Factor(
      std::move(tree), basis_, [&](std::size_t l) { return equations.Matrix(l); }, ridge());
}

namespace {

/// The upper triangle of a matrix that couples all coefficients sharing a leaf: all entries zero, rows ascending.
Eigen::SparseMatrix<double> UpperPattern(const HierarchicalSpline& basis) {
  std::vector<std::uint32_t> leaf_of;
  std::vector<std::uint32_t> coefficient;
  for (std::size_t l = 0; l < basis.leaves().size(); ++l) {
    for (const std::uint32_t c : basis.Active(basis.leaves()[l])) {
      leaf_of.push_back(static_cast<std::uint32_t>(l));
      coefficient.push_back(c);
    }
  }
  const Buckets leaves_of = SortByKey(coefficient, basis.size());
  Eigen::SparseMatrix<double> upper(static_cast<Eigen::Index>(basis.size()), static_cast<Eigen::Index>(basis.size()));
  std::vector<std::uint32_t> rows;
  std::vector<std::uint32_t> coupled_to(basis.size(), static_cast<std::uint32_t>(basis.size()));  // last column with it
  for (std::size_t c = 0; c < basis.size(); ++c) {
    rows.clear();
    for (std::uint32_t k = leaves_of.first[c]; k < leaves_of.first[c + 1]; ++k) {
      for (const std::uint32_t row : basis.Active(basis.leaves()[leaf_of[leaves_of.order[k]]])) {
        if (row > c || coupled_to[row] == c) continue;
        coupled_to[row] = static_cast<std::uint32_t>(c);
        rows.push_back(row);
      }
    }
    std::sort(rows.begin(), rows.end());
    upper.startVec(static_cast<Eigen::Index>(c));
    for (const std::uint32_t row : rows) upper.insertBack(row, static_cast<Eigen::Index>(c)) = 0.0;
  }
  upper.finalize();
  return upper;
}

}  // namespace

Eigen::SparseMatrix<double> SplineSystem::NormalMatrix(const RoughnessWeights& weights,
                                                       std::span<const double> factors) const {
  LeafEquations equations(*this, weights, factors);
  Eigen::SparseMatrix<double> upper = UpperPattern(basis_);
  for (std::size_t l = 0; l < basis_.leaves().size(); ++l) {
    const FrontalCholesky::LeafView matrix = equations.Matrix(l);
    const std::span<const std::uint32_t> active = basis_.Active(basis_.leaves()[l]);
    for (std::size_t b = 0; b < active.size(); ++b) {
      const int* first = upper.innerIndexPtr() + upper.outerIndexPtr()[active[b]];
      const int* last = upper.innerIndexPtr() + upper.outerIndexPtr()[active[b] + 1];
      for (std::size_t a = 0; a < active.size(); ++a) {
        if (active[a] > active[b]) continue;
        const int* place = std::lower_bound(first, last, static_cast<int>(active[a]));
        upper.valuePtr()[place - upper.innerIndexPtr()] += matrix.data[b * matrix.stride + a];
      }
    }
  }
  for (Eigen::Index c = 0; c < upper.cols(); ++c) upper.valuePtr()[upper.outerIndexPtr()[c + 1] - 1] += ridge();
  return upper;
}

}  // namespace annulus
