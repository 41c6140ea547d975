#include "station/console/scan_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/frames.h"
#include "modeling/mesh/tessellate.h"
#include "station/console/mesh_bytes.h"

namespace annulus {
namespace {

/// A neutral surface, linear sRGB.
constexpr std::array<float, 4> kNeutral{0.55F, 0.55F, 0.57F, 1.0F};

TessellationOptions GridOf(const ScanMeshOptions& options) {
  TessellationOptions grid;
  grid.theta_count = static_cast<std::size_t>(std::clamp(std::lround(360.0 / options.step_deg), 12L, 1440L));
  grid.max_z_spacing_mm = options.step_mm;
  return grid;
}

std::vector<MeshPart> PartsOf(const SurfaceModel& model, const ScanMeshOptions& options) {
  std::vector<MeshPart> parts;
  for (const SurfaceSegment& segment : model.segments) {
    MeshPart part;
    part.colour = kNeutral;
    part.mesh = TessellateSurface(segment, GridOf(options));
    for (const Eigen::Vector3d& vertex : part.mesh.vertices) {
      const Eigen::Vector2d from_axis = vertex.head<2>() - segment.axis.At(vertex.z());
      const double theta = WrapAngle(std::atan2(from_axis.y(), from_axis.x()));
      const bool mapped = segment.knowledge.rows() > 0;
      // At the last height itself the map has no cell any more.
      const double z = mapped
                           ? std::clamp(vertex.z(), segment.knowledge.z_min() + 1e-6, segment.knowledge.z_max() - 1e-6)
                           : vertex.z();
      part.knowledge.push_back(mapped ? segment.knowledge.At(theta, z) : Knowledge::kMeasured);
    }
    if (!part.mesh.faces.empty()) parts.push_back(std::move(part));
  }
  return parts;
}

std::size_t TrianglesOf(const std::vector<MeshPart>& parts) {
  std::size_t triangles = 0;
  for (const MeshPart& part : parts) triangles += part.mesh.faces.size();
  return triangles;
}

}  // namespace

std::string ScanMesh(const SurfaceModel& model, const ScanMeshOptions& options) {
  ScanMeshOptions coarse = options;
  std::vector<MeshPart> parts = PartsOf(model, coarse);
  while (TrianglesOf(parts) > options.most_triangles) {
    const double share = static_cast<double>(TrianglesOf(parts)) / static_cast<double>(options.most_triangles);
    coarse.step_deg *= std::sqrt(share) * 1.01;
    coarse.step_mm *= std::sqrt(share) * 1.01;
    if (coarse.step_deg > 30.0) break;  // dozens of segments: as coarse as it gets
    parts = PartsOf(model, coarse);
  }
  return MeshBytes(parts);
}

}  // namespace annulus
