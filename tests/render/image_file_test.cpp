#include "render/image_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace annulus {
namespace {

/// Four pixels: linear 0, 0.5, 1 and 4 in red; covered 1, 1/2, 1/4 and not at all.
RgbImage FourPixels() {
  RgbImage image = RgbImage::Filled(4, 1, LinearRgb::Zero());
  image.rgb = {{0.0F, 0.25F, 1.0F}, {0.5F, 0.0F, 0.0F}, {0.25F, 0.0F, 0.0F}, {4.0F, 0.0F, 0.0F}};
  image.alpha = {1.0F, 0.5F, 0.25F, 0.0F};
  image.depth = {1234.56F, 0.01F, 99999.0F, kNoDepth};
  return image;
}

cv::Mat Decoded(const RgbImage& image, ImagePlane plane, const char* path) {
  const auto bytes = EncodeImage(image, plane, path);
  EXPECT_TRUE(bytes) << bytes.error().Text();
  if (!bytes) return {};
  const auto* first = reinterpret_cast<const unsigned char*>(bytes->data());
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  return cv::imdecode(std::vector<unsigned char>(first, first + bytes->size()), cv::IMREAD_UNCHANGED);
}

TEST(ImageFile, ColourInPngIsSrgbAndInExrLinear) {
  const cv::Mat png = Decoded(FourPixels(), ImagePlane::kColour, "p.png");
  ASSERT_EQ(png.type(), CV_8UC3);
  // IEC 61966-2-1: 0.25 → 137, 0.5 → 188, 1 → 255.
  EXPECT_EQ(png.at<cv::Vec3b>(0, 0), cv::Vec3b(255, 137, 0));
  EXPECT_EQ(png.at<cv::Vec3b>(0, 1), cv::Vec3b(0, 0, 188));
  const cv::Mat exr = Decoded(FourPixels(), ImagePlane::kColour, "P.EXR");
  ASSERT_EQ(exr.type(), CV_32FC3);
  EXPECT_EQ(exr.at<cv::Vec3f>(0, 3), cv::Vec3f(0.0F, 0.0F, 4.0F));
}

TEST(ImageFile, RgbaIsStraight) {
  const cv::Mat png = Decoded(FourPixels(), ImagePlane::kRgba, "p.png");
  ASSERT_EQ(png.type(), CV_8UC4);
  EXPECT_EQ(png.at<cv::Vec4b>(0, 1), cv::Vec4b(0, 0, 255, 128));
  EXPECT_EQ(png.at<cv::Vec4b>(0, 2), cv::Vec4b(0, 0, 255, 64));
  EXPECT_EQ(png.at<cv::Vec4b>(0, 3), cv::Vec4b(0, 0, 0, 0));
  const cv::Mat exr = Decoded(FourPixels(), ImagePlane::kRgba, "p.exr");
  EXPECT_EQ(exr.at<cv::Vec4f>(0, 2), cv::Vec4f(0.0F, 0.0F, 1.0F, 0.25F));
}

TEST(ImageFile, AlphaAndDepthHaveSixteenBitsOrFloats) {
  const cv::Mat alpha = Decoded(FourPixels(), ImagePlane::kAlpha, "a.png");
  ASSERT_EQ(alpha.type(), CV_16UC1);
  EXPECT_EQ(alpha.at<std::uint16_t>(0, 0), 65535);
  EXPECT_EQ(alpha.at<std::uint16_t>(0, 2), 16384);
  const cv::Mat depth = Decoded(FourPixels(), ImagePlane::kDepth, "d.png");
  ASSERT_EQ(depth.type(), CV_16UC1);
  EXPECT_EQ(depth.at<std::uint16_t>(0, 0), 12346);  // 0.1 mm
  EXPECT_EQ(depth.at<std::uint16_t>(0, 1), 1);
  EXPECT_EQ(depth.at<std::uint16_t>(0, 2), 65535);
  EXPECT_EQ(depth.at<std::uint16_t>(0, 3), 0);
  const cv::Mat exact = Decoded(FourPixels(), ImagePlane::kDepth, "d.exr");
  ASSERT_EQ(exact.type(), CV_32FC1);
  EXPECT_EQ(exact.at<float>(0, 0), 1234.56F);
  EXPECT_TRUE(std::isinf(exact.at<float>(0, 3)));
}

TEST(ImageFile, RefusesOtherNamesAndImagesWithoutAllValues) {
  EXPECT_FALSE(CheckImagePath("picture.jpg"));
  EXPECT_FALSE(CheckImagePath("png"));
  EXPECT_FALSE(EncodeImage(FourPixels(), ImagePlane::kColour, "p.tiff"));
  RgbImage image = FourPixels();
  image.alpha.pop_back();
  EXPECT_FALSE(EncodeImage(image, ImagePlane::kAlpha, "p.png"));
  EXPECT_FALSE(EncodeImage(RgbImage{}, ImagePlane::kDepth, "p.exr"));
}

}  // namespace
}  // namespace annulus
