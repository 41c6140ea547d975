#include "modeling/landmarks/head_without_ears.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/frames.h"
#include "modeling/landmarks/face_points.h"

namespace annulus {
namespace {

// What may be ear: so far beyond its outline, which ends at a fifth of its relief.
constexpr double kBeforeFront = RadiansFromDegrees(17.0);
constexpr double kBehindMiddle = RadiansFromDegrees(26.0);
constexpr double kAboveTop = 15.0;     // mm
constexpr double kBelowBottom = 18.0;  // mm
// What is ear: what stands so far out of a first fill, and so much around it.
constexpr double kStandsOut = 0.25;   // mm
constexpr double kAround = 5.0;       // mm
constexpr double kMeanRadius = 80.0;  // mm, turns columns into lengths

/// The coefficients about an ear as a grid: a spline's coefficient is nearly its value at the centre of its support.
class CoefficientGrid {
 public:
  CoefficientGrid(const SplineSurface& surface, const EarOutline& ear, int stride)
      : stride_(stride),
        columns_total_(static_cast<int>(surface.theta_basis().count())),
        spacing_(surface.theta_basis().spacing()) {
    const double sign = ear.side == BodySide::kRight ? 1.0 : -1.0;  // theta grows forwards on the right side
    front_ = ear.front_theta + sign * kBeforeFront;
    back_ = ear.middle_theta - sign * kBehindMiddle;
    low_ = ear.bottom_z - kBelowBottom;
    high_ = ear.top_z + kAboveTop;
    const double first = std::min(front_, back_);
    const double last = std::max(front_, back_);
    first_column_ = static_cast<int>(std::floor(first / spacing_)) - kMargin * stride_;
    columns_ = (static_cast<int>(std::ceil(last / spacing_)) + kMargin * stride_ - first_column_) / stride_ + 1;
    const std::vector<double>& b = surface.z_basis().breakpoints();
    const auto knot = [&b](std::ptrdiff_t k) {
      return b[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(k, 0, static_cast<std::ptrdiff_t>(b.size()) - 1))];
    };
    for (std::size_t j = 0; j < surface.z_basis().count(); j += static_cast<std::size_t>(stride_)) {
      const auto k = static_cast<std::ptrdiff_t>(j);
      const double z = (knot(k - 2) + knot(k - 1) + knot(k)) / 3.0;
      if (z < low_ - kMarginHeight || z > high_ + kMarginHeight) continue;
      if (heights_.empty()) first_row_ = static_cast<int>(j);
      heights_.push_back(z);
    }
    values_.resize(static_cast<Eigen::Index>(heights_.size()), columns_);
    for (int row = 0; row < rows(); ++row) {
      for (int column = 0; column < columns_; ++column)
        values_(row, column) = surface.coefficients()[Index(row, column)];
    }
  }

  [[nodiscard]] int rows() const { return static_cast<int>(heights_.size()); }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] double z(int row) const { return heights_[static_cast<std::size_t>(row)]; }
  /// mm between columns.
  [[nodiscard]] double width() const { return spacing_ * stride_ * kMeanRadius; }
  [[nodiscard]] const Eigen::MatrixXd& values() const { return values_; }
  [[nodiscard]] Eigen::Index Index(int row, int column) const {
    const int around = ((first_column_ + column * stride_) % columns_total_ + columns_total_) % columns_total_;
    return static_cast<Eigen::Index>(first_row_ + row * stride_) * columns_total_ + around;
  }
  /// rad, running on where the turn is full.
  [[nodiscard]] double Theta(int column) const { return (first_column_ + column * stride_) * spacing_; }
  /// Values of this grid at a place, linear between its nodes.
  [[nodiscard]] double At(const Eigen::MatrixXd& values, double theta, double height) const {
    const double across = std::clamp((theta - Theta(0)) / (spacing_ * stride_), 0.0, columns_ - 1.001);
    const auto column = static_cast<int>(across);
    const auto above = std::upper_bound(heights_.begin() + 1, heights_.end() - 1, height);
    const auto row = static_cast<int>(above - heights_.begin()) - 1;
    const double u = across - column;
    const double v = std::clamp((height - z(row)) / (z(row + 1) - z(row)), 0.0, 1.0);
    return (1.0 - v) * ((1.0 - u) * values(row, column) + u * values(row, column + 1)) +
           v * ((1.0 - u) * values(row + 1, column) + u * values(row + 1, column + 1));
  }
  /// Whether it may be ear.
  [[nodiscard]] bool IsInside(int row, int column) const {
    const double theta = Theta(column);
    return z(row) >= low_ && z(row) <= high_ && theta >= std::min(front_, back_) && theta <= std::max(front_, back_);
  }

