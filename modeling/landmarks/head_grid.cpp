#include "modeling/landmarks/head_grid.h"

#include <algorithm>
#include <cmath>

#include "base/frames.h"

namespace annulus {
namespace {

/// A section of larger mean radius than this is no head's, mm: that is a girth of 820 mm, hair included.
constexpr double kWidestHead = 130.0;
/// How far a nose stands out between points 15 degrees to either side, mm; less is no nose.
constexpr double kLeastNose = 4.0;

}  // namespace

HeadGrid::HeadGrid(const SplineSurface& head, double depth)
    : top_(head.z_max()), rows_(static_cast<int>(std::floor(std::min(depth, head.z_max() - head.z_min()))) + 1) {
  const PeriodicCubicBasis& around = head.theta_basis();
  std::vector<CubicBasis> columns;
  for (int degree = 0; degree < kFullCircle; ++degree) columns.push_back(around.At(RadiansFromDegrees(degree)));
  const auto width = static_cast<Eigen::Index>(around.count());
  radius_.reserve(static_cast<std::size_t>(rows_) * kFullCircle);
  for (int row = 0; row < rows_; ++row) {
    // The row's own spline in theta first: four products a node instead of sixteen.
    const CubicBasis up = head.z_basis().At(z(row));
    Eigen::VectorXd ring = Eigen::VectorXd::Zero(width);
    for (std::size_t k = 0; k < 4; ++k) {
      ring += up.value[k] * head.coefficients().segment(static_cast<Eigen::Index>(up.index[k]) * width, width);
    }
    for (const CubicBasis& column : columns) {
      double r = 0.0;
      for (std::size_t k = 0; k < 4; ++k) r += column.value[k] * ring[static_cast<Eigen::Index>(column.index[k])];
      radius_.push_back(std::max(r, 0.0));
    }
  }
}

int HeadGrid::RowAt(double z) const { return std::clamp(static_cast<int>(std::lround(top_ - z)), 0, rows_ - 1); }

double HeadGrid::r(int degree, int row) const {
  const int column = ((degree % kFullCircle) + kFullCircle) % kFullCircle;
  return radius_[static_cast<std::size_t>(std::clamp(row, 0, rows_ - 1) * kFullCircle + column)];
}

double HeadGrid::Radius(double theta, double z) const {
  const double degrees = DegreesFromRadians(WrapAngle(theta));
  const double depth = std::clamp(top_ - z, 0.0, static_cast<double>(rows_ - 1));
  const double column = std::floor(degrees);
  const double row = std::floor(depth);
  const auto c = static_cast<int>(column);
  const auto k = static_cast<int>(row);
  const double u = degrees - column;
  const double v = depth - row;
  return (1.0 - v) * ((1.0 - u) * r(c, k) + u * r(c + 1, k)) + v * ((1.0 - u) * r(c, k + 1) + u * r(c + 1, k + 1));
}

Eigen::Vector3d HeadGrid::Point(int degree, int row) const {
  return PointFromCylindrical(RadiansFromDegrees(degree), r(degree, row), z(row));
}

double HeadGrid::MeanRadius(int row) const {
  double sum = 0.0;
  for (int degree = 0; degree < kFullCircle; ++degree) sum += r(degree, row);
  return sum / kFullCircle;
}

int NeckRow(const HeadGrid& grid) {
  int neck = std::min(grid.rows() - 1, static_cast<int>(kLeastHead));
  double least = grid.MeanRadius(neck);
  for (int row = neck; row < grid.rows(); ++row) {
    const double mean = grid.MeanRadius(row);
    if (mean >= least) continue;
    least = mean;
    neck = row;
  }
  return neck;
}

std::optional<GridPlace> FindNose(const HeadGrid& grid, int neck) {
  const auto prominence = [&grid](int degree, int row) {
    return grid.r(degree, row) - 0.5 * (grid.r(degree - 15, row) + grid.r(degree + 15, row));
  };
  GridPlace best{90, 0};
  double best_score = 0.0;
  for (int row = static_cast<int>(kNoseHighest); row <= std::min(neck, static_cast<int>(kNoseLowest)); ++row) {
    for (int degree = 55; degree <= 125; ++degree) {
      const double score = grid.Point(degree, row).y() + prominence(degree, row);
      if (score > best_score) {
        best = {degree, row};
        best_score = score;
      }
    }
  }
  if (best_score == 0.0 || grid.MeanRadius(best.row) > kWidestHead) return std::nullopt;
  if (prominence(best.degree, best.row) < kLeastNose) return std::nullopt;
  return best;
}

}  // namespace annulus
