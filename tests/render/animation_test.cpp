#include "render/animation.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "render/png.h"

namespace annulus {
namespace {

/// A gradient with a square that wanders: every frame differs from its neighbours.
RgbImage Frame(int k, int width = 64, int height = 40) {
  RgbImage image = RgbImage::Filled(width, height, LinearRgb::Zero());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool inside = x >= 4 * k && x < 4 * k + 12 && y >= 10 && y < 22;
      image.rgb[image.Index(x, y)] = LinearRgb(static_cast<float>(x) / 64.0F, static_cast<float>(y) / 40.0F,
                                               inside ? 1.0F : 0.05F * static_cast<float>(k));
    }
  }
  return image;
}

std::string OutputOf(const std::string& command) {
  std::string text;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return text;
  std::array<char, 256> part{};
  while (fgets(part.data(), static_cast<int>(part.size()), pipe) != nullptr) text += part.data();
  pclose(pipe);
  return text;
}

std::size_t Count(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

/// A folder of this test process, removed at the end.
class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("annulus_animation_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::string File(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

void Write(const std::string& path, const std::vector<std::byte>& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

std::vector<std::byte> ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

std::vector<RgbImage> Frames(int count) {
  std::vector<RgbImage> frames;
  for (int k = 0; k < count; ++k) frames.push_back(Frame(k));
  return frames;
}

TEST(AnimatedWebp, OtherProgramsFindTheFramesTheirSizeTimesAndLoops) {
  if (std::system("webpinfo -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no webpinfo";
  const Folder folder;
  const auto bytes = EncodeAnimatedWebp(Frames(7), {120, 3});
  ASSERT_TRUE(bytes.has_value()) << bytes.error().Text();
  Write(folder.File("film.webp"), *bytes);
  const std::string info = OutputOf("webpinfo '" + folder.File("film.webp") + "'");
  EXPECT_NE(info.find("Canvas size 64 x 40"), std::string::npos) << info;
  EXPECT_NE(info.find("Loop count      : 3"), std::string::npos) << info;
  EXPECT_EQ(Count(info, "Chunk ANMF"), 7U) << info;
  EXPECT_EQ(Count(info, "Duration: 120"), 7U) << info;
  EXPECT_EQ(Count(info, "VP8L"), 7U) << info;  // lossless
  EXPECT_NE(info.find("No error detected"), std::string::npos) << info;
}

TEST(AnimatedWebp, FramesDecodeToTheBytesOfTheirPng) {
  if (std::system("webpmux -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no webpmux";
  if (std::system("dwebp -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no dwebp";
  const Folder folder;
  const std::vector<RgbImage> frames = Frames(5);
  Write(folder.File("film.webp"), EncodeAnimatedWebp(frames, {80, 0}).value());
  for (int k = 0; k < 5; ++k) {
    const std::string webp = folder.File("frame.webp");
    const std::string png = folder.File("frame.png");
    OutputOf("webpmux -get frame " + std::to_string(k + 1) + " '" + folder.File("film.webp") + "' -o '" + webp + "'");
    OutputOf("dwebp '" + webp + "' -o '" + png + "'");
    const auto decoded = DecodePng(ReadBytes(png));
    const auto wanted = DecodePng(EncodePng(frames[static_cast<std::size_t>(k)]).value());
    ASSERT_TRUE(decoded && wanted);
    ASSERT_EQ(decoded->width, 64);
    ASSERT_EQ(decoded->height, 40);
    for (std::size_t pixel = 0; pixel < wanted->rgb.size(); ++pixel) {
      ASSERT_EQ(decoded->rgb[pixel], wanted->rgb[pixel]) << "frame " << k << " pixel " << pixel;
    }
  }
}

TEST(AnimatedWebp, SameFramesSameBytes) {
  EXPECT_EQ(EncodeAnimatedWebp(Frames(4), {}).value(), EncodeAnimatedWebp(Frames(4), {}).value());
}

TEST(AnimatedWebp, RefusesWhatIsNoFilm) {
  EXPECT_FALSE(EncodeAnimatedWebp({}, {}).has_value());
  EXPECT_FALSE(EncodeAnimatedWebp(std::vector<RgbImage>{Frame(0), Frame(0, 32, 40)}, {}).has_value());
  EXPECT_FALSE(EncodeAnimatedWebp(Frames(2), {5, 0}).has_value());
  EXPECT_FALSE(EncodeAnimatedWebp(Frames(2), {80, -1}).has_value());
  RgbImage broken = Frame(0);
  broken.rgb.pop_back();
  EXPECT_FALSE(EncodeAnimatedWebp(std::vector<RgbImage>{broken}, {}).has_value());
}

}  // namespace
}  // namespace annulus
