#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "render/prepared_scene.h"
#include "render/rasterizer.h"

namespace annulus {

/// What a sample shows of a surface.
struct SurfacePoint {
  ShadingPoint shading;
  const Material* material = nullptr;                  ///< Of the upper or the lower part.
  LinearRgb colour = LinearRgb::Zero();                ///< Ground, colour of the vertices and texture.
  Eigen::Vector3f solid = Eigen::Vector3f::Zero();     ///< mm; zero where nothing depends on it.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< mm, camera frame.
};

/// Finds what the samples of a prepared scene show, given face and depth. What the samples of a face have in common is
/// kept for the next ones; the answers do not depend on the order of the questions. Thread-bound; borrows its
/// arguments.
class SurfaceSampler {
 public:
  SurfaceSampler(const PreparedScene& prepared, const PixelSamples& grid);

  /// The surface of `face` at sample (x, y), where its depth is `depth` mm: interpolated values, the normal on the
  /// viewer's side.
  [[nodiscard]] SurfacePoint At(int x, int y, std::uint32_t face, float depth);

 private:
  struct Face {
    std::uint32_t face = kNoFace;
    const PreparedItem* item = nullptr;
    const Eigen::Vector3f* solid = nullptr;
    std::array<std::uint32_t, 3> vertex{};  // within the item
    Eigen::Vector3d origin;                 // the first corner, camera frame
    Eigen::Vector3f dual_b;                 // dual_b . (p - origin) is the second corner's weight
    Eigen::Vector3f dual_c;
    std::array<Eigen::Vector3f, 3> normal;  // of the first corner, and from it to the others; z towards the eye
    Eigen::Vector3f geometric;              // on the viewer's side, z towards the eye
  };
  static constexpr std::size_t kKept = 64;

  [[nodiscard]] Face SetUp(std::uint32_t face) const;

  const PreparedScene& prepared_;
  const PixelSamples& grid_;
  std::array<Face, kKept> kept_;
};

}  // namespace annulus
