#pragma once

#include <cstdint>
#include <vector>

#include "base/result.h"
#include "modeling/wrinkly/control_mesh.h"
#include "modeling/wrinkly/shuffle.h"

namespace annulus {

/// A place of a mesh's parameter domain at a depth of iterations: a smallest cell of a patch, and where in it.
struct MeshPlace {
  PointIndex patch = 0;
  std::uint32_t u_code = 0;  ///< Smallest interval along the patch's U, 0 … parts − 1.
  std::uint32_t v_code = 0;
  double u_rest = 0.5;  ///< Within it, 0 … 1.
  double v_rest = 0.5;
};

/// In which order the axes are shuffled (paper 003, §3.2.4). On regular meshes both are the same.
enum class ShuffleOrder { kUThenV, kVThenU };

/// Two-dimensional iterated shuffle transformation of a control mesh (paper 003, eqs. 10, 11): first along the axes of
/// one family, then along those of the other. Along an axis of U the V parameter is carried over to the axis of V that
/// the patch reached lies on (eq. 8): kept, or turned round where that one runs the other way. One-to-one. Borrows the
/// mesh. Thread-safe.
class MeshShuffle {
 public:
  MeshShuffle(const ControlMesh& mesh, Shuffle u, Shuffle v) : mesh_(&mesh), u_(std::move(u)), v_(std::move(v)) {}

  [[nodiscard]] const Shuffle& u() const { return u_; }
  [[nodiscard]] const Shuffle& v() const { return v_; }

  /// Where the value that is seen at a place comes from (inverse), and where that of a place goes to (forward).
  [[nodiscard]] MeshPlace Source(const MeshPlace& destination, ShuffleOrder order) const;
  [[nodiscard]] MeshPlace Destination(const MeshPlace& source, ShuffleOrder order) const;

 private:
  void AlongU(MeshPlace& place, const AxisPart& part) const;
  void AlongV(MeshPlace& place, const AxisPart& part) const;

  const ControlMesh* mesh_;
  Shuffle u_;
  Shuffle v_;
};

}  // namespace annulus
