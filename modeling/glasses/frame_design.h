#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "modeling/glasses/frame_parameters.h"

namespace annulus {

/// How the rim holds its lens.
enum class RimForm {
  kFull,     ///< All round (the paper's).
  kHalf,     ///< Upper part only; a nylon cord in a groove of the lens' edge below.
  kRimless,  ///< None: bridge and end pieces are screwed to the lenses.
};

enum class BridgeForm {
  kStraight,  ///< The paper's straight tube.
  kSaddle,    ///< Bowed forward and upward over the nose's ridge, one smooth bearing surface.
  kKeyhole,   ///< Arched above, with two flanks that run down beside the ridge: the outline of a keyhole.
};

enum class PadForm {
  kNone,        ///< The bridge or the rims themselves rest on the nose (the paper says nothing).
  kFixed,       ///< Pads that are part of the rim's nasal side.
  kAdjustable,  ///< Pads on wire arms.
};

enum class TempleForm {
  kPaper,     ///< F and R of fig. 16: three lengths of l1/10 behind the ear.
  kSkull,     ///< Bends down behind the ear and follows the head with a tip.
  kStraight,  ///< Hardly bent; held by pressure.
};

enum class HingeForm {
  kNone,    ///< F turns the corner in one piece (the paper's).
  kBarrel,  ///< End piece and temple are separate bodies with a three-barrel hinge between them.
};

/// What paper 000 leaves out, fixes, or leaves for later. Lengths in mm, angles in rad. The defaults are the paper's
/// frame; an absent length is the paper's.
struct FrameDetails {
  RimForm rim = RimForm::kFull;
  BridgeForm bridge = BridgeForm::kStraight;
  PadForm pads = PadForm::kNone;
  TempleForm temple = TempleForm::kPaper;
  HingeForm hinge = HingeForm::kNone;

  std::optional<double> bridge_gap;  ///< l0: distance between the two rectangles P1P2P3P4; absent: l1/5.
  std::optional<double> depth;       ///< s: depth of the control polygon; the solid is 0.75·s thick; absent: l1/20.
  std::optional<double> arm_height;  ///< Height of the temples' attachment over P3P4; absent: l3, as the bridge's.
  std::optional<double> arm_width;   ///< Height of a temple's section at the rim; absent: d1.

  double groove_depth = 0.0;  ///< Of the V groove in the rim's inner side, 0: no groove. 0.5 … 1.2 is usual.
  double groove_width = 0.0;  ///< Opening of the groove at the rim's inner surface. 1 … 2 is usual.
  std::optional<double> bridge_forward;  ///< How far a bowed bridge's middle stands before its ends; absent: 2.5 for a
                                         ///< saddle, 1 for a keyhole; a straight bridge has none. -3 … 12.
  std::optional<double> bridge_rise;     ///< How far its middle is over its ends; absent: 1.5 for a saddle, 3 for a
                                         ///< keyhole; a straight bridge has none. -3 … 12.
  double lens_edge = 2.2;  ///< Edge thickness of the lens that a rimless mount's screw goes through. 1 … 12.

  double frame_curve = 0.0;    ///< Dioptres at n = 1.53: the rim follows a sphere of radius 530/curve; 0: flat.
  double face_form = 0.0;      ///< Angle between a rim's plane and the front's, nasal side forward; 0 … 25°.
  double end_piece = 0.0;      ///< Length from the rim to the hinge; needs a hinge. 3 … 10 is usual.
  double temple_outset = 0.0;  ///< How much further out the temples' corners stand than beside the rim, 0 … 8.
  double tip_length = 40.0;    ///< Of a kSkull or kStraight temple behind the ear point. 30 … 50.
  double tip_drop = 0.0;       ///< Angle by which the tip bends down; 0: 45° (kSkull), 5° (kStraight).
  double pad_length = 13.0;    ///< Of a nose pad, 8 … 18.
  double pad_width = 7.0;      ///< Of a nose pad, 4 … 10.

  [[nodiscard]] bool operator==(const FrameDetails&) const = default;
};

/// A frame as it is designed, before anybody wears it.
struct FrameDesign {
  FrameDesign() = default;
  /// The paper's frame with these parameters: nothing that the paper leaves out.
  FrameDesign(const FrameParameters& paper) : parameters(paper) {}  // NOLINT(google-explicit-constructor)

  std::string style;           ///< Name of the style that it started from; may be empty.
  FrameParameters parameters;  ///< The paper's eight and l1.
  FrameDetails details;

  /// l0, mm.
  [[nodiscard]] double bridge_gap() const { return details.bridge_gap.value_or(parameters.bridge_gap()); }
  /// s, mm.
  [[nodiscard]] double depth() const { return details.depth.value_or(parameters.depth()); }
  /// Distance of the rim centres O0, O0', mm.
  [[nodiscard]] double rim_spacing() const { return parameters.width + bridge_gap(); }
  [[nodiscard]] double arm_height() const { return details.arm_height.value_or(parameters.bridge_height); }
  [[nodiscard]] double arm_width() const { return details.arm_width.value_or(parameters.upper_thickness); }

  [[nodiscard]] bool operator==(const FrameDesign&) const = default;
};

/// The paper's parameters and the heights of `details` multiplied so that the rim is `width` mm wide; sections, groove,
/// pads and tips keep their size, and so does a bridge gap that is given. Requires width > 0.
[[nodiscard]] FrameDesign ScaledToWidth(const FrameDesign& design, double width);
/// ScaledToWidth so that O0 and O0' are `spacing` mm apart. Requires spacing > bridge_gap() where that is given.
[[nodiscard]] FrameDesign ScaledToSpacing(const FrameDesign& design, double spacing);

/// Whether a frame can be built: Validate of the parameters, and every detail within its range. The error names the
/// field and its permitted range.
[[nodiscard]] Status Validate(const FrameDesign& design);

/// One temple as it is bent for a wearer, frame frame.
struct TempleShape {
  Eigen::Vector3d ear{0.0, 0.0, 0.0};  ///< What Q30ᴬ of part R meets: the lower edge where it rests on the ear, mm.
  double bow = 0.0;     ///< rad; the temple leaves the hinge this much outward of the straight line to the ear, and
                        ///< comes in by as much at the ear.
  double tip_in = 0.0;  ///< rad; the tip turns inward behind the ear.
};

/// Where a nose pad stands, frame frame. Ignored without pads.
struct PadPose {
  Eigen::Vector3d centre{0.0, 0.0, 0.0};  ///< Of the face that touches the nose, mm.
  Eigen::Vector3d normal{1.0, 0.0, 0.0};  ///< Unit, out of that face, to the nose.
  Eigen::Vector3d up{0.0, 0.0, 1.0};      ///< Unit, along the pad's length, perpendicular to normal.
};

/// What an optician bends on a frame for one wearer; right and left may differ.
struct FrameAdjustment {
  TempleShape temple_right;
  TempleShape temple_left;
  PadPose pad_right;
  PadPose pad_left;
};

}  // namespace annulus
