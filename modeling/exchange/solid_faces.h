#pragma once

#include <memory>

#include "base/result.h"
#include "modeling/bezier/patch_shell.h"

class TopoDS_Shape;

namespace annulus {

/// The solid of a closed shell, one face per patch: planes where a patch is flat, else B-spline surfaces with the
/// patch's control points. Fails if the shell is not closed within 1e-4 mm, encloses nothing, or Open CASCADE finds it
/// invalid.
[[nodiscard]] Result<TopoDS_Shape> SolidOfShell(const PatchShell& shell);

}  // namespace annulus
