#pragma once

#include <vector>

#include "modeling/bezier/bezier_tube.h"
#include "modeling/bezier/patch_shell.h"
#include "modeling/glasses/rim.h"

namespace annulus {

/// How far a bowed bridge's middle stands before and over its ends, mm: the details' or the form's usual values.
[[nodiscard]] double BridgeForward(const FrameDetails& details);
[[nodiscard]] double BridgeRise(const FrameDetails& details);

/// The bridge from its end section in the right rim (or mount) to its mirror image: tubes that follow each other with
/// G1, A the front. Straight: the paper's one tube. Saddle and keyhole: two, bowed forward and up, whose middle section
/// leans back so that its bearing surface follows the nose's ridge.
[[nodiscard]] std::vector<BezierTube> MakeBridge(const FrameDesign& design, const TubeSection& right_end);

/// A keyhole's right flank: swells from the rim's nose side under the bridge towards the nose, its outer seam on the
/// rim's centre line. Requires a rim.
[[nodiscard]] PatchShell KeyholeFlank(const FrameDesign& design, const Rim& rim);

/// z of a keyhole's flanks' lower ends, mm.
[[nodiscard]] double FlankBottom(const FrameDesign& design, const Rim& rim);

}  // namespace annulus
