#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "modeling/glasses/frame.h"

namespace annulus {

/// What a body holds. Overlaps of its shells are counted once.
struct BodyMass {
  std::string name;
  double volume = 0.0;                                          ///< mm³.
  double mass = 0.0;                                            ///< g.
  Eigen::Vector3d centre_of_gravity = Eigen::Vector3d::Zero();  ///< Frame frame, mm.
};

/// A frame's mass, temples open, without lenses and screws.
struct FrameMass {
  std::vector<BodyMass> bodies;                                 ///< As FrameBodies.
  double volume = 0.0;                                          ///< mm³.
  double mass = 0.0;                                            ///< g.
  Eigen::Vector3d centre_of_gravity = Eigen::Vector3d::Zero();  ///< Frame frame, mm.
};

/// Volume and first moments of each body: the exact ones of its shells, less what overlaps, which is measured on
/// columns along y through the places where shells' boxes meet. Volume within 1 % (of a small
/// body 2 %), centre of gravity within 0.3 mm of the union's. `density` in g/cm³: acetate 1.28, nylon 1.01,
/// titanium 4.5.
[[nodiscard]] FrameMass MassOf(const Frame& frame, double density);

}  // namespace annulus
