#include "render/png.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

namespace annulus {
namespace {

RgbImage RandomImage(int width, int height) {
  std::mt19937_64 engine(4);
  RgbImage image = RgbImage::Filled(width, height, LinearRgb::Zero());
  for (LinearRgb& rgb : image.rgb) {
    for (int k = 0; k < 3; ++k) rgb[k] = static_cast<float>(engine() % 1000) / 999.0F;
  }
  return image;
}

TEST(Png, RoundTripKeepsEveryByte) {
  const RgbImage image = RandomImage(37, 23);
  const auto encoded = EncodePng(image);
  ASSERT_TRUE(encoded.has_value());
  const auto decoded = DecodePng(*encoded);
  ASSERT_TRUE(decoded.has_value());
  ASSERT_EQ(decoded->width, 37);
  ASSERT_EQ(decoded->height, 23);
  for (std::size_t k = 0; k < image.rgb.size(); ++k) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(SrgbByteFromLinear(decoded->rgb[k][c]), SrgbByteFromLinear(image.rgb[k][c]));
    }
  }
}

TEST(Png, SameImageSameBytes) {
  EXPECT_EQ(EncodePng(RandomImage(64, 64)).value(), EncodePng(RandomImage(64, 64)).value());
}

// A second reader: the format read by Python's zlib alone (PNG specification, 4.4 and 9.2: filters).
TEST(Png, AnotherReaderSeesTheSameColours) {
  if (std::system("python3 -c 'import zlib' > /dev/null 2>&1") != 0) GTEST_SKIP() << "no python3";
  RgbImage image = RgbImage::Filled(2, 2, LinearRgb(0.5F, 0.0F, 1.0F));  // sRGB 188, 0, 255
  image.rgb[3] = LinearRgb(0.18F, 0.18F, 0.18F);                         // sRGB 118
  const auto encoded = EncodePng(image);
  ASSERT_TRUE(encoded.has_value());
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "annulus_png_test.png";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(encoded->data()), static_cast<std::streamsize>(encoded->size()));
  const std::string script = R"(
import struct, sys, zlib
d = open(sys.argv[1], 'rb').read(); at = 8; z = b''
while at < len(d):
    n, kind = struct.unpack('>I4s', d[at:at + 8]); body = d[at + 8:at + 8 + n]; at += 12 + n
    if kind == b'IHDR': w, h, depth, colour = struct.unpack('>IIBB', body[:10])
    if kind == b'IDAT': z += body
raw = zlib.decompress(z); old = [0] * (w * 3); out = []
for y in range(h):
    f = raw[y * (w * 3 + 1)]; row = list(raw[y * (w * 3 + 1) + 1:(y + 1) * (w * 3 + 1)])
    for i in range(w * 3):
        a = row[i - 3] if i >= 3 else 0; b = old[i]; c = old[i - 3] if i >= 3 else 0
        p = a + b - c
        near = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
        row[i] = (row[i] + [0, a, b, (a + b) // 2, near][f]) % 256
    out += row; old = row
print(w, h, depth, colour, *out)
)";
  const std::filesystem::path program = std::filesystem::path(testing::TempDir()) / "annulus_png_test.py";
  std::ofstream(program) << script;
  const std::string command = "python3 '" + program.string() + "' '" + path.string() + "'";
  FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::array<char, 256> line{};
  const char* got = std::fgets(line.data(), static_cast<int>(line.size()), pipe);
  pclose(pipe);
  ASSERT_NE(got, nullptr);
  EXPECT_STREQ(line.data(), "2 2 8 2 188 0 255 188 0 255 188 0 255 118 118 118\n");
  std::filesystem::remove(path);
  std::filesystem::remove(program);
}

TEST(Png, RefusesWhatIsNoImage) {
  EXPECT_FALSE(EncodePng(RgbImage{}).has_value());
  RgbImage mismatched = RandomImage(4, 4);
  mismatched.rgb.pop_back();
  EXPECT_FALSE(EncodePng(mismatched).has_value());
  EXPECT_FALSE(DecodePng({}).has_value());
  const std::vector<std::byte> foreign(100, std::byte{0x42});
  EXPECT_FALSE(DecodePng(foreign).has_value());
}

TEST(Png, TruncatedFilesNeverCrash) {
  const std::vector<std::byte> whole = EncodePng(RandomImage(9, 7)).value();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_FALSE(DecodePng(std::span(whole).first(length)).has_value()) << length;
  }
}

}  // namespace
}  // namespace annulus
