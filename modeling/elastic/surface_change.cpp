#include "modeling/elastic/surface_change.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/ensure.h"
#include "fitting/spline_transfer.h"

namespace annulus {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr const char* kAttempted = "write the changed shape back as a surface";
constexpr int kPlaces = 4;  ///< Each way, per piece.
constexpr int kChecks = 3;  ///< Each way, per piece, between the places.
constexpr int kMostTurns = 80;

/// Where a leaf lies.
struct Extent {
  double theta, z, width, height;
};

Extent ExtentOf(const HierarchicalSpline& spline, const SplineLeaf& leaf) {
  const SplineLevel& level = spline.levels()[leaf.level];
  const double width = level.theta.spacing();
  const double z = level.z.breakpoints()[leaf.z_cell];
  return {leaf.theta_cell * width, z, width, level.z.breakpoints()[leaf.z_cell + 1] - z};
}

bool Meets(const ThetaZBox& box, const Extent& leaf) {
  if (!(leaf.z < box.z_max && leaf.z + leaf.height > box.z_min)) return false;
  const double turn = box.theta_to - box.theta_from;
  if (turn >= kTwoPi - leaf.width) return true;
  return WrapAngle(leaf.theta - box.theta_from) < turn || WrapAngle(box.theta_from - leaf.theta) < leaf.width;
}

/// Least squares for the changes of the chosen control points.
class GrowthFit {
 public:
  GrowthFit(const HierarchicalSpline& spline, const ThetaZBox& box) : spline_(spline), number_(spline.size(), -1) {
    for (const SplineLeaf& leaf : spline.leaves()) {
      if (!Meets(box, ExtentOf(spline, leaf))) continue;
      for (const std::uint32_t c : spline.Active(leaf)) {
        if (number_[c] < 0) number_[c] = count_++;
      }
    }
    right_ = Eigen::VectorXd::Zero(count_);
  }

  [[nodiscard]] int count() const { return count_; }

  Status Collect(const RadiusGrowth& growth) {
    for (const SplineLeaf& leaf : spline_.leaves()) {
      const auto active = spline_.Active(leaf);
      if (std::none_of(active.begin(), active.end(), [&](std::uint32_t c) { return number_[c] >= 0; })) continue;
      leaves_.push_back(&leaf);
      RETURN_IF_ERROR(AddLeaf(leaf, growth));
    }
    return {};
  }

  /// Changes of all active coefficients.
  Result<Eigen::VectorXd> Solve() {
    Eigen::SparseMatrix<double> matrix(count_, count_);
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    const double ridge = 1e-10 * Eigen::VectorXd(matrix.diagonal()).maxCoeff();
    for (Index k = 0; k < count_; ++k) matrix.coeffRef(k, k) += ridge;
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor(matrix);
    if (factor.info() != Eigen::Success) {
      return Fail(kAttempted, "its equations have no solution", "make the region larger than the knots' spacing");
    }
    const Eigen::VectorXd solved = factor.solve(right_);
    Eigen::VectorXd change = Eigen::VectorXd::Zero(static_cast<Index>(number_.size()));
    for (std::size_t c = 0; c < number_.size(); ++c) {
      if (number_[c] >= 0) change[static_cast<Index>(c)] = solved[number_[c]];
    }
    return change;
  }

  /// Errors between the places, into `result`.
  Status Check(const Eigen::VectorXd& change, const RadiusGrowth& growth, ChangedSegment& result) const {
    result.piece_distance.assign(spline_.leaves().size(), 0.0);
    double squares = 0.0;
    std::size_t checks = 0;
    for (const SplineLeaf* leaf : leaves_) {
      const Extent extent = ExtentOf(spline_, *leaf);
      for (int n = 0; n < kChecks * kChecks; ++n) {
        const double theta = extent.theta + extent.width * (n % kChecks + 0.5) / kChecks;
        const double z = extent.z + extent.height * (n / kChecks + 0.5) / kChecks;
        const auto wanted = growth(theta, z);
        if (!wanted) return Unknown(z);
        double got = 0.0;
        for (const CoefficientWeight& entry : spline_.ActiveRow(theta, z)) {
          got += entry.weight * change[static_cast<Index>(entry.index)];
        }
        const double error = got - *wanted;
        result.largest_error = std::max(result.largest_error, std::abs(error));
        double& distance = result.piece_distance[static_cast<std::size_t>(leaf - spline_.leaves().data())];
        if (error != 0.0) distance = std::max(distance, std::abs(error) * Outwards(result.segment, theta, z));
        result.largest_growth = std::max(result.largest_growth, std::abs(*wanted));
        squares += error * error;
        ++checks;
      }
    }
    if (checks > 0) result.rms_error = std::sqrt(squares / static_cast<double>(checks));
    return {};
  }

