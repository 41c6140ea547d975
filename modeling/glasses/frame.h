#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/bezier/bezier_patch.h"
#include "modeling/bezier/bezier_tube.h"
#include "modeling/bezier/patch_shell.h"
#include "modeling/glasses/frame_design.h"
#include "modeling/glasses/lens_outline.h"
#include "modeling/mesh/triangle_mesh.h"

namespace annulus {

/// One temple (fig. 16): F leaves the rim sideways, turns and runs to the ear; R bends 45° behind it.
/// Row 3 of F is inside the rim, row 0 of F is row 3 of R, row 0 of R is the tip.
struct FrameArm {
  BezierTube f;
  BezierTube r;
  double l6 = 0.0;            ///< mm; the length that the face decides.
  Eigen::Vector3d ear_point;  ///< Q30ᴬ of R: the lower seam at the joint, mm.
};

/// The frame of paper 000, §3, in the frame frame: mm, origin midway between the rim centres O0 and O0', +x the
/// wearer's right, +y forward, +z up; the rims' centre lines lie in y = 0. Rims, bridge and lenses are mirror images at
/// x = 0.
struct Frame {
  FrameDesign design;
  FrameAdjustment adjustment;
  /// M0…M3 (top), M3…M6 (nose), M6…M9 (bottom), M9…M0 (temple). Patch A is the front of the right rim and the back of
  /// the left one; the seam Q_i0ᴬ is the inner outline of both.
  std::array<BezierTube, 4> rim_right;
  std::array<BezierTube, 4> rim_left;
  BezierTube bridge;  ///< Row 0 in the right rim, row 3 in the left rim; A is the front.
  FrameArm arm_right;
  FrameArm arm_left;
  BezierPatch lens_right;  ///< Its boundary is the rim's inner outline (§3.6); normals forward; not part of the solid.
  BezierPatch lens_left;

  /// C: the bridge's centre, mm.
  [[nodiscard]] Eigen::Vector3d bridge_centre() const;
  /// O0 (right) and O0' (left), mm.
  [[nodiscard]] Eigen::Vector3d rim_centre_right() const;
  [[nodiscard]] Eigen::Vector3d rim_centre_left() const;
};

/// The adjustment of a frame that nobody wears: temples straight back, l6 = 1.7·l1. Requires a valid design.
[[nodiscard]] FrameAdjustment StandardAdjustment(const FrameDesign& design);

/// Builds the frame. Fails if the design is invalid (Validate) or an ear point is not behind the hinge by at least
/// l5 + l7 (the temple could not reach it).
[[nodiscard]] Result<Frame> BuildFrame(const FrameDesign& design, const FrameAdjustment& adjustment);

/// A closed piece of the frame: tubes that follow each other.
struct FramePart {
  std::string name;  ///< "rim_right", "rim_left", "bridge", "arm_right", "arm_left".
  std::vector<BezierTube> tubes;
  TubeEnds ends;
};
/// The five parts of the solid, lenses not among them. Each is closed; neighbours overlap.
[[nodiscard]] std::vector<FramePart> FrameParts(const Frame& frame);

/// One piece of the finished frame: shells that overlap and together are one solid.
struct FrameBody {
  std::string name;  ///< "frame"; with hinges "front", "temple_right", "temple_left".
  std::vector<PatchShell> shells;
};
/// The bodies that are made and joined: what STL, STEP and volumes are taken from. No lens.
[[nodiscard]] std::vector<FrameBody> FrameBodies(const Frame& frame);

/// The lens' outline in the plane of its rim, origin at the rim's centre O0 (O0'): the bottom of the groove if there is
/// one, else the rim's inner outline.
[[nodiscard]] LensOutline LensOutlineOf(const Frame& frame, Eye eye);

/// A named mesh.
struct FrameMesh {
  std::string name;
  TriangleMesh mesh;
};
/// Every part as a closed mesh of positive volume, frame frame.
[[nodiscard]] std::vector<FrameMesh> TessellateFrameParts(const Frame& frame, const TubeTessellation& tessellation);
/// All parts in one mesh, as the STL holds it: five closed shells, no lens.
[[nodiscard]] TriangleMesh TessellateFrame(const Frame& frame, const TubeTessellation& tessellation);
/// "lens_right" and "lens_left": open sheets, normals forward. `steps` per side >= 1.
[[nodiscard]] std::vector<FrameMesh> TessellateLenses(const Frame& frame, std::size_t steps);

}  // namespace annulus
