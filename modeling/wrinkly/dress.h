#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "fitting/spline_surface.h"
#include "modeling/bezier/patch_shell.h"
#include "modeling/wrinkly/control_mesh.h"

namespace annulus {

// Control meshes with heights and colours for what is measured. Attributes: height (mm), red, green, blue (linear),
// opacity. The same seed gives the same mesh.

/// Heights and colours without pattern for a mesh of any kind: heights low … high mm, each control point of its own
/// colour.
void DressAtRandom(ControlMeshParts& parts, double low, double high, std::uint64_t seed);

/// Hair on a scanned head: over its top and down to a hairline that runs 45 mm below the top in front and 150 mm
/// behind; `length_mm` is the mean height. The face is bare: there the opacity is 0. Fails as NetOfSurface.
[[nodiscard]] Result<ControlMeshParts> HairOf(const SplineSurface& head, double length_mm, std::uint64_t seed);

/// A knitted band around a torso between two heights: ribs of `rib_mm`, 1 mm high, in two colours.
struct KnitBand {
  double z_min = 0.0;  ///< mm
  double z_max = 0.0;  ///< mm
  double rib_mm = 8.0;
};
[[nodiscard]] Result<ControlMeshParts> KnitOf(const SplineSurface& torso, const KnitBand& band, std::uint64_t seed);

/// What a frame's surface is given.
enum class FrameTexture {
  kTortoise,  ///< Amber with dark clouds, flat.
  kCarved,    ///< One colour, cut up to 0.4 mm deep.
};
/// All shells of a frame as one mesh of separate pieces, whose axes have to be cut (FamilyRule::kCut).
[[nodiscard]] Result<ControlMeshParts> TexturedFrame(const std::vector<PatchShell>& shells, FrameTexture texture,
                                                     std::uint64_t seed);

/// Appends the points of `more`, whose attributes are the same.
void Append(ControlMeshParts& parts, const ControlMeshParts& more);

}  // namespace annulus
