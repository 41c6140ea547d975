#include "modeling/glasses/frame_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr const char* kAttempt = "check the frame's parameters";

/// tan(22.5°): an octagon's edge loses this much of an inward offset at each end.
const double kMitre = std::numbers::sqrt2 - 1.0;

constexpr std::array<FrameParameterField, 9> kFields{{
    {"width", "width_mm", &FrameParameters::width, "l1, width of the rim's centre line (scales the whole frame)"},
    {"upper-outer", "upper_outer_mm", &FrameParameters::upper_outer,
     "[1] roundness of the upper outer corner, |P1 M0|"},
    {"upper-inner", "upper_inner_mm", &FrameParameters::upper_inner,
     "[2] roundness of the upper inner corner, |P2 M3|"},
    {"upper-thickness", "upper_thickness_mm", &FrameParameters::upper_thickness,
     "[1,2] d1, thickness of the upper rim"},
    {"lower-outer", "lower_outer_mm", &FrameParameters::lower_outer,
     "[3] roundness of the lower outer corner, |P4 M9|"},
    {"lower-inner", "lower_inner_mm", &FrameParameters::lower_inner,
     "[4] roundness of the lower inner corner, |P3 M6|"},
    {"lower-thickness", "lower_thickness_mm", &FrameParameters::lower_thickness,
     "[3,4] d2, thickness of the lower rim"},
    {"height", "height_mm", &FrameParameters::height, "[5] l2, height of the rim's centre line"},
    {"bridge-height", "bridge_height_mm", &FrameParameters::bridge_height,
     "[6] l3, height of bridge and temples over the lower edge"},
}};

struct Range {
  double low;
  double high;
};

Status CheckRange(std::string_view option, double value, Range range, std::string_view why) {
  if (value >= range.low && value <= range.high) return {};
  return Fail(kAttempt, fmt::format("{} is {:.3f} mm, {}", option, value, why),
              range.low <= range.high ? fmt::format("choose {} from {:.3f} to {:.3f} mm", option, range.low, range.high)
                                      : fmt::format("no {} fits the other parameters: make the rim thinner or the "
                                                    "corners squarer",
                                                    option));
}

/// Sizes, as shares of l1 where they only have to look like spectacles.
Status CheckSizes(const FrameParameters& p) {
  RETURN_IF_ERROR(CheckRange("width", p.width, {10.0, 200.0}, "which no face needs"));
  const Range thickness{0.01 * p.width, 0.25 * p.width};
  RETURN_IF_ERROR(CheckRange("height", p.height, {0.3 * p.width, 1.5 * p.width}, "outside 30 … 150 % of the width"));
  RETURN_IF_ERROR(CheckRange("upper-thickness", p.upper_thickness, thickness, "outside 1 … 25 % of the width"));
  return CheckRange("lower-thickness", p.lower_thickness, thickness, "outside 1 … 25 % of the width");
}

/// A corner's cut may not be so small that the inner outline turns over at the corner.
Status CheckCorners(const FrameParameters& p) {
  const auto check = [&p](std::string_view option, double cut, double thickness) {
    return CheckRange(option, cut, {0.5 * kMitre * thickness, p.width}, "too square for this thickness of the rim");
  };
  RETURN_IF_ERROR(check("upper-outer", p.upper_outer, p.upper_thickness));
  RETURN_IF_ERROR(check("upper-inner", p.upper_inner, p.upper_thickness));
  RETURN_IF_ERROR(check("lower-outer", p.lower_outer, p.lower_thickness));
  return check("lower-inner", p.lower_inner, p.lower_thickness);
}

/// One side of the rectangle: t_i + t_j <= side/√2 on the centre line, less what the inner outline loses by its offset.
struct Side {
  std::string_view first;
  std::string_view second;
  double cuts;
  double length;
  double thickness;
};

Status CheckSides(const FrameParameters& p) {
  const double mean = 0.5 * (p.upper_thickness + p.lower_thickness);
  const std::array<Side, 4> sides{{
      {"upper-outer", "upper-inner", p.upper_outer + p.upper_inner, p.width, p.upper_thickness},
      {"lower-outer", "lower-inner", p.lower_outer + p.lower_inner, p.width, p.lower_thickness},
      {"upper-inner", "lower-inner", p.upper_inner + p.lower_inner, p.height, mean},
      {"upper-outer", "lower-outer", p.upper_outer + p.lower_outer, p.height, mean},
  }};
  for (const Side& side : sides) {
    const double limit = (side.length - kMitre * side.thickness) / std::numbers::sqrt2;
    // A billionth of slack: a word scaled with the frame must not fall over the edge by rounding.
    if (side.cuts <= limit * (1.0 + 1e-9)) continue;
    return Fail(kAttempt,
                fmt::format("{} and {} add up to {:.3f} mm, more than their side of {:.3f} mm holds", side.first,
                            side.second, side.cuts, side.length),
                fmt::format("make either squarer: together at most {:.3f} mm", limit));
  }
  return {};
}

/// Bridge and temples end on the straight sides M3…M6 and M9…M0, with their whole width.
Status CheckBridge(const FrameParameters& p) {
  const double low = std::max(p.lower_inner, p.lower_outer) / std::numbers::sqrt2 + 0.5 * p.upper_thickness;
  const double high = p.height - std::max(p.upper_inner, p.upper_outer) / std::numbers::sqrt2 - 0.5 * p.upper_thickness;
  return CheckRange("bridge-height", p.bridge_height, {low, high}, "beside the rim's sides");
}

}  // namespace

FrameParameters ScaledToWidth(const FrameParameters& parameters, double width) {
  ENSURE(parameters.width > 0.0 && width > 0.0, "a frame has a width");
  FrameParameters scaled = parameters;
  const double factor = width / parameters.width;
  for (const FrameParameterField& field : kFields) scaled.*field.member *= factor;
  scaled.width = width;
  return scaled;
}

Status Validate(const FrameParameters& parameters) {
  for (const FrameParameterField& field : kFields) {
    if (!std::isfinite(parameters.*field.member) || parameters.*field.member <= 0.0) {
      return Fail(kAttempt, fmt::format("{} is {} mm", field.option, parameters.*field.member),
                  "every length of a frame is a positive number");
    }
  }
  RETURN_IF_ERROR(CheckSizes(parameters));
  RETURN_IF_ERROR(CheckCorners(parameters));
  RETURN_IF_ERROR(CheckSides(parameters));
  return CheckBridge(parameters);
}

double RoundnessShare(Roundness roundness) {
  switch (roundness) {
    case Roundness::kQuiteSquare:
      return 0.05;
    case Roundness::kSlightlySquare:
      return 0.12;
    case Roundness::kMiddle:
      return 0.16;
    case Roundness::kSlightlyRound:
      return 0.20;
    case Roundness::kQuiteRound:
      return 0.2516;
    case Roundness::kExtremelyRound:
      return 0.32;
  }
  ENSURE(false, "every word has a share");
}

std::string_view RoundnessWord(Roundness roundness) {
  switch (roundness) {
    case Roundness::kQuiteSquare:
      return "quite square";
    case Roundness::kSlightlySquare:
      return "slightly square";
    case Roundness::kMiddle:
      return "middle";
    case Roundness::kSlightlyRound:
      return "slightly round";
    case Roundness::kQuiteRound:
      return "quite round";
    case Roundness::kExtremelyRound:
      return "extremely round";
  }
  ENSURE(false, "every roundness has a word");
}

std::span<const FrameParameterField> FrameParameterFields() { return kFields; }

}  // namespace annulus
