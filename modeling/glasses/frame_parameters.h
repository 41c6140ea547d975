#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace annulus {

/// Lengths that paper 000 keeps constant, as shares of l1 = |P1P2|.
inline constexpr double kBridgeGapShare = 1.0 / 5.0;  ///< l0: distance between the two rectangles P1P2P3P4 (§3.5).
inline constexpr double kDepthShare =
    1.0 / 20.0;  ///< s: depth of the control polygon (§3.4); the solid is 0.75·s thick.
inline constexpr double kArmSegmentShare = 1.0 / 10.0;  ///< l4, l5 (arm F) and l7, l8, l9 (arm R) (§3.5).
/// Distance of the rim centres O0, O0' as a share of l1: l1 + l0 (step 1 of §5 makes this the pupillary distance).
inline constexpr double kRimSpacingShare = 1.0 + kBridgeGapShare;

/// What the user chooses of a frame: the eight parameters of paper 000 (figs. 1, 10, 15) and the size l1. All in mm.
/// A corner's roundness is the cut t_i = |P_i M_i| between the corner of the rectangle P1P2P3P4 and the octagon's point
/// M: 0 is a sharp corner. l1 and l2 are the rectangle of the rim's centre line, not the boxing system's A and B.
struct FrameParameters {
  double width = 50.0;           ///< l1 = |P1P2|.
  double upper_outer = 8.0;      ///< [1] |P1 M0|.
  double upper_inner = 8.0;      ///< [2] |P2 M3|.
  double lower_outer = 8.0;      ///< [3] |P4 M9|.
  double lower_inner = 8.0;      ///< [4] |P3 M6|.
  double upper_thickness = 2.5;  ///< [1,2] d1.
  double lower_thickness = 2.5;  ///< [3,4] d2.
  double height = 40.0;          ///< [5] l2 = |P1P4|.
  double bridge_height = 24.0;   ///< [6] l3, from P3P4 to the centre line of bridge and arms.

  /// l0, mm.
  [[nodiscard]] double bridge_gap() const { return kBridgeGapShare * width; }
  /// s, mm.
  [[nodiscard]] double depth() const { return kDepthShare * width; }
  /// l4 = l5 = l7 = l8 = l9, mm.
  [[nodiscard]] double arm_segment() const { return kArmSegmentShare * width; }
  /// Distance of the rim centres O0, O0', mm.
  [[nodiscard]] double rim_spacing() const { return kRimSpacingShare * width; }

  [[nodiscard]] bool operator==(const FrameParameters&) const = default;
};

/// Everything multiplied by width / parameters.width. Requires width > 0.
[[nodiscard]] FrameParameters ScaledToWidth(const FrameParameters& parameters, double width);

/// Whether a frame can be built from these: finite; lengths positive; adjoining cuts t_i + t_j <= side/√2, and so that
/// the inner outline keeps a positive edge (cuts >= d·tan(22.5°)/2); the bridge's and arms' height within the straight
/// sides between M3 and M6 and between M0 and M9. The error names the parameter and its permitted range.
[[nodiscard]] Status Validate(const FrameParameters& parameters);

/// Words for a corner's roundness (paper 000, §3.4), as t / min(l1, l2). kQuiteRound makes a square rim a circle of
/// radius 0.911·l1/2; beyond it corners are cut more than a circle's.
enum class Roundness { kQuiteSquare, kSlightlySquare, kMiddle, kSlightlyRound, kQuiteRound, kExtremelyRound };

/// All words, the squarest first.
inline constexpr std::array kRoundnessWords{Roundness::kQuiteSquare, Roundness::kSlightlySquare,
                                            Roundness::kMiddle,      Roundness::kSlightlyRound,
                                            Roundness::kQuiteRound,  Roundness::kExtremelyRound};
/// t / min(l1, l2) of a word.
[[nodiscard]] double RoundnessShare(Roundness roundness);
/// "quite square", … "extremely round".
[[nodiscard]] std::string_view RoundnessWord(Roundness roundness);

/// One of the eight parameters (and the size) as commands and files name it.
struct FrameParameterField {
  std::string_view option;  ///< "upper-outer": the command line's --upper-outer.
  std::string_view key;     ///< "upper_outer_mm" in FRAME.json.
  double FrameParameters::*member;
  std::string_view description;  ///< One line, with the paper's symbol.
};
/// All nine, in the paper's order, the size first.
[[nodiscard]] std::span<const FrameParameterField> FrameParameterFields();

}  // namespace annulus
