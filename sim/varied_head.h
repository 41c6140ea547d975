#pragma once

#include <array>

#include "sim/parametric_body.h"

namespace annulus::sim {

/// What differs between the sides of a head; [0] is the subject's right, [1] the left.
using Sides = std::array<double, 2>;

/// An adult's head in the measures in which people differ. Lengths in mm. "Forward" is +y before the placement's yaw;
/// heights are above the floor, or above a named place. The defaults are a middling head.
struct HeadVariation {
  double eye_z = 1584.0;  ///< Mean height of the eye centres above the floor, 1400 … 1800.
  double size = 1.0;      ///< Factor on the skull and the face's heights, 0.92 … 1.08.
  double breadth = 1.0;   ///< Further factor on the skull's breadth, 0.92 … 1.08.
  double depth = 1.0;     ///< Further factor on the skull's depth behind the face, 0.92 … 1.08.

  Sides eye_lateral{31.5, 31.5};    ///< From the mid-plane to the eyeball's centre, 26 … 38.
  Sides eye_above{0.0, 0.0};        ///< Eyeball's centre above eye_z.
  Sides eye_forward{-10.0, -10.0};  ///< The cornea's apex before the sellion, -15 … -6.
  double eyeball_radius = 12.2;     ///< With the lid that covers it, 11 … 13.5.
  double lid_fold = 0.6;            ///< How far the lids' edges stand out of the eyeball, 0 … 1.5.
  double socket_depth = 3.5;        ///< From the cornea back to the hollow between eye and nose, 2 … 5.

  double sellion_above = 7.0;     ///< Above eye_z, 1 … 14.
  double sellion_forward = 4.0;   ///< Before the skull's own outline, 1 … 8.
  double nose_length = 39.0;      ///< Sellion down to pronasale, 33 … 46.
  double nose_protrusion = 21.0;  ///< Pronasale before sellion, 15 … 27.
  double nose_hump = 0.0;         ///< Of the bridge, half-way: positive is a hump, -1.5 … 2.
  double root_width = 7.0;        ///< Where its flanks are steepest at the root, beside the ridge, 6 … 8.5.
  double tip_width = 8.5;         ///< The same at the tip, 7.5 … 10.
  double ridge_flatness = 0.45;   ///< Share of the nose that is flat-topped and steep-sided, 0.2 … 0.7.
  double root_right = 0.0;        ///< The nose's root from the mid-plane, to the right, ±1.2.
  double tip_right = 0.0;         ///< The tip from the mid-plane, ±2.
  Sides flank_bulge{0.0, 0.0};    ///< How much fuller the nose's flank is, ±0.8.

  double glabella_forward = 4.0;      ///< Before the sellion, 2 … 8.
  Sides brow{4.0, 4.0};               ///< Prominence of the brow above the eye, 1.5 … 6.5.
  Sides cheek{5.0, 5.0};              ///< Prominence of the cheekbone, 2.5 … 8.
  Sides ear_above{-26.0, -26.0};      ///< The ear's middle above eye_z, -36 … -16.
  Sides ear_behind{10.0, 10.0};       ///< The ear's middle behind the ring's axis' frontal plane, 3 … 18.
  Sides ear_protrusion{17.0, 17.0};   ///< Largest relief of the shell, 12 … 21.
  Sides ear_half_height{31.0, 31.0};  ///< From its middle up to where it leaves the head, 27 … 35.
  Placement placement{};
};

/// The head, on a neck with a smooth closed bottom 188 mm below the eyes (at size 1). Its eyes are balls in their
/// sockets, under lids: face() gives the point of the surface straight before each ball's centre. The ridge of the nose
/// goes through what was asked for to 0.2 mm. Requires the ranges above.
[[nodiscard]] ParametricBody MakeVariedHead(const HeadVariation& variation);
/// The same head with its ears taken off: what a spectacle temple passes beside.
[[nodiscard]] ParametricBody MakeVariedHeadWithoutEars(const HeadVariation& variation);

}  // namespace annulus::sim
