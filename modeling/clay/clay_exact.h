#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "fitting/paper_surface.h"
#include "modeling/bezier/patch_shell.h"
#include "modeling/clay/clay_convert.h"
#include "modeling/glasses/frame.h"

namespace annulus {

/// The surface P(u, v) of `fit --method paper` (paper 001, eqs. 2.10, 2.11), closed by flat caps at its ends, as
/// bicubic patches: its own spans in Bezier form (knots inserted until each is threefold), so that nothing is
/// approximated. Base patches as in ClayOfSurface, u around from knot line 0, v upwards. `name` of the body.
Result<ClayOfSurface> ClayFromPaper(const PaperSurface& surface, const std::string& name);

/// Shells of a frame as they are, frame frame: "" all of them, else the shell of this name, else those of the body of
/// this name (FrameBodies), or "lens_right", "lens_left", which are open and make no clay. Where shells overlap a
/// volume counts twice. Fails on another name, naming those there are.
Result<PatchShell> FramePart(const Frame& frame, std::string_view name);

}  // namespace annulus
