#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "base/result.h"
#include "modeling/clay/clay_operation.h"

namespace annulus {

/// An axis of a script, before the body is there: each end a place on it, or a point.
using ClayEnd = std::variant<ClayAddress, Eigen::Vector3d>;

/// One line of a script. Twisting and stretching name their axis by its ends, a tool may be held to where the skin is
/// nearest to a point; both are looked up when their turn comes.
struct ClayStep {
  ClayAct act;
  std::optional<std::array<ClayEnd, 2>> axis{};
  std::optional<Eigen::Vector3d> near{};
};

/// A file of operations (docs/formats.md, "Clay operations"): what was done to a body, one after the other. The same
/// script on the same body gives the same bytes.
struct ClayScript {
  ClayPractice practice;
  std::vector<ClayStep> steps;
};

/// Reads a script. `name` of the file is for messages, which name the operation and the key. Parameters are held
/// against their ranges when the operation is carried out.
Result<ClayScript> ClayScriptFromJson(std::string_view text, std::string_view name);

/// The step's act with its axis in space and its tool on the body.
[[nodiscard]] ClayAct ActOn(const ClayBody& body, const ClayStep& step);

/// Carries out a step.
Result<ClayReport> Perform(ClayBody& body, const ClayStep& step, const ClayPractice& practice);

}  // namespace annulus
