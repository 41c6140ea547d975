#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/bezier/bezier_patch.h"
#include "modeling/bezier/bezier_tube.h"
#include "modeling/bezier/patch_shell.h"
#include "modeling/glasses/frame_design.h"
#include "modeling/glasses/lens_outline.h"
#include "modeling/glasses/rim.h"
#include "modeling/glasses/temple.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// One piece of the finished frame: closed shells that overlap and together are one solid.
struct FrameBody {
  std::string name;  ///< See FrameBodies.
  std::vector<PatchShell> shells;
};

/// A frame in the frame frame: mm, origin midway between the rim centres O0 and O0', +x the wearer's right, +y forward,
/// +z up. The default details give the frame of paper 000, §3, whose rims' centre lines lie in y = 0. Rims, bridge and
/// lenses are mirror images at x = 0; temples and pads are as the adjustment says.
struct Frame {
  FrameDesign design;
  FrameAdjustment adjustment;
  Rim rim;  ///< The right rim's control sections.
  /// M0…M3 (top), M3…M6 (nose), M6…M9 (bottom), M9…M0 (temple), without groove; of a rim with a frame curve each in two
  /// halves. Patch A is the front of the right rim
  /// and the back of the left one; the seam Q_i0ᴬ is the inner outline of both. A half rim has part of them, a rimless
  /// frame has none: there they are construction only.
  std::vector<BezierTube> rim_right;
  std::vector<BezierTube> rim_left;
  /// From the right rim to the left; row 0 of the first and row 3 of the last tube are hidden in the rims; A is the
  /// front. One tube if straight (the paper's).
  std::vector<BezierTube> bridge;
  FrameArm arm_right;
  FrameArm arm_left;
  BezierPatch lens_right;  ///< Its boundary is the rim's inner outline (§3.6); normals forward; not part of the solid.
  BezierPatch lens_left;
  std::vector<FrameBody> bodies;  ///< See FrameBodies.

  /// C: the middle of the bridge's centre line, mm.
  [[nodiscard]] Eigen::Vector3d bridge_centre() const;
  /// O0 (right) and O0' (left), mm.
  [[nodiscard]] Eigen::Vector3d rim_centre_right() const;
  [[nodiscard]] Eigen::Vector3d rim_centre_left() const;
};

/// C of the frame that a valid design gives, mm.
[[nodiscard]] Eigen::Vector3d BridgeCentre(const FrameDesign& design);

/// The adjustment of a frame that nobody wears: temples straight back, the ear 1.7·l1 + l1/10 behind the corner; pads
/// with a splay of 30° and a frontal angle of 25° between rims and nose. Requires a valid design.
[[nodiscard]] FrameAdjustment StandardAdjustment(const FrameDesign& design);

/// Builds the frame. Fails if the design is invalid (Validate), an ear point is not behind the corner by at least
/// seven arm segments (the temple could not reach it), or a pad's pose is not a pose beside the bridge.
[[nodiscard]] Result<Frame> BuildFrame(const FrameDesign& design, const FrameAdjustment& adjustment);

/// The bodies that are made and joined: what STL, STEP and volumes are taken from. No lens, no screws.
/// Without hinges "frame", with hinges "front", "temple_right", "temple_left"; rimless "bridge" and, with hinges,
/// "end_piece_right", "end_piece_left", "temple_right", "temple_left", else "arm_right", "arm_left".
/// Shells: "rim_right", "bridge", "flank_right" (keyhole), "pad_right", "pad_wire_right", "mount_nose_right",
/// "mount_temple_right" (rimless), "arm_right" (in one piece) or "end_piece_right" and "temple_right", "knuckle_right",
/// "leaf_right" (hinges), and the same with left.
[[nodiscard]] const std::vector<FrameBody>& FrameBodies(const Frame& frame);

/// The lens' outline in the plane of its rim, origin at the rim's centre O0 (O0'): the bottom of the groove if there is
/// one, else the rim's inner outline; of a rimless frame the rim's centre line, of a half-rim frame as if the rim went
/// all round. Exact at its points, projected along the rim's normal where it has a frame curve (LensPoint has the
/// bend).
[[nodiscard]] LensOutline LensOutlineOf(const Frame& frame, Eye eye);

/// A named mesh.
struct FrameMesh {
  std::string name;
  TriangleMesh mesh;
};
/// Every shell as a closed mesh of positive volume under its name, frame frame.
[[nodiscard]] std::vector<FrameMesh> TessellateFrameParts(const Frame& frame, const ShellTessellation& tessellation);
/// All shells in one mesh, as the STL holds it: closed shells that overlap, no lens.
[[nodiscard]] TriangleMesh TessellateFrame(const Frame& frame, const ShellTessellation& tessellation);
/// "lens_right" and "lens_left": open sheets, normals forward. `steps` per side >= 1.
[[nodiscard]] std::vector<FrameMesh> TessellateLenses(const Frame& frame, std::size_t steps);

}  // namespace annulus