 private:
  /// The radial part of the surface's normal.
  static double Outwards(const SurfaceSegment& segment, double theta, double z) {
    return std::abs(SegmentNormal(segment, theta, z).dot(Vector3d(std::cos(theta), std::sin(theta), 0.0)));
  }

  static tl::unexpected<Error> Unknown(double z) {
    return Fail(kAttempted, "at z " + std::to_string(z) + " mm the changed skin has more than one radius or none",
                "make a smaller change");
  }

  Status AddLeaf(const SplineLeaf& leaf, const RadiusGrowth& growth) {
    const Extent extent = ExtentOf(spline_, leaf);
    const auto active = spline_.Active(leaf);
    const auto size = static_cast<Index>(active.size());
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(size, kPlaces * kPlaces);
    Eigen::VectorXd wanted(kPlaces * kPlaces);
    for (int n = 0; n < kPlaces * kPlaces; ++n) {
      const double theta = extent.theta + extent.width * (n % kPlaces + 0.5) / kPlaces;
      const double z = extent.z + extent.height * (n / kPlaces + 0.5) / kPlaces;
      const auto value = growth(theta, z);
      if (!value) return Unknown(z);
      wanted[n] = *value;
      for (const CoefficientWeight& entry : spline_.ActiveRow(theta, z)) {
        const auto at = std::find(active.begin(), active.end(), static_cast<std::uint32_t>(entry.index));
        ENSURE(at != active.end(), "a place depends on the coefficients of its leaf");
        rows(at - active.begin(), n) = entry.weight;
      }
    }
    const double area = extent.width * extent.height;
    const Eigen::MatrixXd form = area * rows * rows.transpose();
    const Eigen::VectorXd load = area * rows * wanted;
    for (Index b = 0; b < size; ++b) {
      const int column = number_[active[static_cast<std::size_t>(b)]];
      if (column < 0) continue;
      right_[column] += load[b];
      for (Index a = 0; a < size; ++a) {
        const int row = number_[active[static_cast<std::size_t>(a)]];
        if (row >= column) entries_.emplace_back(row, column, form(a, b));
      }
    }
    return {};
  }

  const HierarchicalSpline& spline_;
  std::vector<int> number_;  ///< By active coefficient; -1: stays.
  int count_ = 0;
  std::vector<const SplineLeaf*> leaves_;
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::VectorXd right_;
};

/// Cubic Hermite weights of the values at 0 and 1 and of the slopes there.
std::array<double, 4> HermiteWeights(double t) {
  const double s = 1.0 - t;
  return {s * s * (1.0 + 2.0 * t), t * t * (1.0 + 2.0 * s), t * s * s, -t * t * s};
}

/// Catmull–Rom weights of four values at -1, 0, 1, 2; slopes are 0 where `still` says so (the rim).
std::array<double, 4> NodeWeights(double t, bool still_from, bool still_to) {
  const std::array<double, 4> h = HermiteWeights(t);
  const double from = still_from ? 0.0 : 0.5 * h[2];
  const double to = still_to ? 0.0 : 0.5 * h[3];
  return {-from, h[0] - to, h[1] + from, to};
}

}  // namespace

