#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "modeling/glasses/frame_parameters.h"

namespace annulus {
namespace {

constexpr double kStyleWidth = 50.0;

/// Roundness of the corners in the order [1] upper outer, [2] upper inner, [3] lower outer, [4] lower inner.
using Corners = std::array<Roundness, 4>;

/// Shares of l1.
struct Proportions {
  double height;           ///< l2
  double upper_thickness;  ///< d1
  double lower_thickness;  ///< d2
  double bridge_height;    ///< l3, share of l2
};

FrameParameters FromWords(const Corners& corners, const Proportions& shares) {
  FrameParameters p;
  p.width = kStyleWidth;
  p.height = shares.height * kStyleWidth;
  const double shorter = std::min(p.width, p.height);
  p.upper_outer = RoundnessShare(corners[0]) * shorter;
  p.upper_inner = RoundnessShare(corners[1]) * shorter;
  p.lower_outer = RoundnessShare(corners[2]) * shorter;
  p.lower_inner = RoundnessShare(corners[3]) * shorter;
  p.upper_thickness = shares.upper_thickness * kStyleWidth;
  p.lower_thickness = shares.lower_thickness * kStyleWidth;
  p.bridge_height = shares.bridge_height * p.height;
  return p;
}

std::vector<FrameStyle> MakeStyles() {
  using enum Roundness;
  constexpr double kS = kDepthShare;
  // The paper gives words, aspect and d1 : d2 of its examples, not the bridge's height: 60 % of the height here.
  return {
      {"example1", "paper's frame example 1: nearly a square",
       FromWords({kQuiteSquare, kQuiteSquare, kQuiteSquare, kQuiteSquare}, {1.0, kS, kS, 0.6})},
      {"example2", "paper's frame example 2: nearly a circle",
       FromWords({kQuiteRound, kQuiteRound, kQuiteRound, kQuiteRound}, {1.0, kS, kS, 0.6})},
      {"example3", "paper's frame example 3: low, square above, round below",
       FromWords({kSlightlySquare, kSlightlySquare, kSlightlyRound, kSlightlyRound}, {0.7, kS, kS, 0.6})},
      {"example4", "paper's frame example 4: strong upper rim (d1 : d2 = 3 : 1), lower outer corner cut away",
       FromWords({kMiddle, kMiddle, kExtremelyRound, kSlightlyRound}, {0.8, 1.5 * kS, 0.5 * kS, 0.6})},
      {"round", "circle", FromWords({kQuiteRound, kQuiteRound, kQuiteRound, kQuiteRound}, {0.94, kS, kS, 0.62})},
      {"oval", "low and round",
       FromWords({kQuiteRound, kQuiteRound, kQuiteRound, kQuiteRound}, {0.7, 0.8 * kS, 0.8 * kS, 0.6})},
      {"square", "square with eased corners",
       FromWords({kSlightlySquare, kSlightlySquare, kSlightlySquare, kSlightlySquare},
                 {0.86, 1.2 * kS, 1.2 * kS, 0.64})},
      {"rectangle", "low rectangle",
       FromWords({kQuiteSquare, kQuiteSquare, kSlightlySquare, kSlightlySquare}, {0.6, kS, 0.8 * kS, 0.62})},
      {"boston", "broad above, round below",
       FromWords({kSlightlyRound, kSlightlyRound, kQuiteRound, kQuiteRound}, {0.88, 1.2 * kS, kS, 0.62})},
      {"aviator", "flat above, cut away towards the nose below",
       FromWords({kMiddle, kSlightlyRound, kQuiteRound, kExtremelyRound}, {0.88, kS, 0.8 * kS, 0.62})},
      {"wellington", "strong, broad top, eased lower corners",
       FromWords({kQuiteSquare, kSlightlySquare, kMiddle, kSlightlyRound}, {0.76, 1.6 * kS, 1.3 * kS, 0.6})},
  };
}

}  // namespace

const std::vector<FrameStyle>& FrameStyles() {
  static const std::vector<FrameStyle> styles = MakeStyles();
  return styles;
}

Result<FrameParameters> FindFrameStyle(std::string_view name) {
  std::string known;
  for (const FrameStyle& style : FrameStyles()) {
    if (style.name == name) return style.parameters;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", style.name);
  }
  return Fail("choose a frame style", fmt::format("there is no style '{}'", name), "choose one of " + known);
}

}  // namespace annulus
