#include "render/image_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>

#include "render/png.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "encode an image";
constexpr float kFullScale = 65535.0F;

enum class FileKind { kPng, kExr, kOther };

FileKind KindOf(std::string_view path) {
  std::string ending(path.substr(path.size() - std::min<std::size_t>(path.size(), 4)));
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending == ".png") return FileKind::kPng;
  return ending == ".exr" ? FileKind::kExr : FileKind::kOther;
}

Status CheckPlanes(const RgbImage& image) {
  const std::size_t count = image.width < 1 || image.height < 1 ? 0 : image.Index(0, image.height);
  const bool whole = count > 0 && image.rgb.size() == count && image.depth.size() == count &&
                     (image.alpha.empty() || image.alpha.size() == count);
  if (whole) return {};
  return Fail(kAttempted,
              std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels with " +
                  std::to_string(image.rgb.size()) + " values",
              "give an image with at least one pixel and a value for each");
}

float AlphaAt(const RgbImage& image, std::size_t pixel) { return image.alpha.empty() ? 1.0F : image.alpha[pixel]; }

/// Straight colour: what a covered share of the pixel has.
LinearRgb StraightAt(const RgbImage& image, std::size_t pixel) {
  const float alpha = AlphaAt(image, pixel);
  return alpha > 0.0F ? LinearRgb(image.rgb[pixel] / alpha) : LinearRgb(LinearRgb::Zero());
}

/// Fills a matrix with `value(pixel)`.
template <class Pixel, class Value>
cv::Mat Matrix(const RgbImage& image, Value&& value) {
  cv::Mat matrix(image.height, image.width, cv::traits::Type<Pixel>::value);
  for (int y = 0; y < image.height; ++y) {
    auto* row = matrix.ptr<Pixel>(y);
    for (int x = 0; x < image.width; ++x) row[x] = value(image.Index(x, y));
  }
  return matrix;
}

cv::Mat PngMatrix(const RgbImage& image, ImagePlane plane) {
  if (plane == ImagePlane::kAlpha) {
    return Matrix<std::uint16_t>(image, [&](std::size_t pixel) {
      return static_cast<std::uint16_t>(std::lround(std::clamp(AlphaAt(image, pixel), 0.0F, 1.0F) * kFullScale));
    });
  }
  if (plane == ImagePlane::kDepth) {
    return Matrix<std::uint16_t>(image, [&](std::size_t pixel) {
      if (image.depth[pixel] == kNoDepth) return std::uint16_t{0};
      const double steps = std::clamp(static_cast<double>(image.depth[pixel]) / kDepthStep, 1.0, 65535.0);
      return static_cast<std::uint16_t>(std::lround(steps));
    });
  }
  return Matrix<cv::Vec4b>(image, [&](std::size_t pixel) {
    const LinearRgb rgb = StraightAt(image, pixel);
    const auto alpha = std::lround(std::clamp(AlphaAt(image, pixel), 0.0F, 1.0F) * 255.0F);
    // OpenCV keeps blue first.
    return cv::Vec4b(SrgbByteFromLinear(rgb[2]), SrgbByteFromLinear(rgb[1]), SrgbByteFromLinear(rgb[0]),
                     static_cast<unsigned char>(alpha));
  });
}

cv::Mat ExrMatrix(const RgbImage& image, ImagePlane plane) {
  switch (plane) {
    case ImagePlane::kAlpha:
      return Matrix<float>(image, [&](std::size_t pixel) { return AlphaAt(image, pixel); });
    case ImagePlane::kDepth:
      return Matrix<float>(image, [&](std::size_t pixel) { return image.depth[pixel]; });
    case ImagePlane::kRgba:
      return Matrix<cv::Vec4f>(image, [&](std::size_t pixel) {
        const LinearRgb rgb = StraightAt(image, pixel);
        return cv::Vec4f(rgb[2], rgb[1], rgb[0], AlphaAt(image, pixel));
      });
    case ImagePlane::kColour:
      break;
  }
  return Matrix<cv::Vec3f>(image, [&](std::size_t pixel) {
    const LinearRgb& rgb = image.rgb[pixel];
    return cv::Vec3f(rgb[2], rgb[1], rgb[0]);
  });
}

}  // namespace

Status CheckImagePath(std::string_view path) {
  if (KindOf(path) != FileKind::kOther) return {};
  return Fail("choose a file type for the picture " + std::string(path), "its name ends in neither .png nor .exr",
              "name it so");
}

Result<std::vector<std::byte>> EncodeImage(const RgbImage& image, ImagePlane plane, std::string_view path) {
  RETURN_IF_ERROR(CheckImagePath(path));
  RETURN_IF_ERROR(CheckPlanes(image));
  const bool png = KindOf(path) == FileKind::kPng;
  if (png && plane == ImagePlane::kColour) return EncodePng(image);
  // Debian's OpenCV writes OpenEXR only if this says so; it is read at the first use.
  if (!png) setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  try {
    std::vector<unsigned char> encoded;
    const cv::Mat matrix = png ? PngMatrix(image, plane) : ExrMatrix(image, plane);
    const std::vector<int> parameters = png ? std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 4}
                                            : std::vector<int>{cv::IMWRITE_EXR_TYPE, cv::IMWRITE_EXR_TYPE_FLOAT};
    if (!cv::imencode(png ? ".png" : ".exr", matrix, encoded, parameters)) {
      return Fail(kAttempted, "the encoder refused it", "try a smaller image, or PNG");
    }
    const auto as_bytes = std::as_bytes(std::span(encoded));
    return std::vector<std::byte>(as_bytes.begin(), as_bytes.end());
  } catch (const cv::Exception& exception) {
    return Fail(kAttempted, exception.what(), "try a smaller image, or PNG");
  }
}

}  // namespace annulus
