#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "modeling/wrinkly/wrinkly_surface.h"

namespace annulus {

/// As much of a camera as says how large things are on the screen. Station frame, mm.
struct ScreenView {
  enum class Projection { kPerspective, kParallel };
  Projection projection = Projection::kPerspective;
  Eigen::Matrix3d camera_from_station = Eigen::Matrix3d::Identity();  ///< Rotation; rows are right, up, forward.
  Eigen::Vector3d eye_in_station = Eigen::Vector3d::Zero();           ///< mm
  double half_height = 0.2;  ///< kPerspective: tangent of half the vertical field of view; kParallel: mm.
  int width = 640;           ///< Pixels.
  int height = 480;
  double near_mm = 1.0;
};

/// How finely a wrinkly surface is sampled (paper 003, §4: adaptive sampling).
struct SamplingOptions {
  /// With a view: as many subdivisions as make no cell's side longer than triangle_px on the screen, and of cells that
  /// are short enough as many more as keep the number of cells per area of the screen the same at every distance; what
  /// lies outside the picture is left out; iterations follow the size continuously. Without one: `iterations`
  /// everywhere.
  std::optional<ScreenView> view{};
  double triangle_px = 2.0;
  /// K, 0 … most_iterations(). With a view: at most this many.
  std::optional<double> iterations{};
  /// Subdivisions without a view; absent: ⌈K⌉.
  std::optional<int> depth{};
  std::size_t most_cells = 4'000'000;  ///< More is an error; they take some 300 bytes each.
  int threads = 0;                     ///< 0: as many as the machine has. The mesh does not depend on it.
};

/// Triangles of a wrinkly surface, station frame, mm; counter-clockwise seen from outside. Neighbouring cells share
/// their corners whatever their sizes, so that there is no gap.
struct WrinklyMesh {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;  ///< Unit, area-weighted from the triangles.
  /// Vertex by vertex, all attributes of the control mesh in its order; the first is the height, mm.
  std::vector<float> values;
  std::vector<std::array<std::uint32_t, 3>> faces;
  std::size_t cells = 0;
  int shallowest = 0;  ///< Subdivisions of cells in the picture.
  int deepest = 0;
};

/// Samples a wrinkly surface: every cell becomes a fan of triangles about its middle. A corner's values are those of
/// the first of the cells that meet there, since the surface itself jumps from one to the other. Fails on options out
/// of range, on more cells than allowed, or a stop request.
[[nodiscard]] Result<WrinklyMesh> SampleSurface(const WrinklySurface& surface, const SamplingOptions& options,
                                                const TaskContext& task);

}  // namespace annulus
