#include "render/trace_film.h"

#include <algorithm>
#include <cmath>

#include "render/denoise.h"
#include "render/tone.h"

namespace annulus {
namespace {

float Luminance(const LinearRgb& rgb) { return 0.2126F * rgb[0] + 0.7152F * rgb[1] + 0.0722F * rgb[2]; }

/// Variance of a pixel's mean luminance, from the scatter of its samples.
float VarianceOf(const FilmPixel& pixel, int samples) {
  const auto count = static_cast<float>(samples);
  if (pixel.is_exact) return 0.0F;
  const float mean = Luminance(pixel.light) / count;
  // One sample says nothing of its scatter: as much as its own value.
  if (samples == 1) return mean * mean;
  return std::max(0.0F, pixel.square / count - mean * mean) / (count - 1.0F);
}

float AlphaOf(const FilmPixel& pixel, int samples) {
  if (pixel.is_exact) return 0.0F;
  const std::uint32_t telling = static_cast<std::uint32_t>(samples) - pixel.mirrored;
  return telling == 0 ? 1.0F : static_cast<float>(pixel.covered) / static_cast<float>(telling);
}

}  // namespace

TraceFilm::TraceFilm(int width, int height)
    : width_(width), height_(height), pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

void TraceFilm::Add(std::size_t index, std::span<const PathResult> samples) {
  // Summed apart first: a picture of many samples loses no digits.
  FilmPixel sum;
  for (const PathResult& sample : samples) {
    sum.light += sample.radiance;
    const float luminance = Luminance(sample.radiance);
    sum.square += luminance * luminance;
    sum.albedo += sample.albedo;
    sum.mirrored += sample.is_mirrored ? 1 : 0;
    sum.through_lens += sample.through_lens ? 1 : 0;
    if (sample.depth == kNoDepth) continue;
    sum.normal += sample.normal;
    sum.depth += sample.depth;
    sum.nearest = std::min(sum.nearest, sample.depth);
    ++sum.covered;
  }
  FilmPixel& pixel = pixels_[index];
  pixel.light += sum.light;
  pixel.square += sum.square;
  pixel.albedo += sum.albedo;
  pixel.normal += sum.normal;
  pixel.depth += sum.depth;
  pixel.nearest = std::min(pixel.nearest, sum.nearest);
  pixel.covered += sum.covered;
  pixel.mirrored += sum.mirrored;
  pixel.through_lens += sum.through_lens;
}

void TraceFilm::SetBehind(std::size_t index, const LinearRgb& light) {
  pixels_[index].light = light;
  pixels_[index].is_exact = true;
}

std::vector<LinearRgb> TraceFilm::Denoised(std::vector<LinearRgb> light, int samples, int threads,
                                           const std::stop_token& stop) const {
  DenoiseGuides guides;
  guides.width = width_;
  guides.height = height_;
  guides.albedo.resize(pixels_.size());
  guides.normal.resize(pixels_.size());
  guides.depth.resize(pixels_.size());
  guides.lens.resize(pixels_.size());
  guides.variance.resize(pixels_.size());
  const float per_sample = 1.0F / static_cast<float>(samples);
  float farthest = 0.0F;
  for (const FilmPixel& pixel : pixels_) {
    if (pixel.covered > 0) farthest = std::max(farthest, pixel.depth / static_cast<float>(pixel.covered));
  }
  for (std::size_t k = 0; k < pixels_.size(); ++k) {
    const FilmPixel& pixel = pixels_[k];
    guides.albedo[k] = pixel.is_exact ? pixel.light : LinearRgb(pixel.albedo * per_sample);
    guides.normal[k] = pixel.normal * per_sample;
    // What stands behind is far behind.
    guides.depth[k] = pixel.covered > 0 ? pixel.depth / static_cast<float>(pixel.covered) : 2.0F * farthest + 1.0F;
    guides.lens[k] = static_cast<float>(pixel.through_lens) * per_sample;
    guides.variance[k] = VarianceOf(pixel, samples);
  }
  return Denoise(light, guides, threads, stop);
}

RgbImage TraceFilm::Develop(int samples, const TraceOptions& options, int threads, const std::stop_token& stop) const {
  RgbImage image;
  image.width = width_;
  image.height = height_;
  image.rgb.resize(pixels_.size());
  image.depth.resize(pixels_.size());
  image.alpha.resize(pixels_.size());
  const float per_sample = 1.0F / static_cast<float>(samples);
  for (std::size_t k = 0; k < pixels_.size(); ++k) {
    const FilmPixel& pixel = pixels_[k];
    image.rgb[k] = pixel.is_exact ? pixel.light : LinearRgb(pixel.light * per_sample);
    image.depth[k] = pixel.nearest;
    image.alpha[k] = AlphaOf(pixel, samples);
  }
  if (options.denoising == Denoising::kOn) image.rgb = Denoised(std::move(image.rgb), samples, threads, stop);
  if (options.tone_curve == ToneCurve::kSoft) {
    for (LinearRgb& light : image.rgb) light = SoftLimit(light);
  }
  return image;
}

}  // namespace annulus
