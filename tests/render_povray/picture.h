#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/scene.h"
#include "tests/support/folders.h"
#include "tests/support/povray_process.h"
#include "tests/support/povray_scene.h"

namespace annulus::test {

/// A scene as it stands before a camera.
struct Shot {
  Scene scene;
  Camera camera;
  Lighting lighting{Environment::Uniform(LinearRgb::Zero()), {}};
};

/// What povray shows of it. Its files stay in the build folder under the name of the running test and `name`.
inline RgbImage Povray(const Shot& shot, PovraySceneOptions options, PovraySampling sampling, const std::string& name) {
  options.aspect = static_cast<double>(sampling.width) / sampling.height;
  const Result<std::string> text = PovrayScene(shot.scene, shot.camera, shot.lighting, options);
  if (!text) throw std::runtime_error(text.error().Text());
  const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  const std::filesystem::path folder = std::filesystem::path(test::BinaryFolder()) / "povray" / test;
  Result<PovrayPicture> picture = RunPovray(*text, sampling, folder, name);
  if (!picture) throw std::runtime_error(picture.error().Text());
  return std::move(picture->image);
}

/// Depth as povray sees it, mm; far_mm where nothing is.
inline std::vector<double> PovrayDepth(const Shot& shot, double near_mm, double far_mm,
                                       const PovraySampling& sampling) {
  PovraySceneOptions options;
  options.view = PovrayView::kDepth;
  options.near_mm = near_mm;
  options.far_mm = far_mm;
  const RgbImage grey = Povray(shot, options, sampling, "depth");
  std::vector<double> depth;
  depth.reserve(grey.rgb.size());
  for (const LinearRgb& pixel : grey.rgb)
    depth.push_back(near_mm + (far_mm - near_mm) * static_cast<double>(pixel.x()));
  return depth;
}

/// A ray in the station frame; the direction has length 1 along the camera's axis.
struct EyeRay {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

/// The ray through the middle of a pixel, by the words of camera.h.
inline EyeRay RayThrough(const Camera& camera, int x, int y, const PovraySampling& sampling) {
  const double across =
      (2.0 * (x + 0.5) / sampling.width - 1.0) * camera.half_height * sampling.width / sampling.height;
  const double up = (1.0 - 2.0 * (y + 0.5) / sampling.height) * camera.half_height;
  const Eigen::Matrix3d station_from_camera = camera.camera_from_station.transpose();
  if (camera.projection == Projection::kPerspective) {
    return {camera.eye_in_station, station_from_camera * Eigen::Vector3d(across, up, 1.0)};
  }
  return {camera.eye_in_station + station_from_camera * Eigen::Vector3d(across, up, 0.0), station_from_camera.col(2)};
}

}  // namespace annulus::test
