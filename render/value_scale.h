#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/colour_map.h"

namespace annulus {

/// The light of a map on a body: colours are multiplied by kMapShade … 1 in linear light, so little that they can still
/// be read off the legend.
inline constexpr float kMapShade = 0.85F;

/// From a value to its colour and back.
struct ValueScale {
  ColourMap map = ColourMap::kDiverging;
  double minimum = -1.0;  ///< Value of the first colour; what is below has it too.
  double maximum = 1.0;   ///< Value of the last colour, > minimum; what is above has it too.
  /// Of what is below the minimum, where that means something else (inside of what the distance is measured to).
  std::optional<LinearRgb> under{};
  std::optional<LinearRgb> over{};  ///< The same for what is above the maximum.

  /// nan gives kNoDataColour.
  [[nodiscard]] LinearRgb ColourOf(double value) const;
  /// The value whose colour, darkened by a factor kMapShade … 1, is nearest to `colour`: what a reader with a legend
  /// and a ruler would find. Of an 8-bit picture it is right to 1 % of the scale's length.
  [[nodiscard]] double ValueOf(const LinearRgb& colour) const;
};

/// A class of a map of classes.
struct MapCategory {
  std::string label;
  LinearRgb colour = LinearRgb::Zero();
};

/// How the two ends of a scale are chosen so that it holds a share of the values.
enum class ScaleRule {
  kAboutZero,    ///< Signed values: ± the amount that this share does not exceed.
  kFromZero,     ///< Amounts: from 0 to what this share does not exceed.
  kPercentiles,  ///< Without the rest below and the rest above.
};

/// The share that a scale holds if nothing else is said.
inline constexpr double kScaleShare = 0.98;

/// What a set of values spans, and the ends of a scale for it.
struct ValueRange {
  double least = 0.0;
  double greatest = 0.0;
  double minimum = -1.0;  ///< Of the scale, on a round number outside of the rule's.
  double maximum = 1.0;   ///< Of the scale, > minimum.
  double below = 0.0;     ///< Share of the values under the minimum, 0 … 1.
  double above = 0.0;     ///< Share of the values over the maximum, 0 … 1.
  double mean = 0.0;
  double rms = 0.0;
  double weight = 0.0;  ///< Of all that is finite; 0: there is no value, and the rest are the defaults.
};

/// A value and what it counts.
struct WeightedValue {
  double value = 0.0;   ///< nan is left out.
  double weight = 1.0;  ///< > 0; an area, for values on a surface.
};

/// The range of the finite values by a rule. Requires a share in (1/2, 1].
[[nodiscard]] ValueRange RangeByRule(std::span<const WeightedValue> values, ScaleRule rule, double share = kScaleShare);
/// The same with the scale's ends given. Requires minimum < maximum.
[[nodiscard]] ValueRange RangeGiven(std::span<const WeightedValue> values, double minimum, double maximum);

}  // namespace annulus
