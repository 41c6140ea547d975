#pragma once

#include <cstddef>
#include <string>

#include "fitting/surface_model.h"

namespace annulus {

/// How finely a body is drawn.
struct ScanMeshOptions {
  double step_deg = 2.0;                ///< Between columns, 0.25 … 30.
  double step_mm = 4.0;                 ///< Between rows, 0.5 … 50.
  std::size_t most_triangles = 40'000;  ///< Beyond, both steps grow together.
};

/// The body of a model in the binary form of docs/console_api.md §7: every segment, cells of which nothing is known
/// left out, with normals and knowledge of every vertex.
[[nodiscard]] std::string ScanMesh(const SurfaceModel& model, const ScanMeshOptions& options);

}  // namespace annulus
