#pragma once

#include <string>

#include "render/colour.h"

namespace annulus {

/// A colour by hue, value and chroma as Munsell's system orders them, by the mathematical transform of Miyahara and
/// Yoshida (paper 000, reference 9): equal steps look about equally large.
///
/// With X, Y, Z of the colour over those of white (sRGB's D65 turned to illuminant C by Bradford's matrix) and Adams'
/// v(a) = 11.6 ∛a − 1.6:
///
///     M1 = v(X) − v(Y)    M2 = 0.4 (v(Z) − v(Y))    V = v(Y)        θ = the angle of (M1, M2)
///     S1 = (8.880 + 0.966 cos θ) M1    S2 = (8.025 + 2.558 sin θ) M2    H = the angle of (S1, −S2)    C = |S|
///
/// Below a = 0.00886 the cube root is continued by CIE's straight line, so that black has V = 0 and no slope is
/// infinite. Against the 1943 renotation's 1614 samples of value >= 2 and chroma 4 … 14: hue within 1.6 of Munsell's
/// 100 steps in the mean and 6.5 at most, value within 0.11, chroma within 0.56 in the mean and 2.2 at most.
struct Hvc {
  double hue = 0.0;  ///< rad, 0 … 2π; Munsell's 100 hues from 10RP: 5R at 0.314, 5Y 1.57, 5G 2.83, 5B 4.08, 5P 5.34.
  double value = 0.0;   ///< 0 (black) … 10 (white).
  double chroma = 0.0;  ///< >= 0; the most vivid displayed colours have 13 … 28.
};

/// Hue, value and chroma of a colour. Any finite colour; a grey's chroma is below 1e-4 and its hue means nothing.
[[nodiscard]] Hvc HvcFromRgb(const LinearRgb& colour);

/// The colour of a hue, value and chroma; channels outside 0 … 1 where no display shows it.
[[nodiscard]] LinearRgb RgbFromHvc(const Hvc& hvc);

/// The greatest chroma that a display shows at this hue and value; 0 at and beyond black and white.
[[nodiscard]] double GreatestChroma(double hue, double value);

/// The colour, where a display shows it; else that of the same hue and value and GreatestChroma. Value is held to
/// 0 … 10.
[[nodiscard]] LinearRgb ShownRgb(const Hvc& hvc);

/// dark ⇔ bright (paper 000, §6.1): 0 leaves the colour alone, 1 is white, −1 black; value goes there evenly. Hue
/// stays, chroma too as far as it can be shown. Requires -1 <= share <= 1.
[[nodiscard]] LinearRgb Brightened(const LinearRgb& colour, double share);

/// dull ⇔ vivid: 0 leaves the colour alone, −1 is the grey of its value, 1 the most vivid colour of its hue and value
/// that is shown; chroma goes there evenly. Hue and value stay. Grey has no hue and stays. Requires -1 <= share <= 1.
[[nodiscard]] LinearRgb Vivified(const LinearRgb& colour, double share);

/// The most vivid colour of a hue (rad) that is shown, of whatever value: a point of the edges of the colour cube.
[[nodiscard]] LinearRgb PureColour(double hue);

/// "5.2YR 4.1/6.3", as Munsell colours are written; "N 4.1" of a grey (chroma below 0.15).
[[nodiscard]] std::string MunsellText(const Hvc& hvc);

}  // namespace annulus
