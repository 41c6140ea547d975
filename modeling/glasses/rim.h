#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "modeling/bezier/bezier_patch.h"
#include "modeling/bezier/bezier_tube.h"
#include "modeling/bezier/patch_shell.h"
#include "modeling/glasses/frame_design.h"

namespace annulus {

/// The right rim's control sections M0 … M11 (paper 000, fig. 9) in the frame frame, mm; the left rim is its mirror
/// image. Places across a section are given in half widths: -1 on the inner seam, 0 on the centre line, 1 on the outer
/// seam. With a groove the section is a closed curve of patch A and B cut at the groove's lips and two straight flanks
/// to its bottom; the half depth is the same everywhere, so the lips have the same v all round. A frame curve moves
/// whole sections along the rim's normal, by two cubic pieces on each of the four tubes.
struct Rim {
  std::array<Eigen::Vector3d, 12> m;           ///< M_i, in the rim's plane (without the bend).
  std::array<Eigen::Vector3d, 12> half_width;  ///< From M_i to the outer seam.
  std::array<double, 12> thickness;            ///< d1 or d2.
  Eigen::Vector3d half_depth;                  ///< s/2 along the rim's normal, forward.
  double groove_v = 0.0;                       ///< v of patch A at the groove's front lip; 0 without a groove.
  std::array<double, 12> lens_place;  ///< Of the lens' outline: the groove's bottom, -1 without a groove, 0 for
                                      ///< a rimless lens.
  bool bent = false;                  ///< Whether there is a frame curve.
  /// Along the normal, mm: control values of the pieces [0, 0.5] (0 … 3) and [0.5, 1] (3 … 6) of each tube.
  std::array<std::array<double, 7>, 4> bend{};
  double sphere_front = 0.0;  ///< y in the rim's frame of the front-most point of the frame curve's sphere; 0 if flat.
  Eigen::Isometry3d frame_from_rim;  ///< Origin O0, y the rim's normal: the lens' plane is y = 0.
};

/// The sides of the right rim on which something is attached.
enum class RimSide { kNose, kTemple };

/// The right rim of a valid design: the octagon of fig. 9, bent to a sphere of radius 530/frame_curve (least squares
/// on the lens' outline, C1 at the joins), turned by face_form about the vertical through O0.
[[nodiscard]] Rim MakeRim(const FrameDesign& design);

/// The tubes without groove in the order M0 … M3 (top), nose, bottom, temple; one each if flat, two each if bent. Patch
/// A is the front.
[[nodiscard]] std::vector<BezierTube> RimTubes(const Rim& rim);

/// The lens' outline along tube k (0 … 3), in the rim's plane.
[[nodiscard]] BezierCurve LensCurve(const Rim& rim, std::size_t k);
/// The point of the lens' outline at u on tube k, with the bend.
[[nodiscard]] Eigen::Vector3d LensPoint(const Rim& rim, std::size_t k, double u);

/// The curve along tube k (0 … 3) at a constant place across the sections, in the rim's plane.
[[nodiscard]] BezierCurve RimCurve(const Rim& rim, std::size_t k, double place);
/// How far the bend moves the sections at u on tube k, as a vector along the rim's normal.
[[nodiscard]] Eigen::Vector3d RimBend(const Rim& rim, std::size_t k, double u);

/// §3.6: the boundary control points are the rim's inner ones (of a rimless lens: M_i), the inner four the third points
/// of P1P2P3P4 raised 3s over the plane of M0, M3, M6, M9; with a frame curve so that the middle lies on its sphere,
/// and the boundary meets the bent rim at three places of each tube.
[[nodiscard]] BezierPatch RightLens(const FrameDesign& design, const Rim& rim);

/// What a half rim keeps: the top, the nose side up to `nose_end` and the temple side from `temple_start` (u of their
/// tubes, inside 0 … 1).
struct HalfRimSpan {
  double nose_end = 1.0;
  double temple_start = 0.0;
};

/// The right rim's solid, grooved if it has a groove; with a span its ends are flat.
[[nodiscard]] PatchShell RimShell(std::string name, const Rim& rim, const std::optional<HalfRimSpan>& span);

/// The section's depth at a place, as a share of the control polygon's: 0.75 in the middle, 0 at the seams.
[[nodiscard]] double RimDepthShare(double place);

/// Place of a groove's lips across a section, in half widths, when it opens by this share of s (0 … 0.75).
[[nodiscard]] double GrooveLip(double opening_share);

/// z of bridge and temples in the frame frame, mm.
[[nodiscard]] double BridgeZ(const FrameDesign& design);
[[nodiscard]] double TempleZ(const FrameDesign& design);

/// The offset, per unit of distance, of the corner between two lines with these unit normals.
[[nodiscard]] Eigen::Vector3d Mitre(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace annulus
