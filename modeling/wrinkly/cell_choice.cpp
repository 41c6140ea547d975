#include "modeling/wrinkly/cell_choice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "modeling/wrinkly/control_nets.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Down to this depth a cell's size is looked for at its corners too; below, cells are nearly parallelograms.
constexpr int kCurvedDepth = 2;
/// Digits beyond these change a dither value by less than 1 in 1e4.
constexpr int kDitherDigits = 4;

/// A cell as it lies in space.
struct CellSize {
  Vector3d middle = Vector3d::Zero();
  Vector3d normal = Vector3d::UnitZ();
  double side_a = 0.0;  ///< Longest of either kind of side, mm.
  double side_b = 0.0;
};

class ScreenChooser {
 public:
  ScreenChooser(const PatchGrid& grid, const SamplingOptions& options)
      : grid_(grid),
        view_(*options.view),
        limit_(options.triangle_px),
        most_iterations_(options.iterations.value_or(grid.surface().most_iterations())),
        half_width_(view_.half_height * view_.width / view_.height),
        pixels_(view_.height / (2.0 * view_.half_height)) {}

  CellChoice operator()(const GridCell& cell) const {
    const CellSize size = SizeOf(cell);
    const Vector3d middle = view_.camera_from_station * (size.middle - view_.eye_in_station);
    if (!IsSeen(cell, size, middle)) return {CellChoice::Kind::kGone, 0.0F};
    const double pixels = std::max(size.side_a, size.side_b) * Scale(middle.z());
    const auto cut = cell.depth < grid_.finest() ? grid_.Cut(cell.depth) : std::array<std::uint32_t, 2>{1, 1};
    if (cell.depth < grid_.finest() && IsCut(cell, cut, pixels / limit_)) return {CellChoice::Kind::kCut, 0.0F};
    const double radix = std::max({cut[0], cut[1], 2U});
    const double iterations = cell.depth + std::log(pixels / limit_) / std::log(radix);
    return {CellChoice::Kind::kKept,
            static_cast<float>(std::clamp(iterations, 0.0, std::min<double>(most_iterations_, cell.depth)))};
  }

 private:
  [[nodiscard]] CellSize SizeOf(const GridCell& cell) const {
    const auto& parts = grid_.Parts(cell.depth);
    const BaseSurface& base = grid_.surface().base();
    const auto at = [&](double a, double b) {
      const auto uv = grid_.Parameters(cell, a, b);
      return base.At(cell.patch, uv[0], uv[1]);
    };
    const PatchPoint middle = at(0.5, 0.5);
    CellSize size{middle.point, base.NormalAt(cell.patch, middle), middle.du.norm(), middle.dv.norm()};
    if (cell.depth <= kCurvedDepth) {
      for (const double a : {0.0, 1.0}) {
        for (const double b : {0.0, 1.0}) {
          const PatchPoint corner = at(a, b);
          size.side_a = std::max(size.side_a, corner.du.norm());
          size.side_b = std::max(size.side_b, corner.dv.norm());
        }
      }
    }
    size.side_a /= parts[0];
    size.side_b /= parts[1];
    return size;
  }

  /// Pixels per mm at a depth.
  [[nodiscard]] double Scale(double depth) const {
    return view_.projection == ScreenView::Projection::kParallel ? pixels_ : pixels_ / std::max(depth, view_.near_mm);
  }

  /// Whether a cell may be in the picture, wherever its heights put it along the normal.
  [[nodiscard]] bool IsSeen(const GridCell& cell, const CellSize& size, const Vector3d& middle) const {
    const double low = grid_.surface().lowest_height();
    const double high = grid_.surface().highest_height();
    const double sides = size.side_a + size.side_b;
    if (cell.depth <= kCurvedDepth) return MayBeIn({middle, middle}, sides + std::max(high, -low));
    // Half of the diagonal, and as much again for normals that spread over the cell.
    const Vector3d normal = view_.camera_from_station * size.normal;
    return MayBeIn({middle + low * normal, middle + high * normal}, 1.2 * sides);
  }

  /// Whether what is within `radius` of a line may be in the picture: not if both of its ends are beyond one border.
  [[nodiscard]] bool MayBeIn(const std::array<Vector3d, 2>& ends, double radius) const {
    const bool parallel = view_.projection == ScreenView::Projection::kParallel;
    const auto beyond = [&](auto&& distance) { return distance(ends[0]) > radius && distance(ends[1]) > radius; };
    if (beyond([&](const Vector3d& p) { return view_.near_mm - p.z(); })) return false;
    for (const double side : {1.0, -1.0}) {
      for (const Eigen::Index axis : {0, 1}) {
        const double half = axis == 0 ? half_width_ : view_.half_height;
        if (beyond([&](const Vector3d& p) {
              return parallel ? side * p[axis] - half : (side * p[axis] - half * p.z()) / std::sqrt(1.0 + half * half);
            })) {
          return false;
        }
      }
    }
    return true;
  }

  [[nodiscard]] bool IsCut(const GridCell& cell, std::array<std::uint32_t, 2> cut, double size) const {
    if (size > 1.0) return true;
    const double radix = std::max(cut[0], cut[1]);
    if (size * radix <= 1.0) return false;
    const double parts = static_cast<double>(cut[0]) * cut[1];
    const double share = (radix * radix * size * size - 1.0) / (radix * radix - 1.0);
    return parts > 1.0 && Dither(cell) < share;
  }

  /// 0 … 1, evenly spread over the cells of any larger cell.
  [[nodiscard]] double Dither(const GridCell& cell) const {
    double value = ScatteredNumber(static_cast<std::uint64_t>(cell.patch), static_cast<std::uint64_t>(cell.depth));
    double weight = 1.0;
    std::uint32_t a = cell.a;
    std::uint32_t b = cell.b;
    for (int depth = cell.depth; depth > std::max(0, cell.depth - kDitherDigits); --depth) {
      const auto cut = grid_.Cut(depth - 1);
      const std::uint32_t parts = cut[0] * cut[1];
      // A step near the golden section, without a common divisor, visits all parts far from one another.
      auto step = static_cast<std::uint32_t>(0.618 * parts);
      while (std::gcd(step, parts) != 1U) ++step;
      weight /= parts;
      value += weight * ((a % cut[0] * cut[1] + b % cut[1]) * step % parts);
      a /= cut[0];
      b /= cut[1];
    }
    return value - std::floor(value);
  }

  const PatchGrid& grid_;
  ScreenView view_;
  double limit_;
  double most_iterations_;
  double half_width_;
  double pixels_;
};

}  // namespace

CellTrees::Choose EvenCells(double iterations, int depth) {
  return [iterations, depth](const GridCell& cell) {
    const auto kind = cell.depth < depth ? CellChoice::Kind::kCut : CellChoice::Kind::kKept;
    return CellChoice{kind, static_cast<float>(iterations)};
  };
}

CellTrees::Choose CellsOnScreen(const PatchGrid& grid, const SamplingOptions& options) {
  return ScreenChooser(grid, options);
}

}  // namespace annulus
