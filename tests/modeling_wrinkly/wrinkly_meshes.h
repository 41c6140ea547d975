#pragma once

#include <array>
#include <string>
#include <vector>

#include "modeling/wrinkly/control_mesh.h"
#include "modeling/wrinkly/control_nets.h"

namespace annulus {

/// Every kind of control mesh of paper 003, small.
inline const std::vector<std::string>& MeshKinds() {
  static const std::vector<std::string> kinds{"regular:4x3",    "tube:5x3",       "torus:3x4",      "torus:1x1",
                                              "bordered:3x2",   "directions:2x2", "directions:3x2", "directions:4x2",
                                              "directions:5x1", "directions:6x1", "ring:6x3",       "spiral:6x21"};
  return kinds;
}

inline ControlMesh NetMesh(const std::string& kind) { return ControlMesh::Make(MakeNet(kind).value()).value(); }

/// The net with heights −1 … 1 mm without pattern.
inline ControlMeshParts RoughNet(const std::string& kind, std::uint64_t seed = 1) {
  ControlMeshParts parts = MakeNet(kind).value();
  for (Eigen::Index k = 0; k < parts.values.rows(); ++k) {
    parts.values(k, 0) = 2.0 * ScatteredNumber(seed, static_cast<std::uint64_t>(k)) - 1.0;
  }
  return parts;
}

}  // namespace annulus
