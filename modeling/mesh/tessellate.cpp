#include "modeling/mesh/tessellate.h"

#include <cmath>
#include <limits>
#include <vector>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus {
namespace {

constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

// The grid of a surface: corner (i, j) at column i, row j; cells between corners.
class Grid {
 public:
  Grid(const SurfaceSegment& segment, const TessellationOptions& options)
      : segment_(segment), surface_(segment.surface), columns_(options.theta_count) {
    const double height = surface_.z_max() - surface_.z_min();
    rows_ = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(height / options.max_z_spacing_mm)));
    known_.assign(columns_ * (rows_ + 1), 1);
    numbers_.assign(columns_ * (rows_ + 1), kUnused);
    if (!options.skip_unknown || segment.knowledge.columns() == 0) return;
    for (std::size_t j = 0; j <= rows_; ++j) {
      for (std::size_t i = 0; i < columns_; ++i) {
        known_[Corner(i, j)] = segment.knowledge.At(Theta(i), Height(j)) != Knowledge::kUnknown ? 1 : 0;
      }
    }
  }

  [[nodiscard]] bool Keeps(std::size_t i, std::size_t j) const {
    return known_[Corner(i, j)] != 0 && known_[Corner(i + 1, j)] != 0 && known_[Corner(i, j + 1)] != 0 &&
           known_[Corner(i + 1, j + 1)] != 0;
  }
  [[nodiscard]] bool KeepsRow(std::size_t j) const {
    for (std::size_t i = 0; i < columns_; ++i) {
      if (!Keeps(i, j)) return false;
    }
    return true;
  }

  TriangleMesh AddCells() {
    TriangleMesh mesh;
    for (std::size_t j = 0; j < rows_; ++j) {
      for (std::size_t i = 0; i < columns_; ++i) {
        if (!Keeps(i, j)) continue;
        const std::uint32_t a = Number(i, j, mesh);
        const std::uint32_t b = Number(i + 1, j, mesh);
        const std::uint32_t c = Number(i + 1, j + 1, mesh);
        const std::uint32_t d = Number(i, j + 1, mesh);
        mesh.faces.push_back({a, b, c});
        mesh.faces.push_back({a, c, d});
      }
    }
    return mesh;
  }

  // A fan about the rim's centroid. `row` is the rim, 0 or rows().
  void AddFan(std::size_t row, TriangleMesh& mesh) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < columns_; ++i) centre += mesh.vertices[Number(i, row, mesh)];
    centre /= static_cast<double>(columns_);
    const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(centre);
    for (std::size_t i = 0; i < columns_; ++i) {
      const std::uint32_t a = Number(i, row, mesh);
      const std::uint32_t b = Number(i + 1, row, mesh);
      if (row == 0) {
        mesh.faces.push_back({middle, b, a});
      } else {
        mesh.faces.push_back({middle, a, b});
      }
    }
  }

  [[nodiscard]] std::size_t rows() const { return rows_; }

 private:
  [[nodiscard]] std::size_t Corner(std::size_t i, std::size_t j) const { return j * columns_ + i % columns_; }
  [[nodiscard]] double Theta(std::size_t i) const {
    return kTwoPi * static_cast<double>(i % columns_) / static_cast<double>(columns_);
  }
  [[nodiscard]] double Height(std::size_t j) const {
    if (j == rows_) return surface_.z_max();
    return surface_.z_min() +
           (surface_.z_max() - surface_.z_min()) * static_cast<double>(j) / static_cast<double>(rows_);
  }
  std::uint32_t Number(std::size_t i, std::size_t j, TriangleMesh& mesh) {
    std::uint32_t& number = numbers_[Corner(i, j)];
    if (number == kUnused) {
      number = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(segment_.Point(Theta(i), Height(j)));
    }
    return number;
  }

  const SurfaceSegment& segment_;  // the caller's
  const SplineSurface& surface_;   // its surface
  std::size_t columns_;
  std::size_t rows_ = 0;
  std::vector<char> known_;
  std::vector<std::uint32_t> numbers_;
};

}  // namespace

TriangleMesh TessellateSurface(const SurfaceSegment& segment, const TessellationOptions& options) {
  ENSURE(options.theta_count >= 3 && options.max_z_spacing_mm > 0.0, "a grid has cells");
  Grid grid(segment, options);
  TriangleMesh mesh = grid.AddCells();
  const bool below = options.ends == EndClosure::kBelow || options.ends == EndClosure::kBoth;
  const bool above = options.ends == EndClosure::kAbove || options.ends == EndClosure::kBoth;
  if (below && grid.KeepsRow(0)) grid.AddFan(0, mesh);
  if (above && grid.KeepsRow(grid.rows() - 1)) grid.AddFan(grid.rows(), mesh);
  return mesh;
}

}  // namespace annulus