 private:
  static constexpr int kMargin = 3;              // columns around that hold the fill
  static constexpr double kMarginHeight = 10.0;  // mm, the same for rows
  int stride_;                                   // every so many coefficients
  int columns_total_;
  double spacing_;
  double front_ = 0.0, back_ = 0.0;  // rad
  double low_ = 0.0, high_ = 0.0;    // mm
  int first_column_ = 0;
  int columns_ = 0;
  int first_row_ = 0;
  std::vector<double> heights_;
  Eigen::MatrixXd values_;
};

using Mask = Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic>;

/// Equations "this second difference is nothing" for a thin plate over the masked nodes; the others are known.
class ThinPlate {
 public:
  ThinPlate(const CoefficientGrid& grid, const Mask& mask) : grid_(grid) {
    unknown_.setConstant(grid.rows(), grid.columns(), -1);
    for (int row = 0; row < grid.rows(); ++row) {
      for (int column = 0; column < grid.columns(); ++column) {
        if (mask(row, column)) unknown_(row, column) = unknowns_++;
      }
    }
  }

  [[nodiscard]] Eigen::MatrixXd Fill() {
    for (int row = 0; row < grid_.rows(); ++row) {
      for (int column = 0; column < grid_.columns(); ++column) AddAt(row, column);
    }
    Eigen::MatrixXd filled = grid_.values();
    if (unknowns_ == 0) return filled;
    Eigen::SparseMatrix<double> equations(equation_count_, unknowns_);
    equations.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SparseMatrix<double> normal = equations.transpose() * equations;
    const Eigen::VectorXd right =
        equations.transpose() * Eigen::Map<const Eigen::VectorXd>(known_.data(), equation_count_);
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
    if (solver.info() != Eigen::Success) return filled;
    const Eigen::VectorXd solution = solver.solve(right);
    for (int row = 0; row < grid_.rows(); ++row) {
      for (int column = 0; column < grid_.columns(); ++column) {
        if (unknown_(row, column) >= 0) filled(row, column) = solution[unknown_(row, column)];
      }
    }
    return filled;
  }

 private:
  struct Term {
    int row;
    int column;
    double weight;
  };

  void AddAt(int row, int column) {
    const double width = grid_.width();
    const bool has_columns = column >= 1 && column + 1 < grid_.columns();
    const bool has_rows = row >= 1 && row + 1 < grid_.rows();
    if (has_columns) {
      const double w = 1.0 / (width * width);
      Add({{row, column - 1, w}, {row, column, -2.0 * w}, {row, column + 1, w}});
    }
    if (has_rows) {
      const double below = grid_.z(row) - grid_.z(row - 1);
      const double above = grid_.z(row + 1) - grid_.z(row);
      const double w = 2.0 / (below + above);
      Add({{row - 1, column, w / below}, {row, column, -w / below - w / above}, {row + 1, column, w / above}});
    }
    if (row + 1 < grid_.rows() && column + 1 < grid_.columns()) {
      const double w = std::sqrt(2.0) / (width * (grid_.z(row + 1) - grid_.z(row)));
      Add({{row, column, w}, {row, column + 1, -w}, {row + 1, column, -w}, {row + 1, column + 1, w}});
    }
  }

  void Add(const std::vector<Term>& terms) {
    const bool is_needed =
        std::any_of(terms.begin(), terms.end(), [&](const Term& t) { return unknown_(t.row, t.column) >= 0; });
    if (!is_needed) return;
    double known = 0.0;
    for (const Term& t : terms) {
      const int index = unknown_(t.row, t.column);
      if (index >= 0) entries_.emplace_back(equation_count_, index, t.weight);
      if (index < 0) known -= t.weight * grid_.values()(t.row, t.column);
    }
    known_.push_back(known);
    ++equation_count_;
  }

  const CoefficientGrid& grid_;
  Eigen::MatrixXi unknown_;
  int unknowns_ = 0;
  int equation_count_ = 0;
  std::vector<Eigen::Triplet<double>> entries_;
  std::vector<double> known_;
};

/// The nodes that stand out of a first fill, and those around them.
Mask StandingOut(const CoefficientGrid& grid, const Mask& may_be, const Eigen::MatrixXd& filled) {
  Mask mask = Mask::Constant(grid.rows(), grid.columns(), false);
  const auto reach = static_cast<int>(std::ceil(kAround / grid.width()));
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      if (!may_be(row, column) || grid.values()(row, column) - filled(row, column) < kStandsOut) continue;
      for (int r = row; r >= 0 && grid.z(row) - grid.z(r) <= kAround; --r) {
        for (int c = std::max(column - reach, 0); c <= std::min(column + reach, grid.columns() - 1); ++c)
          mask(r, c) = true;
      }
      for (int r = row; r < grid.rows() && grid.z(r) - grid.z(row) <= kAround; ++r) {
        for (int c = std::max(column - reach, 0); c <= std::min(column + reach, grid.columns() - 1); ++c)
          mask(r, c) = true;
      }
    }
  }
  // What is outside holds the fill.
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column)
      mask(row, column) = mask(row, column) && may_be(row, column);
  }
  return mask;
}

