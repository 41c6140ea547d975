#include "fitting/front_kernels.h"

#include <cmath>
#include <cstring>

#include "base/ensure.h"

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

template <int Bytes>
[[gnu::always_inline]] inline void AddRows(const TensorRow* rows, std::size_t count, double* form) {
  using Lanes = typename LaneType<Bytes>::Type;
  constexpr std::size_t kStep = Bytes / sizeof(double);
  constexpr std::size_t kParts = 16 / kStep;
  for (std::size_t n = 0; n < count; ++n) {
    const TensorRow& row = rows[n];
    double outer[16];
    for (std::size_t b = 0; b < 4; ++b) {
      for (std::size_t a = 0; a < 4; ++a) outer[4 * b + a] = row.theta[a] * row.theta[b];
    }
    Lanes lanes[kParts];
    for (std::size_t k = 0; k < kParts; ++k) lanes[k] = *reinterpret_cast<const Lanes*>(outer + kStep * k);
    double* block = form;
    for (std::size_t b = 0; b < 4; ++b) {
      const double scaled = row.weight * row.z[b];
      for (std::size_t a = 0; a <= b; ++a, block += 16) {
        const double scale = scaled * row.z[a];
        for (std::size_t k = 0; k < kParts; ++k) *reinterpret_cast<Lanes*>(block + kStep * k) += scale * lanes[k];
      }
    }
  }
}

constexpr std::size_t kMaxActive = 256;  // of one leaf; more is impossible with three levels

template <int Bytes>
[[gnu::always_inline]] inline void Project(const double* form, const double* extraction, std::size_t count,
                                           double* result, std::size_t stride) {
  using Lanes = typename LaneType<Bytes>::Type;
  constexpr std::size_t kStep = Bytes / sizeof(double);
  const std::size_t padded = (count + kFrontLanes - 1) / kFrontLanes * kFrontLanes;
  double transposed[16 * kMaxActive];
  for (std::size_t k = 0; k < 16; ++k) {
    for (std::size_t a = 0; a < count; ++a) transposed[k * padded + a] = extraction[16 * a + k];
    for (std::size_t a = count; a < padded; ++a) transposed[k * padded + a] = 0.0;
  }
  for (std::size_t b = 0; b < count; ++b) {
    Lanes half_lanes[16 / kStep] = {};
    for (std::size_t k = 0; k < 16; ++k) {
      const double weight = extraction[16 * b + k];
      if (weight == 0.0) continue;
      for (std::size_t p = 0; p < 16 / kStep; ++p) {
        half_lanes[p] += weight * *reinterpret_cast<const Lanes*>(form + 16 * k + kStep * p);
      }
    }
    double half[16];
    std::memcpy(half, half_lanes, sizeof(half));
    for (std::size_t a = 0; a < padded; a += kStep) {
      Lanes sum = {};
      for (std::size_t k = 0; k < 16; ++k)
        sum += half[k] * *reinterpret_cast<const Lanes*>(transposed + k * padded + a);
      *reinterpret_cast<Lanes*>(result + b * stride + a) = sum;
    }
  }
}

/// One set of the kernels, for one vector unit.
struct Kernels {
  bool (*eliminate)(const Block& panel, std::size_t rows, std::size_t own, const Block& rest);
  void (*add_rows)(const TensorRow* rows, std::size_t count, double* form);
  void (*project)(const double* form, const double* extraction, std::size_t count, double* result, std::size_t stride);
};

constexpr Kernels kNarrow{
    [](const Block& panel, std::size_t rows, std::size_t own, const Block& rest) {
      return Eliminate<16>(panel, rows, own, rest);
    },
    [](const TensorRow* rows, std::size_t count, double* form) { AddRows<16>(rows, count, form); },
    [](const double* form, const double* extraction, std::size_t count, double* result, std::size_t stride) {
      Project<16>(form, extraction, count, result, stride);
    }};

#if defined(__x86_64__)
[[gnu::target("avx2")]] bool EliminateWide(const Block& panel, std::size_t rows, std::size_t own, const Block& rest) {
  return Eliminate<64>(panel, rows, own, rest);
}
[[gnu::target("avx2")]] void AddRowsWide(const TensorRow* rows, std::size_t count, double* form) {
  AddRows<32>(rows, count, form);
}
[[gnu::target("avx2")]] void ProjectWide(const double* form, const double* extraction, std::size_t count,
                                         double* result, std::size_t stride) {
  Project<32>(form, extraction, count, result, stride);
}
constexpr Kernels kWide{EliminateWide, AddRowsWide, ProjectWide};

[[gnu::target("avx512f,avx512vl,avx512dq")]] bool EliminateWidest(const Block& panel, std::size_t rows, std::size_t own,
                                                                  const Block& rest) {
  return Eliminate<64>(panel, rows, own, rest);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void AddRowsWidest(const TensorRow* rows, std::size_t count,
                                                                double* form) {
  AddRows<64>(rows, count, form);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void ProjectWidest(const double* form, const double* extraction,
                                                                std::size_t count, double* result, std::size_t stride) {
  Project<64>(form, extraction, count, result, stride);
}
constexpr Kernels kWidest{EliminateWidest, AddRowsWidest, ProjectWidest};
#endif

const Kernels& ForThisProcessor() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
    return kWidest;
  }
  if (__builtin_cpu_supports("avx2")) return kWide;
#endif
  return kNarrow;
}

}  // namespace

bool EliminateFront(double* panel, std::size_t panel_stride, std::size_t rows, std::size_t own, double* rest,
                    std::size_t rest_stride) {
  return ForThisProcessor().eliminate({panel, panel_stride}, rows, own, {rest, rest_stride});
}

std::array<double, 256> Expanded(const TensorForm& form) {
  std::array<double, 256> matrix{};
  for (std::size_t b = 0, pair = 0; b < 4; ++b) {
    for (std::size_t a = 0; a <= b; ++a, ++pair) {
      for (std::size_t k = 0; k < 4; ++k) {
        const double* from = form.data() + 16 * pair + 4 * k;
        std::memcpy(matrix.data() + 16 * (4 * b + k) + 4 * a, from, 4 * sizeof(double));
        std::memcpy(matrix.data() + 16 * (4 * a + k) + 4 * b, from, 4 * sizeof(double));
      }
    }
  }
  return matrix;
}

void AddTensorRows(std::span<const TensorRow> rows, TensorForm& form) {
  ForThisProcessor().add_rows(rows.data(), rows.size(), form.data());
}

void ProjectForm(const double* form, const double* extraction, std::size_t count, double* result, std::size_t stride) {
  ENSURE(count <= kMaxActive, "a leaf has few active coefficients");
  ForThisProcessor().project(form, extraction, count, result, stride);
}

}  // namespace annulus
