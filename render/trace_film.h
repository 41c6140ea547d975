#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "render/image.h"
#include "render/trace.h"
#include "render/trace_path.h"

namespace annulus {

/// The sums over the samples of one pixel.
struct FilmPixel {
  LinearRgb light = LinearRgb::Zero();
  float square = 0.0F;  ///< Of the samples' luminance.
  LinearRgb albedo = LinearRgb::Zero();
  float depth = 0.0F;  ///< Of the samples that saw an opaque thing.
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float nearest = kNoDepth;
  std::uint32_t covered = 0;
  std::uint32_t mirrored = 0;
  std::uint32_t through_lens = 0;
  bool is_exact = false;  ///< Nothing is there but what stands behind the scene, in `light` as one sample's value.
};

/// The samples of all pixels so far. Pixels may be added to from several threads, one each.
class TraceFilm {
 public:
  /// `behind`: light of what stands behind the scene, per pixel.
  TraceFilm(int width, int height);

  /// Adds the samples of pixel `index`.
  void Add(std::size_t index, std::span<const PathResult> samples);
  /// Sets a pixel in which the scene cannot be seen.
  void SetBehind(std::size_t index, const LinearRgb& light);

  /// The picture after `samples` per pixel.
  [[nodiscard]] RgbImage Develop(int samples, const TraceOptions& options, int threads,
                                 const std::stop_token& stop) const;

 private:
  [[nodiscard]] std::vector<LinearRgb> Denoised(std::vector<LinearRgb> light, int samples, int threads,
                                                const std::stop_token& stop) const;

  int width_;
  int height_;
  std::vector<FilmPixel> pixels_;
};

}  // namespace annulus
