#include "sim/mesh_subject.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/ensure.h"
#include "modeling/mesh/convex_hull_2d.h"
#include "modeling/mesh/mesh_io.h"
#include "modeling/mesh/mesh_section.h"

namespace annulus::sim {
namespace {

TriangleMesh Placed(TriangleMesh mesh, const MeshPlacement& placement) {
  ENSURE(placement.scale > 0.0, "a mesh is scaled by a positive number");
  ENSURE(!mesh.vertices.empty(), "a mesh has vertices");
  const double cosine = std::cos(placement.yaw_rad);
  const double sine = std::sin(placement.yaw_rad);
  double lowest = 0.0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    Eigen::Vector3d p = mesh.vertices[i] * placement.scale;
    // The file's +x is the subject's left when y is up and z is forward: x × y = z leaves -x for the right.
    if (placement.up == UpAxis::kY) p = Eigen::Vector3d(-p.x(), p.z(), p.y());
    mesh.vertices[i] = {cosine * p.x() - sine * p.y() + placement.x_mm, sine * p.x() + cosine * p.y() + placement.y_mm,
                        p.z() + placement.z_mm};
    lowest = i == 0 ? mesh.vertices[i].z() : std::min(lowest, mesh.vertices[i].z());
  }
  if (placement.bottom_mm) {
    for (Eigen::Vector3d& vertex : mesh.vertices) vertex.z() += *placement.bottom_mm - lowest;
  }
  return mesh;
}

}  // namespace

MeshSubject::MeshSubject(TriangleMesh mesh, const MeshPlacement& placement, std::string name)
    : mesh_(Placed(std::move(mesh), placement)), bvh_(mesh_), name_(std::move(name)) {
  top_ = bottom_ = mesh_.vertices.front().z();
  for (const Eigen::Vector3d& vertex : mesh_.vertices) {
    top_ = std::max(top_, vertex.z());
    bottom_ = std::min(bottom_, vertex.z());
  }
}

Result<MeshSubject> MeshSubject::Load(Storage& storage, const std::string& path, const MeshPlacement& placement) {
  Result<TriangleMesh> mesh = ReadMesh(storage, path);
  if (!mesh) return Fail(mesh);
  const std::string file = path.substr(path.find_last_of('/') + 1);
  return MeshSubject(*std::move(mesh), placement, file.substr(0, file.find_last_of('.')));
}

std::optional<SubjectHit> MeshSubject::Cast(const Ray& ray, double /*time_s*/, double max_distance_mm) const {
  const std::optional<MeshHit> hit = bvh_.Cast(ray, max_distance_mm);
  if (!hit) return std::nullopt;
  return SubjectHit{hit->distance_mm, hit->normal, 1.0};
}

std::vector<SectionTruth> MeshSubject::Sections(double z) const {
  std::vector<SectionTruth> sections;
  for (const SectionLoop& loop : SliceMesh(mesh_, z)) {
    if (!loop.closed) continue;
    sections.push_back({z, loop.perimeter_mm, ConvexHullPerimeter(loop.points), loop.area_mm2});
  }
  return sections;
}

double MeshSubject::Volume(double z0, double z1) const { return SlabVolume(mesh_, z0, z1); }

}  // namespace annulus::sim
