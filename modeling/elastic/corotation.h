#pragma once

#include <Eigen/Core>

#include "modeling/elastic/hex_element.h"

namespace annulus {

/// An element in a deformed state, seen turned back by the polar rotation of its mean deformation.
struct TurnedElement {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< Turns the shape at rest into the deformed state.
  HexCorners turned_back;                                  ///< y = Rᵀx about the corners' mean, mm.
  /// Derivative of the energy by x, N, turned back: K(y − X) and what the rotation's own change adds. Has no moment.
  HexCorners force;
  double energy = 0.0;  ///< ½ (y − X)ᵀ K (y − X), N·mm.
  /// How the rotation follows the corners: ω = spin · Rᵀdx, turned back.
  Eigen::Matrix<double, 3, 24> spin = Eigen::Matrix<double, 3, 24>::Zero();
};

/// Which second derivatives a step uses.
enum class ElasticTangent {
  kFull,         ///< With those of the rotation (but for the change of `spin`): may be indefinite under pressure.
  kGaussNewton,  ///< Those of the strains alone: positive semidefinite, so that its step always leads down.
  kUnturned,     ///< Those of elements that do not turn (linear elasticity): their stiffness.
};

/// The corners about their mean.
[[nodiscard]] HexCorners Centred(const HexCorners& corners);

/// The element without turning: linear elasticity. `rest` and `current` are the corners, mm.
[[nodiscard]] TurnedElement Unturned(const HexMatrix& stiffness, const HexCorners& rest, const HexCorners& current);

/// The element turned by its polar rotation.
[[nodiscard]] TurnedElement Turned(const HexMatrix& stiffness, const HexCorners& rest, const HexCorners& current);

/// Second derivatives of the element's energy by its corners, station frame, N/mm.
[[nodiscard]] HexMatrix ElementTangent(const HexMatrix& stiffness, const TurnedElement& element,
                                       ElasticTangent tangent);

}  // namespace annulus
