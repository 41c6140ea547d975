#pragma once

#include <Eigen/Core>
#include <stop_token>
#include <vector>

#include "render/colour.h"

namespace annulus {

/// What is known of each pixel of a noisy picture. Row-major, width * height values each.
struct DenoiseGuides {
  int width = 0;
  int height = 0;
  std::vector<LinearRgb> albedo;        ///< Of what is seen, as far as it is free of noise; >= 0.
  std::vector<Eigen::Vector3f> normal;  ///< Mean of unit vectors; 0 where nothing is.
  std::vector<float> depth;             ///< mm; any one value where nothing is.
  std::vector<float> lens;              ///< Share of the pixel that is seen through a lens, 0 … 1.
  std::vector<float> variance;          ///< Of the pixel's luminance as estimated, >= 0; 0 where it is exact.
};

/// Removes noise by averages over alike pixels: five times a 5 x 5 B-spline filter of growing step (à trous). A
/// neighbour counts less the more its albedo, normal, depth or share of lens differ, and the more its light differs for
/// what their variances explain; so edges, shadows and the outlines of lenses stay. The light is divided by the albedo
/// first, so that textures stay. Where the variance is 0 nothing changes. The same for any number of threads.
/// (H. Dammertz et al., Edge-avoiding à-trous wavelet transform, 2010; C. Schied et al., Spatiotemporal variance-guided
/// filtering, 2017, its filter in space.)
[[nodiscard]] std::vector<LinearRgb> Denoise(const std::vector<LinearRgb>& noisy, const DenoiseGuides& guides,
                                             int threads, const std::stop_token& stop);

}  // namespace annulus