Result<ChangedSegment> GrowRadius(const SurfaceSegment& segment, const ThetaZBox& box, const RadiusGrowth& growth) {
  const ControlledSurface controlled = ControlledBy(segment);
  GrowthFit fit(*controlled.spline, box);
  if (fit.count() == 0) {
    return Fail(kAttempted, "the change lies outside the segment", "give a place on the segment");
  }
  RETURN_IF_ERROR(fit.Collect(growth));
  const auto change = fit.Solve();
  if (!change) return Fail(change);
  const Eigen::VectorXd active = controlled.active + *change;
  ChangedSegment result{segment, 0.0, 0.0, 0.0, static_cast<std::size_t>(fit.count()), {}};
  RETURN_IF_ERROR(fit.Check(*change, growth, result));
  result.segment.surface = controlled.spline->Surface(active);
  if (segment.hierarchy != nullptr) result.segment.active = active;
  result.segment.paper = nullptr;
  for (const SplineLeaf& leaf : controlled.spline->leaves()) {
    const Extent extent = ExtentOf(*controlled.spline, leaf);
    const double theta = extent.theta + 0.5 * extent.width;
    const double z = extent.z + 0.5 * extent.height;
    if (!(segment.surface.Radius(theta, z) > 0.0) || result.segment.surface.Radius(theta, z) > 0.0) continue;
    return Fail(kAttempted, "at z " + std::to_string(z) + " mm the radius would not be positive", "push in less");
  }
  return result;
}

DisplacedSkin::DisplacedSkin(const SurfaceSegment& segment, const ElasticRegion& region,
                             const std::vector<Vector3d>& displacement)
    : segment_(segment), region_(region), displacement_(displacement) {
  ENSURE(displacement.size() == region.grid.shape.stacks(), "one displacement per stack");
}

Vector3d DisplacedSkin::At(std::ptrdiff_t column, std::ptrdiff_t row) const {
  const auto columns = static_cast<std::ptrdiff_t>(region_.grid.shape.columns);
  const auto rows = static_cast<std::ptrdiff_t>(region_.grid.shape.rows);
  if (region_.grid.shape.closure == GridClosure::kClosed) column = (column + columns) % columns;
  if (column < 0 || column >= columns || row < 0 || row >= rows) return Vector3d::Zero();
  return displacement_[static_cast<std::size_t>(row * columns + column)];
}

Vector3d DisplacedSkin::Displacement(double theta, double z) const {
  const GridShape& shape = region_.grid.shape;
  const bool closed = shape.closure == GridClosure::kClosed;
  const double across = WrapAngle(theta - region_.theta.front()) / (region_.theta[1] - region_.theta[0]);
  const double up = (z - region_.z.front()) / (region_.z[1] - region_.z[0]);
  const auto cells_around = static_cast<double>(shape.cells_around());
  const auto cells_up = static_cast<double>(shape.rows - 1);
  if (up < 0.0 || up > cells_up || (!closed && across > cells_around)) return Vector3d::Zero();
  const double column = std::min(std::floor(across), cells_around - 1.0);
  const double row = std::min(std::floor(up), cells_up - 1.0);
  const auto by_column =
      NodeWeights(across - column, !closed && column == 0.0, !closed && column == cells_around - 1.0);
  const auto by_row = NodeWeights(up - row, row == 0.0, row == cells_up - 1.0);
  Vector3d sum = Vector3d::Zero();
  for (std::ptrdiff_t j = 0; j < 4; ++j) {
    for (std::ptrdiff_t i = 0; i < 4; ++i) {
      sum += by_row[static_cast<std::size_t>(j)] * by_column[static_cast<std::size_t>(i)] *
             At(static_cast<std::ptrdiff_t>(column) + i - 1, static_cast<std::ptrdiff_t>(row) + j - 1);
    }
  }
  return sum;
}

std::optional<double> DisplacedSkin::Growth(double theta, double z) const {
  double from_theta = theta;
  double from_z = z;
  for (int n = 0; n < kMostTurns; ++n) {
    Vector3d point = segment_.Point(from_theta, from_z) + Displacement(from_theta, from_z);
    point.head<2>() -= segment_.axis.At(point.z());
    const double theta_off = AngleDifference(theta, std::atan2(point.y(), point.x()));
    const double z_off = z - point.z();
    const double radius = point.head<2>().norm();
    if (std::abs(theta_off) * radius < 1e-10 && std::abs(z_off) < 1e-10) {
      return radius - segment_.surface.Radius(theta, z);
    }
    from_theta += theta_off;
    from_z += z_off;
    if (std::abs(from_z - z) > 1e3) break;
  }
  return std::nullopt;
}

}  // namespace annulus
