#pragma once

#include <cmath>
#include <string>

#include "base/units.h"
#include "render/scene.h"

namespace annulus {

/// A sphere whose vertices lie on the true sphere, `count` meridians and count / 2 bands.
inline TriangleMesh SphereMesh(const Eigen::Vector3d& centre, double radius, int count) {
  TriangleMesh mesh;
  const int bands = count / 2;
  for (int i = 0; i <= bands; ++i) {
    for (int j = 0; j < count; ++j) {
      const double polar = kPi * i / bands;
      const double around = kTwoPi * j / count;
      mesh.vertices.push_back(centre + radius * Eigen::Vector3d(std::sin(polar) * std::cos(around),
                                                                std::sin(polar) * std::sin(around), std::cos(polar)));
    }
  }
  for (int i = 0; i < bands; ++i) {
    for (int j = 0; j < count; ++j) {
      const auto at = [count](int band, int meridian) {
        return static_cast<std::uint32_t>(band * count + meridian % count);
      };
      mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

/// The parallelogram corner, corner + u, corner + u + v, corner + v as two triangles.
inline TriangleMesh QuadMesh(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  return {{corner, corner + u, corner + u + v, corner + v}, {{0, 1, 2}, {0, 2, 3}}};
}

inline SceneItem Item(TriangleMesh mesh, const Material& material) { return {std::move(mesh), material, "thing", {}}; }

/// A lens with exactly this transmittance.
inline Material ExactLens(const LinearRgb& transmittance) {
  Material material;
  material.finish = Finish::kLens;
  material.transmittance = transmittance;
  return material;
}

/// An orthographic camera at y = +`distance` looking along -y at the origin, 1 mm per pixel for a picture of `height`.
inline Camera FrontCamera(double distance, int height) {
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.camera_from_station << -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0;
  camera.eye_in_station = {0.0, distance, 0.0};
  camera.half_height = 0.5 * height;
  return camera;
}

/// Options with an even backdrop of linear 0.5, no occlusion, one sample per pixel.
inline RenderOptions PlainOptions(int width, int height) {
  RenderOptions options;
  options.width = width;
  options.height = height;
  options.supersampling = 1;
  options.threads = 1;
  options.occlusion = 0.0;
  options.backdrop = {LinearRgb(0.5F, 0.5F, 0.5F), LinearRgb(0.5F, 0.5F, 0.5F)};
  return options;
}

}  // namespace annulus
