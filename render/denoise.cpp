#include "render/denoise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "base/bands.h"
#include "base/ensure.h"

namespace annulus {
namespace {

constexpr int kLevels = 5;
constexpr int kRowsPerBand = 8;
/// Differences of light that count as one, in standard deviations.
constexpr float kLightTolerance = 2.5F;
constexpr float kAlbedoTolerance = 0.06F;
constexpr float kLensTolerance = 0.25F;
/// Distance at which pixels have nothing in common any more: FallOff is below 0.001.
constexpr float kFar = 5.5F;
/// Deviations of a pixel that nobody sees, of light divided by the albedo: a quarter of a step of 8 bits in the dark.
constexpr float kInvisible = 1e-4F;
/// Albedo below which light is not divided by it.
constexpr float kLeastAlbedo = 0.02F;
constexpr std::array<float, 3> kTaps = {0.375F, 0.25F, 0.0625F};  // B-spline, from the middle

float Luminance(const LinearRgb& rgb) { return 0.2126F * rgb[0] + 0.7152F * rgb[1] + 0.0722F * rgb[2]; }

/// Half of the second difference of depth: what a slope explains is no step.
struct DepthSlope {
  float per_column = 0.0F;
  float per_row = 0.0F;
};

/// All planes of a pixel side by side.
struct Pixel {
  LinearRgb light;  // divided by the albedo
  float luminance = 0.0F;
  LinearRgb albedo;
  float depth = 0.0F;
  Eigen::Vector3f normal;
  float lens = 0.0F;
  DepthSlope slope;
  float variance = 0.0F;  // of luminance
  float blurred = 0.0F;   // variance of the neighbourhood
};

/// What a level changes.
struct Filtered {
  LinearRgb light;
  float variance = 0.0F;
};

/// exp(-x) for x >= 0 within 1.5 %, without a call: ((1 - x/16)^16, 0 from 16 on).
float FallOff(float x) {
  float y = std::max(0.0F, 1.0F - 0.0625F * x);
  y *= y;
  y *= y;
  y *= y;
  return y * y;
}

class Filter {
 public:
  Filter(const std::vector<LinearRgb>& noisy, const DenoiseGuides& guides)
      : width_(guides.width), height_(guides.height), pixels_(noisy.size()), filtered_(noisy.size()) {
    for (std::size_t k = 0; k < noisy.size(); ++k) {
      Pixel& pixel = pixels_[k];
      pixel.albedo = guides.albedo[k];
      divisor_.push_back(guides.albedo[k].cwiseMax(kLeastAlbedo));
      pixel.light = noisy[k].cwiseQuotient(divisor_.back());
      pixel.luminance = Luminance(pixel.light);
      pixel.normal = guides.normal[k];
      pixel.depth = guides.depth[k];
      pixel.lens = guides.lens[k];
      const float divisor = Luminance(divisor_.back());
      pixel.variance = guides.variance[k] / (divisor * divisor);
    }
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) At(x, y).slope = SlopeAt(x, y);
    }
  }

  void Level(int step, int threads, const std::stop_token& stop) {
    ForEachRow(threads, stop, [&](int y) {
      for (int x = 0; x < width_; ++x) At(x, y).blurred = BlurredVariance(x, y);
    });
    ForEachRow(threads, stop, [&](int y) {
      for (int x = 0; x < width_; ++x) filtered_[Index(x, y)] = FilteredAt(x, y, step);
    });
    for (std::size_t k = 0; k < pixels_.size(); ++k) {
      pixels_[k].light = filtered_[k].light;
      pixels_[k].luminance = Luminance(filtered_[k].light);
      pixels_[k].variance = filtered_[k].variance;
    }
  }

  [[nodiscard]] std::vector<LinearRgb> Picture() const {
    std::vector<LinearRgb> picture(pixels_.size());
    for (std::size_t k = 0; k < picture.size(); ++k) picture[k] = pixels_[k].light.cwiseProduct(divisor_[k]);
    return picture;
  }

