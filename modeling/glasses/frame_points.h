#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

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

/// Points of one part, spread evenly over its skin in the parameters of its patches.
struct PartPoints {
  std::string part;  ///< The shell's name: "rim_right", "bridge", …
  FrameRole role = FrameRole::kRim;
  std::vector<Eigen::Vector3d> points;  ///< Frame frame, mm.
};

/// How finely.
struct PointDensity {
  int along = 6;   ///< Points per patch along a tube, >= 1.
  int around = 4;  ///< And round it, >= 1.
};

/// What is sampled.
enum class PointChoice { kAll, kFront, kTemples };

/// Points of all shells of the frame's bodies, or of its front or temples only. The order depends on the design's form
/// only, so that frames of the same form correspond point by point.
[[nodiscard]] std::vector<PartPoints> SampleFrame(const Frame& frame, const PointDensity& density, PointChoice choice);

/// The role of a shell by its body's and its own name (FrameBodies); rims, mounts and what is not known count as rim.
[[nodiscard]] FrameRole RoleOfPart(const std::string& body, const std::string& shell);

/// The plane of a lens in the frame frame: of its outline.
struct LensPlane {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< Box centre, in the plane.
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();    ///< Unit, level, the wearer's right.
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();       ///< Unit.
  Eigen::Vector3d forward = Eigen::Vector3d::UnitY();  ///< Unit normal.
  double a = 0.0;                                      ///< Box width, mm.
  double b = 0.0;                                      ///< Box height, mm.
  std::vector<Eigen::Vector2d> outline;                ///< (right, up) from the centre, mm.
};
[[nodiscard]] LensPlane LensPlaneOf(const Frame& frame, Eye eye);

}  // namespace annulus
