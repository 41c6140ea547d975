#include "render/png.h"

#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

namespace annulus {
namespace {

constexpr const char* kEncode = "encode a PNG image";
constexpr const char* kDecode = "decode a PNG image";

cv::Mat BytesFromImage(const RgbImage& image) {
  cv::Mat bytes(image.height, image.width, CV_8UC3);
  for (int y = 0; y < image.height; ++y) {
    auto* row = bytes.ptr<cv::Vec3b>(y);
    for (int x = 0; x < image.width; ++x) {
      const LinearRgb& rgb = image.rgb[image.Index(x, y)];
      // OpenCV keeps blue first.
      row[x] = cv::Vec3b(SrgbByteFromLinear(rgb[2]), SrgbByteFromLinear(rgb[1]), SrgbByteFromLinear(rgb[0]));
    }
  }
  return bytes;
}

RgbImage ImageFromBytes(const cv::Mat& bytes) {
  std::array<float, 256> linear{};
  for (std::size_t k = 0; k < linear.size(); ++k) {
    linear[k] = static_cast<float>(LinearFromSrgb(static_cast<double>(k) / 255.0));
  }
  RgbImage image = RgbImage::Filled(bytes.cols, bytes.rows, LinearRgb::Zero());
  for (int y = 0; y < image.height; ++y) {
    const auto* row = bytes.ptr<cv::Vec3b>(y);
    for (int x = 0; x < image.width; ++x) {
      image.rgb[image.Index(x, y)] = LinearRgb(linear[row[x][2]], linear[row[x][1]], linear[row[x][0]]);
    }
  }
  return image;
}

bool HasAt(std::span<const std::byte> bytes, std::size_t from, std::span<const unsigned char> expected) {
  if (bytes.size() < from + expected.size()) return false;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    if (std::to_integer<unsigned char>(bytes[from + k]) != expected[k]) return false;
  }
  return true;
}

bool HasPngSignature(std::span<const std::byte> bytes) {
  constexpr std::array<unsigned char, 8> kSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  return HasAt(bytes, 0, kSignature);
}

/// Whether the file ends with the IEND chunk (name and checksum); a truncated one does not.
bool HasPngEnd(std::span<const std::byte> bytes) {
  constexpr std::array<unsigned char, 8> kEnd = {'I', 'E', 'N', 'D', 0xAE, 0x42, 0x60, 0x82};
  return bytes.size() >= kEnd.size() && HasAt(bytes, bytes.size() - kEnd.size(), kEnd);
}

}  // namespace

Result<std::vector<std::byte>> EncodePng(const RgbImage& image) {
  const std::size_t count = image.Index(0, image.height);
  if (image.width < 1 || image.height < 1 || image.rgb.size() != count) {
    return Fail(kEncode,
                std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels with " +
                    std::to_string(image.rgb.size()) + " values",
                "give an image with at least one pixel and a value for each");
  }
  try {
    std::vector<unsigned char> encoded;
    if (!cv::imencode(".png", BytesFromImage(image), encoded, {cv::IMWRITE_PNG_COMPRESSION, 4})) {
      return Fail(kEncode, "the encoder refused it", "try a smaller image");
    }
    const auto as_bytes = std::as_bytes(std::span(encoded));
    return std::vector<std::byte>(as_bytes.begin(), as_bytes.end());
  } catch (const cv::Exception& exception) {
    return Fail(kEncode, exception.what(), "try a smaller image");
  }
}

Result<RgbImage> DecodePng(std::span<const std::byte> bytes) {
  constexpr const char* kAdvice = "give a complete PNG file";
  if (!HasPngSignature(bytes)) return Fail(kDecode, "the first eight bytes are not those of a PNG file", kAdvice);
  if (!HasPngEnd(bytes)) return Fail(kDecode, "its last chunk is missing", kAdvice);
  try {
    const std::vector<unsigned char> copy = [&bytes] {
      std::vector<unsigned char> values;
      values.reserve(bytes.size());
      for (const std::byte value : bytes) values.push_back(std::to_integer<unsigned char>(value));
      return values;
    }();
    const cv::Mat decoded = cv::imdecode(copy, cv::IMREAD_COLOR);
    if (decoded.empty()) return Fail(kDecode, "its contents are damaged or incomplete", kAdvice);
    return ImageFromBytes(decoded);
  } catch (const cv::Exception& exception) {
    return Fail(kDecode, exception.what(), kAdvice);
  }
}

}  // namespace annulus
