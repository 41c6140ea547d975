#pragma once

#include <Eigen/Core>

#include "modeling/elastic/hex_element.h"

namespace annulus {

/// An element in a deformed state: it is turned so that its strain energy is least. Then its inner forces have no
/// moment, and the energy's gradient is that of a fixed rotation (envelope theorem).
struct TurnedElement {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< Turns the shape at rest into the deformed state.
  HexCorners turned_back;                                  ///< Rᵀx about the corners' mean, mm.
  HexCorners force;     ///< K(Rᵀx − X): inner forces, N, in the turned-back frame.
  double energy = 0.0;  ///< ½ (Rᵀx − X)ᵀ K (Rᵀx − X), N·mm.
};

/// The corners about their mean.
[[nodiscard]] HexCorners Centred(const HexCorners& corners);

/// The element without turning: linear elasticity. `rest` and `current` are the corners, mm.
[[nodiscard]] TurnedElement Unturned(const HexMatrix& stiffness, const HexCorners& rest, const HexCorners& current);

/// The element turned: Newton's method on the rotation, from the polar rotation of its mean deformation.
[[nodiscard]] TurnedElement Turned(const HexMatrix& stiffness, const HexCorners& rest, const HexCorners& current);

/// Second derivatives of the element's least energy by its corners, station frame, N/mm: K less what the rotation
/// gives way (Schur complement). May be indefinite under pressure.
[[nodiscard]] HexMatrix TurnedTangent(const HexMatrix& stiffness, const TurnedElement& element);

/// R K Rᵀ: the tangent at fixed rotation. Positive semidefinite; a step with it never raises the energy.
[[nodiscard]] HexMatrix FixedTangent(const HexMatrix& stiffness, const Eigen::Matrix3d& rotation);

}  // namespace annulus
