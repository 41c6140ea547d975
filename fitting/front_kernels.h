#pragma once

#include <cstddef>

namespace annulus {

/// Rows are worked on in groups of this many: columns must be readable and writable up to the next multiple, counted
/// from the first row that is worked on.
inline constexpr std::size_t kFrontLanes = 8;

/// Eliminates the first `own` unknowns of a dense symmetric positive definite front, in place (Cholesky).
/// `panel`: its first `own` columns, `rows` rows, lower part; becomes L. `rest`: the lower part of the remaining
/// (rows − own)² block; becomes the Schur complement. Column-major with the given strides, which leave kFrontLanes
/// spare rows. Every element sees the same operations in the same order whatever vector unit the processor has, so that
/// results are the same to the bit. Returns false if a pivot is not positive.
[[nodiscard]] bool EliminateFront(double* panel, std::size_t panel_stride, std::size_t rows, std::size_t own,
                                  double* rest, std::size_t rest_stride);

}  // namespace annulus
