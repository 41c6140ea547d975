#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/result.h"
#include "render/lens_solid.h"
#include "render/scene.h"

namespace annulus {

/// A ray of the trace frame: the station frame with its origin in the middle of the scene, in float. Hits at t_min < t
/// < t_max count. `direction` is unit; t in mm.
struct TraceRay {
  Eigen::Vector3f origin;
  float t_min = 0.0F;
  Eigen::Vector3f direction;
  float t_max = std::numeric_limits<float>::infinity();
};

/// The nearest triangle on a ray.
struct TraceHit {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t item = kNone;  ///< Of the scene's items; kNone: nothing.
  std::uint32_t face = 0;
  float t = 0.0F;
  float u = 0.0F;  ///< Barycentric, of the face's second corner.
  float v = 0.0F;  ///< Of its third.
};

/// A point of an opaque surface as a path meets it. Normals are unit and on the side of the eye.
struct TraceSurface {
  Eigen::Vector3f point;
  Eigen::Vector3f geometric;  ///< Of the face.
  Eigen::Vector3f normal;     ///< Interpolated; bent towards the eye where it would look away.
  Eigen::Vector3f along;      ///< The grooves of brushed metal; zero if it is none.
  const Material* material = nullptr;
  LinearRgb colour;  ///< Texture and vertex colour applied, 0 … 1.
};

/// Whether the rays of a call run much alike.
enum class Coherence { kAlike, kScattered };

/// What rays can meet: triangles in bounding volume hierarchies (Embree, watertight at shared edges), and lenses.
/// Immutable, thread-safe.
class TraceScene {
 public:
  /// A scene that was checked. Fails if the memory for the hierarchy is missing, or on a lens that is not valid.
  [[nodiscard]] static Result<std::unique_ptr<const TraceScene>> Make(const Scene& scene);
  ~TraceScene();

  /// The station point that is the trace frame's origin.
  [[nodiscard]] const Eigen::Vector3d& centre() const { return centre_; }
  /// The radius about the centre that holds everything, mm.
  [[nodiscard]] double radius() const { return radius_; }

  /// The nearest opaque triangle of each ray. Both spans have the same size.
  void Intersect(std::span<const TraceRay> rays, std::span<TraceHit> hits, Coherence coherence) const;
  /// Whether an opaque triangle is on each ray.
  void FindOccluded(std::span<const TraceRay> rays, std::span<std::uint8_t> occluded) const;
  /// The nearest lens sheet of a ray.
  [[nodiscard]] TraceHit NextSheet(const TraceRay& ray) const;
  /// What a ray along `direction` meets at a hit.
  [[nodiscard]] TraceSurface SurfaceAt(const TraceHit& hit, const Eigen::Vector3f& direction) const;

  [[nodiscard]] const std::vector<LensSolid>& lenses() const { return lenses_; }
  [[nodiscard]] bool has_sheets() const { return has_sheets_; }
  /// Whether a ray meets the box of lens `index`, or that of all sheets for index = lenses().size().
  [[nodiscard]] bool MeetsOptics(const TraceRay& ray, std::size_t index) const;
  /// Whether it may meet any lens or sheet.
  [[nodiscard]] bool MeetsAnyOptics(const TraceRay& ray) const;

  /// A vertex, laid out for Embree and for shading alike.
  struct Vertex {
    Eigen::Vector3f point;
    float unused = 0.0F;
    Eigen::Vector3f normal;
    float unused_too = 0.0F;
  };
  /// An item of the scene; of `lower`, `solid`, `colours` as SceneItem.
  struct Item {
    std::vector<Vertex> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces;
    std::vector<LinearRgb> colours;
    std::vector<Eigen::Vector3f> solid;
    std::vector<Eigen::Vector3f> grooves;  ///< Per vertex, of brushed metal; else empty.
    Material material;
    std::optional<Material> lower;
  };
  [[nodiscard]] const std::vector<Item>& items() const { return items_; }
  /// The boxes of the lenses, then of the sheets if there are any; trace frame.
  [[nodiscard]] const std::vector<Eigen::AlignedBox3f>& optics_boxes() const { return optics_boxes_; }

 private:
  struct Hierarchies;

  TraceScene();
  void AddItem(const SceneItem& item);
  void AddOpticsBoxes();

  std::vector<Item> items_;
  std::vector<LensSolid> lenses_;
  std::vector<Eigen::AlignedBox3f> optics_boxes_;
  Eigen::AlignedBox3f all_optics_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double radius_ = 0.0;
  bool has_sheets_ = false;
  std::unique_ptr<Hierarchies> hierarchies_;
};

}  // namespace annulus
