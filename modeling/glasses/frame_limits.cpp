#include "modeling/glasses/frame_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/units.h"
#include "modeling/glasses/hinge.h"
#include "modeling/glasses/rim.h"

namespace annulus {
namespace {

/// A groove's bottom may reach this place across the section (half widths from the centre line): 35 % of the rim stay.
constexpr double kDeepestGroove = 0.3;
/// Share of s that a groove may open: 0.75·s is the rim's whole thickness.
constexpr double kWidestGroove = 0.6;
/// Lowest end piece and temple that hold a hinge, mm.
constexpr double kHingeWidth = 2.5;

double Thinnest(const FrameDesign& d) { return std::min(d.parameters.upper_thickness, d.parameters.lower_thickness); }
double Thickest(const FrameDesign& d) { return std::max(d.parameters.upper_thickness, d.parameters.lower_thickness); }
bool HasGroove(const FrameDesign& d) { return d.details.rim != RimForm::kRimless && d.details.groove_depth > 0.0; }

DetailLimits BridgeGap(const FrameDesign& d) {
  return {std::max(4.0, Thickest(d) + 1.0), std::max(40.0, Thickest(d) + 1.0), "the rims must clear each other"};
}

DetailLimits Depth(const FrameDesign& /*design*/) { return {0.8, 10.0, "0.75 of it is the frame's thickness"}; }

DetailLimits ArmWidth(const FrameDesign& d) {
  if (d.details.hinge != HingeForm::kNone) return {kHingeWidth, 25.0, "a temple must hold its hinge"};
  return {0.1, 25.0, "it is a temple's height at the rim"};
}

DetailLimits ArmHeight(const FrameDesign& d) {
  const FrameParameters& p = d.parameters;
  const double margin = 0.5 * std::min(d.arm_width(), p.upper_thickness);
  return {p.lower_outer / std::numbers::sqrt2 + margin, p.height - p.upper_outer / std::numbers::sqrt2 - margin,
          "temples start beside the rim's straight side"};
}

DetailLimits Bow(const FrameDesign& /*design*/) { return {-3.0, 12.0, "it bows over a nose"}; }
DetailLimits LensEdge(const FrameDesign& /*design*/) { return {1.0, 12.0, "it is a lens' edge"}; }

DetailLimits GrooveWidth(const FrameDesign& d) {
  if (!HasGroove(d)) return {0.0, 0.0, "there is no groove"};
  return {0.1 * d.depth(), kWidestGroove * d.depth(), "the rim must keep walls beside it"};
}

DetailLimits GrooveDepth(const FrameDesign& d) {
  if (!HasGroove(d) || d.details.groove_width <= 0.0) return {0.0, 0.0, "there is no groove"};
  return {0.02 * Thinnest(d), DeepestGroove(d), "the rim must keep a wall behind it"};
}

DetailLimits FrameCurve(const FrameDesign& d) {
  const double rim = 0.5 * std::hypot(d.parameters.width, d.parameters.height) + Thickest(d);
  return {0.0, std::min(10.0, 530.0 / (1.25 * rim)), "the rim must fit on its sphere"};
}

DetailLimits FaceForm(const FrameDesign& /*design*/) {
  return {0.0, RadiansFromDegrees(25.0), "rims are turned nasal side forward, no further"};
}

DetailLimits EndPiece(const FrameDesign& d) {
  if (d.details.hinge == HingeForm::kNone) return {0.0, 0.0, "there is no hinge"};
  // The middle knuckle turns behind the rim, whose outer edge face form and frame curve bring back.
  const double half = 0.5 * Thickest(d);
  const double curve = std::min(1.0, d.details.frame_curve * 0.5 * d.parameters.width / 530.0);
  const double behind_rim = 0.375 * d.depth() + half * (std::sin(d.details.face_form) + curve);
  // And behind the end piece itself, which fills its corner the more the thicker it is.
  const double behind_corner = 0.375 * d.depth() + 0.6 + 0.1 * std::max(0.0, d.depth() - 2.5);
  const double shortest = std::max(3.0, std::max(behind_rim, behind_corner) + 0.5 * kKnuckleDiameter + 0.6);
  return {shortest, std::max(20.0, shortest), "it must hold the hinge"};
}

DetailLimits TempleOutset(const FrameDesign& /*design*/) { return {0.0, 12.0, "corners stand beside the rim"}; }
DetailLimits TipLength(const FrameDesign& /*design*/) { return {15.0, 80.0, "tips end behind the ear"}; }
DetailLimits TipDrop(const FrameDesign& /*design*/) { return {0.0, RadiansFromDegrees(80.0), "tips bend down"}; }
DetailLimits PadLength(const FrameDesign& /*design*/) { return {8.0, 18.0, "pads are that long"}; }
DetailLimits PadWidth(const FrameDesign& /*design*/) { return {4.0, 10.0, "pads are that wide"}; }

using enum DetailUnit;

constexpr std::array<DetailRule, 17> kRules{{
    {"bridge-gap", kMillimetres, nullptr, &FrameDetails::bridge_gap, BridgeGap},
    {"depth", kMillimetres, nullptr, &FrameDetails::depth, Depth},
    {"arm-width", kMillimetres, nullptr, &FrameDetails::arm_width, ArmWidth},
    {"arm-height", kMillimetres, nullptr, &FrameDetails::arm_height, ArmHeight},
    {"bridge-forward", kMillimetres, nullptr, &FrameDetails::bridge_forward, Bow},
    {"bridge-rise", kMillimetres, nullptr, &FrameDetails::bridge_rise, Bow},
    {"lens-edge", kMillimetres, &FrameDetails::lens_edge, nullptr, LensEdge},
    {"groove-width", kMillimetres, &FrameDetails::groove_width, nullptr, GrooveWidth},
    {"groove-depth", kMillimetres, &FrameDetails::groove_depth, nullptr, GrooveDepth},
    {"frame-curve", kDioptres, &FrameDetails::frame_curve, nullptr, FrameCurve},
    {"face-form", kDegrees, &FrameDetails::face_form, nullptr, FaceForm},
    {"end-piece", kMillimetres, &FrameDetails::end_piece, nullptr, EndPiece},
    {"temple-outset", kMillimetres, &FrameDetails::temple_outset, nullptr, TempleOutset},
    {"tip-length", kMillimetres, &FrameDetails::tip_length, nullptr, TipLength},
    {"tip-drop", kDegrees, &FrameDetails::tip_drop, nullptr, TipDrop},
    {"pad-length", kMillimetres, &FrameDetails::pad_length, nullptr, PadLength},
    {"pad-width", kMillimetres, &FrameDetails::pad_width, nullptr, PadWidth},
}};

}  // namespace

double DeepestGroove(const FrameDesign& d) {
  const double lip = GrooveLip(d.details.groove_width / d.depth());
  return 0.5 * (kDeepestGroove - lip) * Thinnest(d);
}

std::optional<double> DetailRule::Value(const FrameDesign& design) const {
  if (member != nullptr) return design.details.*member;
  // An absent width is d1, which need not hold a hinge; the other absent lengths are the paper's and fit.
  if (optional_member == &FrameDetails::arm_width && design.details.hinge != HingeForm::kNone) {
    return design.arm_width();
  }
  return design.details.*optional_member;
}

std::string DetailRule::Text(double value) const {
  switch (unit) {
    case kMillimetres:
      return fmt::format("{:.3f} mm", value);
    case kDegrees:
      return fmt::format("{:.2f} degrees", DegreesFromRadians(value));
    case kDioptres:
      return fmt::format("{:.2f} dioptres", value);
  }
  return {};
}

std::span<const DetailRule> DetailRules() { return kRules; }

}  // namespace annulus
