#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace annulus {

/// Whether the last column of a grid adjoins the first.
enum class GridClosure { kOpen, kClosed };

/// How many nodes a grid of hexahedra has each way: `columns` around, `rows` upwards, `layers` from the inside to the
/// skin.
struct GridShape {
  std::size_t columns = 2;  ///< >= 2; closed: >= 3.
  std::size_t rows = 2;     ///< >= 2
  std::size_t layers = 2;   ///< >= 2
  GridClosure closure = GridClosure::kOpen;

  /// Nodes that lie over each other are a stack; stacks are numbered row by row.
  [[nodiscard]] std::size_t stacks() const { return columns * rows; }
  [[nodiscard]] std::size_t cells_around() const { return closure == GridClosure::kClosed ? columns : columns - 1; }
  /// Elements over each other are a pile; piles are numbered row by row.
  [[nodiscard]] std::size_t piles() const { return cells_around() * (rows - 1); }
  [[nodiscard]] std::size_t elements() const { return piles() * (layers - 1); }
  [[nodiscard]] std::size_t nodes() const { return stacks() * layers; }
  /// The four stacks around a pile: lower left, lower right, upper left, upper right.
  [[nodiscard]] std::array<std::size_t, 4> StacksOf(std::size_t pile) const {
    const std::size_t i = pile % cells_around();
    const std::size_t j = pile / cells_around();
    const std::size_t right = (i + 1) % columns;
    return {j * columns + i, j * columns + right, (j + 1) * columns + i, (j + 1) * columns + right};
  }
};

/// Corners of a hexahedron, mm: corner a + 2b + 4c is at (a, b, c) along column, row and layer.
using HexCorners = Eigen::Matrix<double, 3, 8>;

/// Hexahedra in columns, rows and layers. Node (column i, row j, layer k) is at (j·columns + i)·layers + k; element
/// `level` of a pile lies between layers `level` and `level` + 1. Columns, rows and layers are right-handed in this
/// order.
struct SolidGrid {
  GridShape shape;
  std::vector<Eigen::Vector3d> nodes;  ///< mm

  [[nodiscard]] std::size_t Node(std::size_t column, std::size_t row, std::size_t layer) const {
    return (row * shape.columns + column) * shape.layers + layer;
  }
  [[nodiscard]] std::array<std::size_t, 8> NodesOf(std::size_t pile, std::size_t level) const {
    std::array<std::size_t, 8> corner{};
    const std::array<std::size_t, 4> stack = shape.StacksOf(pile);
    for (std::size_t n = 0; n < 8; ++n) corner[n] = stack[n % 4] * shape.layers + level + n / 4;
    return corner;
  }
};

}  // namespace annulus
