#include "modeling/clay/clay_shapes.h"

#include <Eigen/Core>

#include "base/ensure.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// A flat face from `corner` along two sides, in columns × rows patches; its normal is along_u × along_v.
void AppendFace(const Vector3d& corner, const Vector3d& along_u, const Vector3d& along_v, std::size_t columns,
                std::size_t rows, PatchShell& shell) {
  const auto point = [&](std::size_t i, std::size_t j) -> Vector3d {
    return corner + along_u * (static_cast<double>(i) / static_cast<double>(3 * columns)) +
           along_v * (static_cast<double>(j) / static_cast<double>(3 * rows));
  };
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      BezierPatch::ControlNet net;
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) net[i][j] = point(3 * column + i, 3 * row + j);
      }
      shell.patches.push_back({BezierPatch(net), PatchDetail::kAlong, PatchDetail::kAlong});
    }
  }
}

}  // namespace

PatchShell ClayBlock(double size, double height, std::size_t count, std::size_t layers) {
  ENSURE(size > 0.0 && height > 0.0 && count >= 1 && layers >= 1, "a block has a size");
  PatchShell shell{"block", {}};
  const double half = 0.5 * size;
  const Vector3d x(size, 0.0, 0.0);
  const Vector3d y(0.0, size, 0.0);
  const Vector3d up(0.0, 0.0, height);
  AppendFace({-half, -half, 0.0}, x, y, count, count, shell);        // top
  AppendFace({-half, -half, -height}, y, x, count, count, shell);    // bottom
  AppendFace({-half, -half, -height}, x, up, count, layers, shell);  // y = -half
  AppendFace({half, -half, -height}, y, up, count, layers, shell);
  AppendFace({half, half, -height}, -x, up, count, layers, shell);
  AppendFace({-half, half, -height}, -y, up, count, layers, shell);
  return shell;
}

}  // namespace annulus
