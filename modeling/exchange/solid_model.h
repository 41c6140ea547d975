#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/bezier/patch_shell.h"
#include "modeling/mesh/triangle_mesh.h"

class TopoDS_Shape;

namespace annulus {

/// What becomes one solid: closed shells that overlap.
struct ShellBody {
  std::string name;
  std::vector<PatchShell> shells;
};

/// One body as a boundary representation. A value; copies share what never changes.
class SolidBody {
 public:
  [[nodiscard]] const std::string& name() const { return name_; }
  /// The solids do not overlap; false: those of the shells lie in each other, each valid for itself.
  [[nodiscard]] bool fused() const { return fused_; }
  [[nodiscard]] std::size_t pieces() const;
  /// mm³ by Open CASCADE; of solids that are not fused the sum, overlaps counted twice.
  [[nodiscard]] double volume() const { return volume_; }
  /// How the fusion was had, or why it was not; one line.
  [[nodiscard]] const std::string& note() const { return note_; }
  /// For the writers in this folder.
  [[nodiscard]] const std::vector<TopoDS_Shape>& shapes() const { return *shapes_; }

 private:
  friend Result<SolidBody> SolidBodyOf(const ShellBody& body);
  SolidBody() = default;

  std::string name_;
  std::shared_ptr<const std::vector<TopoDS_Shape>> shapes_;  // shared: a shape is immutable here
  bool fused_ = false;
  double volume_ = 0.0;
  std::string note_;
};

/// Every shell becomes a solid, then they are united (Open CASCADE's Boolean operations, five ways in turn). A union
/// counts only if Open CASCADE finds it valid, it has no more pieces than the shells hang together to, and its volume
/// is that of the shells' union within 0.1 % and 2 % of their overlap; both are found without Open CASCADE
/// (OverlapVolume). If no way leads there the separate solids are kept, and note() says so. Fails if a shell is no
/// solid.
[[nodiscard]] Result<SolidBody> SolidBodyOf(const ShellBody& body);

/// The skin of a body as a mesh whose triangles are within `deflection` mm of it, closed in float32 (InFloats). One
/// skin round each piece if the body is fused. Fails if the mesh does not close.
[[nodiscard]] Result<TriangleMesh> SkinOf(const SolidBody& body, double deflection);

}  // namespace annulus