Mask MayBeEar(const CoefficientGrid& grid) {
  Mask mask = Mask::Constant(grid.rows(), grid.columns(), false);
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) mask(row, column) = grid.IsInside(row, column);
  }
  return mask;
}

void TakeOff(const SplineSurface& surface, const EarOutline& ear, Eigen::VectorXd& coefficients) {
  // A first fill over all that may be ear tells what is ear; three times as coarse, it is as good for that.
  const CoefficientGrid coarse(surface, ear, 3);
  const CoefficientGrid grid(surface, ear, 1);
  if (coarse.rows() < 5 || coarse.columns() < 5) return;
  const Eigen::MatrixXd first = ThinPlate(coarse, MayBeEar(coarse)).Fill();
  Eigen::MatrixXd guess = grid.values();
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      guess(row, column) = coarse.At(first, grid.Theta(column), grid.z(row));
    }
  }
  const Eigen::MatrixXd filled = ThinPlate(grid, StandingOut(grid, MayBeEar(grid), guess)).Fill();
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) coefficients[grid.Index(row, column)] = filled(row, column);
  }
}

SplineSurface WithoutEars(const SplineSurface& head, const std::optional<EarOutline>& right,
                          const std::optional<EarOutline>& left) {
  Eigen::VectorXd coefficients = head.coefficients();
  if (right) TakeOff(head, *right, coefficients);
  if (left) TakeOff(head, *left, coefficients);
  return {head.theta_basis(), head.z_basis(), std::move(coefficients)};
}

}  // namespace

HeadWithoutEars::HeadWithoutEars(const SplineSurface& head, const std::optional<EarOutline>& right,
                                 const std::optional<EarOutline>& left)
    : measured_(head), surface_(WithoutEars(head, right, left)) {}

Result<HeadWithoutEars> HeadWithoutEars::Find(const SplineSurface& head) {
  const auto found = FindFaceAndEars(head, HeadGrid(head, kHeadDepth));
  if (!found) return Fail(found);
  return HeadWithoutEars(head, found->ear_right, found->ear_left);
}

EarOutline WithTopOnTheHead(const EarOutline& ear, const HeadWithoutEars& head) {
  constexpr double kStepUp = 0.5;  // mm
  constexpr double kStepAround = RadiansFromDegrees(0.5);
  constexpr double kFifth = 0.2;
  constexpr double kFarthest = RadiansFromDegrees(25.0);
  const auto relief_at = [&](double turn, double z) { return head.Relief(ear.middle_theta + turn, z); };
  const auto peak = [&](double z) {
    double largest = 0.0;
    for (double turn = -kFarthest; turn <= kFarthest; turn += kStepAround)
      largest = std::max(largest, relief_at(turn, z));
    return largest;
  };
  const double low = std::max(ear.bottom_z, head.measured().z_min());
  const double high = std::min(ear.top_z + kAboveTop, head.measured().z_max());
  double height = 0.0;
  double height_z = low;
  for (double z = low; z <= high; z += kStepUp) {
    const double here = peak(z);
    if (here <= height) continue;
    height = here;
    height_z = z;
  }
  const double edge = kFifth * height;
  double z = height_z;
  double above = height;
  double below = height;
  while (z + kStepUp <= high && above >= edge) {
    z += kStepUp;
    below = above;
    above = peak(z);
  }
  if (above >= edge) return ear;  // it does not end below the scan's top
  z -= kStepUp * std::clamp((edge - above) / std::max(below - above, 1e-9), 0.0, 1.0);
  double weight = 0.0;
  double turns = 0.0;
  for (double turn = -kFarthest; turn <= kFarthest; turn += kStepAround) {
    const double w = std::max(relief_at(turn, z) - 0.5 * edge, 0.0);
    weight += w;
    turns += w * turn;
  }
  if (weight <= 0.0) return ear;
  EarOutline exact = ear;
  exact.height = height;
  exact.top_z = z;
  exact.top_theta = ear.middle_theta + turns / weight;
  exact.top_radius = head.measured().Radius(exact.top_theta, z);
  return exact;
}

}  // namespace annulus