 private:
  [[nodiscard]] std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] Pixel& At(int x, int y) { return pixels_[Index(x, y)]; }
  [[nodiscard]] const Pixel& At(int x, int y) const { return pixels_[Index(x, y)]; }

  template <class Work>
  void ForEachRow(int threads, const std::stop_token& stop, const Work& work) const {
    ForEachBand((height_ + kRowsPerBand - 1) / kRowsPerBand, threads, stop, [&](int band) {
      for (int y = band * kRowsPerBand; y < std::min(height_, (band + 1) * kRowsPerBand); ++y) work(y);
    });
  }

  /// The smaller of the two differences along each axis: that of the surface, not of an edge.
  [[nodiscard]] DepthSlope SlopeAt(int x, int y) const {
    const auto smaller = [](float a, float b) { return std::min(std::abs(a), std::abs(b)); };
    const float here = At(x, y).depth;
    const float left = At(std::max(x - 1, 0), y).depth;
    const float right = At(std::min(x + 1, width_ - 1), y).depth;
    const float above = At(x, std::max(y - 1, 0)).depth;
    const float below = At(x, std::min(y + 1, height_ - 1)).depth;
    return {x == 0            ? std::abs(right - here)
            : x == width_ - 1 ? std::abs(left - here)
                              : smaller(right - here, here - left),
            y == 0             ? std::abs(below - here)
            : y == height_ - 1 ? std::abs(above - here)
                               : smaller(below - here, here - above)};
  }

  /// Single pixels' variances are noise themselves.
  [[nodiscard]] float BlurredVariance(int x, int y) const {
    float sum = 0.0F;
    float total = 0.0F;
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height_ - 1); ++j) {
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width_ - 1); ++i) {
        const float weight = (i == x ? 2.0F : 1.0F) * (j == y ? 2.0F : 1.0F);
        sum += weight * At(i, j).variance;
        total += weight;
      }
    }
    return sum / total;
  }

  [[nodiscard]] static float Weight(const Pixel& a, const Pixel& b, int dx, int dy, float per_deviation) {
    // Depth: against what the slope of the surface makes of the distance.
    const float reach = a.slope.per_column * static_cast<float>(std::abs(dx)) +
                        a.slope.per_row * static_cast<float>(std::abs(dy)) + 0.001F * a.depth + 1e-3F;
    float distance = 0.5F * std::abs(a.depth - b.depth) / reach;
    distance += std::abs(a.luminance - b.luminance) * per_deviation;
    if (distance > kFar) return 0.0F;
    const float albedo = (a.albedo - b.albedo).cwiseAbs().maxCoeff();
    distance += albedo * albedo * (1.0F / (kAlbedoTolerance * kAlbedoTolerance));
    distance += std::abs(a.lens - b.lens) * (1.0F / kLensTolerance);
    // Normals: sharp; half a unit of 1 - cos is far.
    distance += 24.0F * (a.normal - b.normal).squaredNorm();
    return distance > kFar ? 0.0F : FallOff(distance);
  }

  [[nodiscard]] Filtered FilteredAt(int x, int y, int step) const {
    const Pixel& middle = At(x, y);
    if (!(middle.blurred > kInvisible * kInvisible)) return {middle.light, middle.variance};
    const float per_deviation = 1.0F / (kLightTolerance * std::sqrt(middle.blurred) + 1e-6F);
    LinearRgb sum = kTaps[0] * kTaps[0] * middle.light;
    float variance = kTaps[0] * kTaps[0] * kTaps[0] * kTaps[0] * middle.variance;
    float total = kTaps[0] * kTaps[0];
    for (int j = -2; j <= 2; ++j) {
      const int tap_y = y + j * step;
      if (tap_y < 0 || tap_y >= height_) continue;
      for (int i = -2; i <= 2; ++i) {
        const int tap_x = x + i * step;
        if ((i == 0 && j == 0) || tap_x < 0 || tap_x >= width_) continue;
        const Pixel& tap = At(tap_x, tap_y);
        const float weight = kTaps[static_cast<std::size_t>(std::abs(i))] *
                             kTaps[static_cast<std::size_t>(std::abs(j))] *
                             Weight(middle, tap, i * step, j * step, per_deviation);
        if (weight == 0.0F) continue;
        sum += weight * tap.light;
        variance += weight * weight * tap.variance;
        total += weight;
      }
    }
    return {sum / total, variance / (total * total)};
  }

  int width_;
  int height_;
  std::vector<Pixel> pixels_;
  std::vector<Filtered> filtered_;
  std::vector<LinearRgb> divisor_;
};

}  // namespace

std::vector<LinearRgb> Denoise(const std::vector<LinearRgb>& noisy, const DenoiseGuides& guides, int threads,
                               const std::stop_token& stop) {
  const std::size_t count = static_cast<std::size_t>(guides.width) * static_cast<std::size_t>(guides.height);
  ENSURE(noisy.size() == count && guides.albedo.size() == count && guides.normal.size() == count &&
             guides.depth.size() == count && guides.lens.size() == count && guides.variance.size() == count,
         "a picture and its guides have different sizes");
  Filter filter(noisy, guides);
  for (int level = 0; level < kLevels; ++level) filter.Level(1 << level, threads, stop);
  return filter.Picture();
}

}  // namespace annulus
