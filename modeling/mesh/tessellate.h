#pragma once

#include <cstddef>

#include "fitting/surface_model.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// What happens at the first and last height of a tessellated surface.
enum class EndClosure {
  kOpen,   ///< Nothing: the mesh has two rims.
  kBelow,  ///< A flat fan closes the lower end.
  kAbove,  ///< A flat fan closes the upper end.
  kBoth,   ///< Both: the mesh is closed if no cell is left out.
};

struct TessellationOptions {
  std::size_t theta_count = 360;  ///< Columns of the grid, >= 3.
  double max_z_spacing_mm = 4.0;  ///< Largest distance of rows, mm, > 0.
  EndClosure ends = EndClosure::kOpen;
  bool skip_unknown = true;  ///< Leave out cells with a corner where nothing is known.
};

/// A grid mesh of the surface over its whole height, oriented outward, vertices shared. A cell is kept if none of its
/// four corners is Knowledge::kUnknown; a fan is made over an end only if all of its rim is kept. A surface with an
/// empty knowledge map counts as known everywhere. Vertices without a face are not stored. Requires the options'
/// ranges.
[[nodiscard]] TriangleMesh TessellateSurface(const SurfaceSegment& segment, const TessellationOptions& options);

}  // namespace annulus
