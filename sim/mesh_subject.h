#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/storage.h"
#include "modeling/mesh/bvh.h"
#include "modeling/mesh/triangle_mesh.h"
#include "sim/section_truth.h"
#include "sim/subject.h"

namespace annulus::sim {

enum class UpAxis {
  kZ,  ///< The file's z is up, its y is the subject's front.
  kY,  ///< The file's y is up and its z is the subject's front, as most modellers write.
};

/// How a mesh file is put into the booth: axes, then scale, then yaw, then offset; last the height if one is asked for.
struct MeshPlacement {
  UpAxis up = UpAxis::kZ;
  double scale = 1.0;               ///< mm per unit of the file, > 0.
  double yaw_rad = 0.0;             ///< rad about z, counter-clockwise seen from above.
  double x_mm = 0.0;                ///< mm.
  double y_mm = 0.0;                ///< mm.
  double z_mm = 0.0;                ///< mm; not used if bottom_mm is given.
  std::optional<double> bottom_mm;  ///< Put the lowest vertex at this height.
};

/// A triangle mesh that stands in the booth. Immutable; reentrant.
class MeshSubject final : public Subject {
 public:
  /// Requires at least one vertex, finite coordinates and valid indices, and scale > 0.
  MeshSubject(TriangleMesh mesh, const MeshPlacement& placement, std::string name);

  /// The mesh file at `path`, named after its stem. Fails as ReadMesh does.
  static Result<MeshSubject> Load(Storage& storage, const std::string& path, const MeshPlacement& placement);

  [[nodiscard]] std::optional<SubjectHit> Cast(const Ray& ray, double time_s, double max_distance_mm) const override;
  [[nodiscard]] double top_mm() const override { return top_; }
  [[nodiscard]] double bottom_mm() const override { return bottom_; }
  [[nodiscard]] std::string name() const override { return name_; }

  /// The closed loops of the section at z, the largest first; exact for the flat triangles.
  [[nodiscard]] std::vector<SectionTruth> Sections(double z) const;
  /// Volume between two heights (z0 < z1), mm³; exact for a closed mesh.
  [[nodiscard]] double Volume(double z0, double z1) const;
  /// The mesh in the station frame.
  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }

 private:
  TriangleMesh mesh_;
  Bvh bvh_;
  std::string name_;
  double top_ = 0.0;
  double bottom_ = 0.0;
};

}  // namespace annulus::sim
