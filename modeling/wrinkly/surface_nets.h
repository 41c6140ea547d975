#pragma once

#include "base/result.h"
#include "fitting/spline_surface.h"
#include "modeling/bezier/patch_shell.h"
#include "modeling/wrinkly/control_mesh.h"

namespace annulus {

/// Part of a measured surface as a control mesh.
struct SurfaceNet {
  int columns = 48;            ///< Around.
  int rows = 24;               ///< Upwards.
  double z_min = 0.0;          ///< mm
  double z_max = 0.0;          ///< mm
  double theta_from = 0.0;     ///< rad
  double theta_over = 6.2832;  ///< rad, > 0; 2 pi or more (to 1e-3): all around, columns cyclic.
  /// What is above the last row: nothing, or a closed side, so that a net all around ends as a ring net does.
  enum class Top { kOpen, kClosed } top = Top::kOpen;
};

/// A regular net whose base surface touches r(θ, z) in the middle of every patch; U runs along θ, V along z, heights 0.
/// Fails on counts under 3 or a range outside the surface's.
[[nodiscard]] Result<ControlMeshParts> NetOfSurface(const SplineSurface& surface, const SurfaceNet& net);

/// A part of a frame as a control mesh: each of the shell's patches is cut into `per_patch` × `per_patch` control
/// points, and the base surface touches it in the middle of each. Corners where three patches meet make it a mesh whose
/// axes have to be cut (FamilyRule::kCut). Heights 0. Fails on per_patch outside 1 … 64, or as ControlMeshOfQuads.
[[nodiscard]] Result<ControlMeshParts> NetOfShell(const PatchShell& shell, int per_patch);

}  // namespace annulus
