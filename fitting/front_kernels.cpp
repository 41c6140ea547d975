#include "fitting/front_kernels.h"

#include <cmath>
#include <cstring>

namespace annulus {
namespace {

/// Columns that are updated together: with eight rows they fill the registers of a 256-bit vector unit.
constexpr std::size_t kTile = 6;

/// A block of a column-major matrix.
struct Block {
  double* data = nullptr;
  std::size_t stride = 0;
};

template <int Bytes>
struct LaneType {
  using Type __attribute__((vector_size(Bytes), aligned(8), may_alias)) = double;
};

/// target(r, c) −= Σ_k left(r, k)·right(c, k) for `Columns` columns and rows 0 … rows − 1, in steps of the lanes.
template <int Bytes, std::size_t Columns>
[[gnu::always_inline]] inline void SubtractTile(const Block& target, const Block& left, const Block& right,
                                                std::size_t rows, std::size_t depth) {
  using Lanes = typename LaneType<Bytes>::Type;
  constexpr std::size_t kStep = Bytes / sizeof(double);
  for (std::size_t r = 0; r < rows; r += kStep) {
    Lanes sum[Columns];
    for (std::size_t c = 0; c < Columns; ++c)
      sum[c] = *reinterpret_cast<const Lanes*>(target.data + c * target.stride + r);
    const double* l = left.data + r;
    const double* b = right.data;
    for (std::size_t k = 0; k < depth; ++k, l += left.stride, b += right.stride) {
      const Lanes column = *reinterpret_cast<const Lanes*>(l);
      for (std::size_t c = 0; c < Columns; ++c) sum[c] -= column * b[c];
    }
    for (std::size_t c = 0; c < Columns; ++c) *reinterpret_cast<Lanes*>(target.data + c * target.stride + r) = sum[c];
  }
}

template <int Bytes>
[[gnu::always_inline]] inline void SubtractColumns(const Block& target, const Block& left, const Block& right,
                                                   std::size_t rows, std::size_t depth, std::size_t columns) {
  switch (columns) {
    case 1:
      return SubtractTile<Bytes, 1>(target, left, right, rows, depth);
    case 2:
      return SubtractTile<Bytes, 2>(target, left, right, rows, depth);
    case 3:
      return SubtractTile<Bytes, 3>(target, left, right, rows, depth);
    case 4:
      return SubtractTile<Bytes, 4>(target, left, right, rows, depth);
    case 5:
      return SubtractTile<Bytes, 5>(target, left, right, rows, depth);
    default:
      return SubtractTile<Bytes, 6>(target, left, right, rows, depth);
  }
}

template <int Bytes>
[[gnu::always_inline]] inline bool Eliminate(const Block& panel, std::size_t rows, std::size_t own, const Block& rest) {
  for (std::size_t first = 0; first < own; first += kTile) {
    const std::size_t columns = first + kTile <= own ? kTile : own - first;
    // All earlier columns act on this tile at once (left-looking), then the tile's columns on each other.
    const Block tile{panel.data + first * panel.stride + first, panel.stride};
    SubtractColumns<Bytes>(tile, {panel.data + first, panel.stride}, {panel.data + first, panel.stride}, rows - first,
                           first, columns);
    for (std::size_t c = 0; c < columns; ++c) {
      double* column = tile.data + c * tile.stride + c;
      const std::size_t length = rows - first - c;
      if (c > 0) {
        SubtractTile<Bytes, 1>({column, tile.stride}, {tile.data + c, tile.stride}, {tile.data + c, tile.stride},
                               length, c);
      }
      if (!(column[0] > 0.0)) return false;
      const double root = std::sqrt(column[0]);
      const double scale = 1.0 / root;
      column[0] = root;
      for (std::size_t r = 1; r < length; ++r) column[r] *= scale;
    }
  }
  const std::size_t left = rows - own;
  for (std::size_t first = 0; first < left; first += kTile) {
    const std::size_t columns = first + kTile <= left ? kTile : left - first;
    const Block below{panel.data + own + first, panel.stride};
    SubtractColumns<Bytes>({rest.data + first * rest.stride + first, rest.stride}, below, below, left - first, own,
                           columns);
  }
  return true;
}

#if defined(__x86_64__)
// Multiplication and subtraction stay separate (-ffp-contract=off), so that wider units give the same bits.
[[gnu::target("avx512f,avx512vl,avx512dq")]] bool EliminateWidest(const Block& panel, std::size_t rows, std::size_t own,
                                                                  const Block& rest) {
  return Eliminate<64>(panel, rows, own, rest);
}
[[gnu::target("avx2")]] bool EliminateWide(const Block& panel, std::size_t rows, std::size_t own, const Block& rest) {
  return Eliminate<64>(panel, rows, own, rest);
}
#endif

bool EliminateNarrow(const Block& panel, std::size_t rows, std::size_t own, const Block& rest) {
  return Eliminate<16>(panel, rows, own, rest);
}

}  // namespace

bool EliminateFront(double* panel, std::size_t panel_stride, std::size_t rows, std::size_t own, double* rest,
                    std::size_t rest_stride) {
  const Block front{panel, panel_stride};
  const Block schur{rest, rest_stride};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
    return EliminateWidest(front, rows, own, schur);
  }
  if (__builtin_cpu_supports("avx2")) return EliminateWide(front, rows, own, schur);
#endif
  return EliminateNarrow(front, rows, own, schur);
}

}  // namespace annulus
