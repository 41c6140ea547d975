/// The readers of control meshes: JSON and OBJ. Beyond "no crash": what is read is a mesh or refused in one line, and a
/// mesh's transformation undoes itself everywhere, however it was cut.
#include <cstdint>
#include <string_view>

#include "base/ensure.h"
#include "modeling/wrinkly/base_surface.h"
#include "modeling/wrinkly/control_mesh_json.h"
#include "modeling/wrinkly/mesh_shuffle.h"
#include "modeling/wrinkly/quad_mesh.h"

namespace {

using namespace annulus;

constexpr std::size_t kMostPoints = 400;

void CheckShuffle(const ControlMesh& mesh) {
  const MeshShuffle shuffle(mesh, Shuffle::Make(1, 2).value(), Shuffle::Make(2, 1).value());
  for (std::size_t k = 0; k < mesh.size(); ++k) {
    if (!mesh.HasPatch(static_cast<PointIndex>(k))) continue;
    for (const ShuffleOrder order : {ShuffleOrder::kUThenV, ShuffleOrder::kVThenU}) {
      for (std::uint32_t u = 0; u < shuffle.u().parts(); u += 2) {
        const MeshPlace place{static_cast<PointIndex>(k), u, u % shuffle.v().parts()};
        const MeshPlace back = shuffle.Destination(shuffle.Source(place, order), order);
        ENSURE(back.patch == place.patch && back.u_code == place.u_code && back.v_code == place.v_code,
               "the transformation is one-to-one");
      }
    }
  }
}

void Use(ControlMeshParts parts) {
  if (parts.points.size() > kMostPoints) return;
  for (const FamilyRule rule : {FamilyRule::kRefuse, FamilyRule::kCut}) {
    const auto mesh = ControlMesh::Make(parts, rule);
    if (!mesh) {
      ENSURE(mesh.error().Text().find('\n') == std::string::npos, "a message is one line");
      continue;
    }
    CheckShuffle(*mesh);
    for (const CornerJoin join : {CornerJoin::kPaper, CornerJoin::kRounded}) {
      const auto surface = BaseSurface::Make(*mesh, join);
      if (surface) (void)MeasureBaseJoins(*mesh, *surface);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (auto parts = ControlMeshFromJson(text, "fuzz")) {
    const std::string written = ControlMeshToJson(*parts);
    const auto again = ControlMeshFromJson(written, "written");
    ENSURE(again.has_value(), again ? "" : again.error().Text());
    ENSURE(ControlMeshToJson(*again) == written, "a mesh reads back as the same bytes");
    Use(std::move(*parts));
  }
  for (const PolygonRule rule : {PolygonRule::kRefuse, PolygonRule::kSplit}) {
    const auto quads = QuadMeshFromObj(text, "fuzz", rule);
    if (!quads) continue;
    if (auto parts = ControlMeshOfQuads(*quads)) Use(std::move(*parts));
  }
  return 0;
}
