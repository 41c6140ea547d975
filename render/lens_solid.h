#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <optional>

#include "base/result.h"
#include "render/lens_face.h"
#include "render/outline_wall.h"
#include "render/solid_lens.h"

namespace annulus {

/// The three kinds of boundary of a lens.
enum class LensPart { kFront, kBack, kEdge };

/// A ray in the station frame.
struct LensRay {
  Eigen::Vector3d origin;     ///< mm.
  Eigen::Vector3d direction;  ///< Unit.
  double t_min = 0.0;         ///< Crossings at t <= t_min and t > t_max do not count, mm.
  double t_max = std::numeric_limits<double>::infinity();
  /// Set if the ray starts on this part of this lens (after refraction or reflection there): the crossing at which it
  /// starts is left out, however it was rounded.
  std::optional<LensPart> from{};
};

/// Where a ray passes through the boundary of a lens.
struct LensCrossing {
  double t = 0.0;          ///< mm along the ray.
  Eigen::Vector3d point;   ///< Station frame, mm.
  Eigen::Vector3d normal;  ///< Unit, out of the glass; of the edge smoothed along the outline.
  LensPart part{};
  bool entering = false;  ///< Out of the air into the glass: direction · normal < 0.
};

/// A lens as a solid for ray tracing: both surfaces exact (sphere or torus, as lens_surface.h has them), the edge a
/// cylinder over the outline along the lens' z. Light that arrives at a crossing with `entering` ran through air, else
/// through glass: a tracer needs no other memory. Immutable, thread-safe.
class LensSolid {
 public:
  /// Fails if a number is not finite, the placement is no rotation and shift, the outline not valid, a surface does not
  /// reach it or the lens is not thicker than 0 everywhere in it, index outside 1 … 4, Abbe number outside 15 … 100, or
  /// the finish not as LensFinish asks.
  [[nodiscard]] static Result<LensSolid> Make(const SolidLens& lens);

  /// The first crossing within the ray's range; none if there is none. About 200 ns, 350 ns
  /// with a toric back.
  [[nodiscard]] std::optional<LensCrossing> Next(const LensRay& ray) const;
  /// Whether a point (station frame) is inside the glass.
  [[nodiscard]] bool Contains(const Eigen::Vector3d& point) const;

  /// The box around it, station frame, mm.
  [[nodiscard]] const Eigen::AlignedBox3d& bounds() const { return bounds_; }
  /// Lens frame y of a point of the station frame, mm: for the gradient of the tint.
  [[nodiscard]] double Height(const Eigen::Vector3d& point) const {
    return lens_from_station_.linear().row(1).dot(point) + lens_from_station_.translation().y();
  }
  [[nodiscard]] double index() const { return index_; }  ///< At the d line.
  [[nodiscard]] double abbe() const { return abbe_; }
  [[nodiscard]] const LensFinish& finish() const { return finish_; }

 private:
  struct LocalRay;

  LensSolid(const SolidLens& lens, const LensRegion& region);
  [[nodiscard]] std::optional<LensCrossing> NextOf(const LocalRay& ray) const;

  LensFace front_;
  LensFace back_;
  OutlineWall wall_;
  LensRegion region_;
  Eigen::Isometry3d station_from_lens_;
  Eigen::Isometry3d lens_from_station_;
  Eigen::Vector3d middle_;  // lens frame
  Eigen::AlignedBox3d bounds_;
  double index_;
  double abbe_;
  LensFinish finish_;
};

}  // namespace annulus
