#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace annulus {

// The innermost loops of the fit. Every element sees the same operations in the same order whatever vector unit the
// processor has (lanes never mix, nothing is fused), so that results are the same to the bit.

/// Rows are worked on in groups of this many: columns must be readable and writable up to the next multiple, counted
/// from the first row that is worked on.
inline constexpr std::size_t kFrontLanes = 8;

/// Eliminates the first `own` unknowns of a dense symmetric positive definite front, in place (Cholesky).
/// `panel`: its first `own` columns, `rows` rows, lower part; becomes L. `rest`: the lower part of the remaining
/// (rows − own)² block; becomes the Schur complement. Column-major with the given strides, which leave kFrontLanes
/// spare rows. Returns false if a pivot is not positive.
[[nodiscard]] bool EliminateFront(double* panel, std::size_t panel_stride, std::size_t rows, std::size_t own,
                                  double* rest, std::size_t rest_stride);

/// A weighted row of 4 × 4 local splines.
struct TensorRow {
  std::array<double, 4> theta{};
  std::array<double, 4> z{};
  double weight = 0.0;
};

/// A symmetric form over 4 × 4 local coefficients, theta fastest: the 4 × 4 blocks (a, b), a <= b, of the z indices,
/// each with its theta indices; block (a, b) is at 16·(b(b + 1)/2 + a).
using TensorForm = std::array<double, 160>;

/// The form as a full 16 × 16 matrix.
[[nodiscard]] std::array<double, 256> Expanded(const TensorForm& form);

/// form += Σ weight · (z zᵀ) ⊗ (θ θᵀ).
void AddTensorRows(std::span<const TensorRow> rows, TensorForm& form);

/// result = Eᵀ M E for a symmetric 16 × 16 M and a 16 × count E (both column-major, no gaps). `result` is column-major
/// with a stride of at least `count` rounded up to kFrontLanes.
void ProjectForm(const double* form, const double* extraction, std::size_t count, double* result, std::size_t stride);

}  // namespace annulus
