#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/bezier/patch_shell.h"
#include "modeling/glasses/frame.h"

namespace annulus {

/// What a part of a frame is to the head: which distances it has to keep.
enum class FrameRole {
  kRim,
  kBridge,
  kPad,       ///< The bearing itself.
  kPadArm,    ///< What carries a pad.
  kEndPiece,  ///< Rim to hinge.
  kTemple,
};

/// The skin of one part.
struct FrameShell {
  std::string part;  ///< The shell's name: "rim_right", "bridge", …
  FrameRole role = FrameRole::kRim;
  PatchShell shell;  ///< Frame frame, mm.
};

/// All shells of a frame.
[[nodiscard]] std::vector<FrameShell> ShellsOf(const Frame& frame);
/// The front of a design with pads as the adjustment says, without the small parts of its hinges: in a tenth of the
/// time that the whole frame takes. Fails as BuildFrame does.
[[nodiscard]] Result<std::vector<FrameShell>> FrontShells(const FrameDesign& design, const FrameAdjustment& adjustment);
/// The two temples alone, right and left: from the hinge, or in one piece from the rim.
[[nodiscard]] Result<std::vector<FrameShell>> TempleShells(const FrameDesign& design,
                                                           const FrameAdjustment& adjustment);

/// How finely a skin is sampled.
struct PointDensity {
  int along = 6;   ///< Points per patch along a tube, >= 1.
  int around = 4;  ///< And round it, >= 1; half as many along what is straight.
};
/// Points of a direction of a patch.
[[nodiscard]] int StepsOf(PatchDetail detail, const PointDensity& density);

/// Points of a skin, spread evenly in the parameters of its patches. The order depends on the design's form only, so
/// that frames of the same form correspond point by point.
[[nodiscard]] std::vector<Eigen::Vector3d> SamplePoints(const PatchShell& shell, const PointDensity& density);

/// The role of a shell by its body's and its own name (FrameBodies); rims, mounts and what is not known count as rim.
[[nodiscard]] FrameRole RoleOfPart(const std::string& body, const std::string& shell);

/// The plane of a lens in the frame frame: its rim's (Rim::frame_from_rim), on which outline and box are measured.
struct LensPlane {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< Box centre, in the plane.
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();    ///< Unit, level, the wearer's right.
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();       ///< Unit.
  Eigen::Vector3d forward = Eigen::Vector3d::UnitY();  ///< Unit normal.
  double a = 0.0;                                      ///< Box width, mm.
  double b = 0.0;                                      ///< Box height, mm.
  std::vector<Eigen::Vector2d> outline;                ///< (right, up) from the centre, mm.
};
[[nodiscard]] LensPlane LensPlaneOf(const Rim& rim, Eye eye);

}  // namespace annulus
