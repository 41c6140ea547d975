#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "render/png.h"

namespace annulus::test {

/// Holds a picture against the one stored at `path`; with ANNULUS_UPDATE_GOLDEN in the environment it is stored
/// instead. In linear light, 0 … 1: an edge that moves by a third of a pixel differs by 0.3 along it.
inline void ExpectStoredPicture(const RgbImage& image, const std::string& path) {
  const auto bytes = EncodePng(image);
  ASSERT_TRUE(bytes);
  if (std::getenv("ANNULUS_UPDATE_GOLDEN") != nullptr) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes->data()), static_cast<std::streamsize>(bytes->size()));
    GTEST_SKIP() << "stored " << path;
  }
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> read((std::istreambuf_iterator<char>(file)), {});
  const auto stored = DecodePng(std::as_bytes(std::span(read)));
  ASSERT_TRUE(stored) << path << ": " << stored.error().Text();
  const auto now = DecodePng(*bytes);
  ASSERT_EQ(now->width, stored->width);
  ASSERT_EQ(now->height, stored->height);
  double sum = 0.0;
  std::size_t different = 0;
  for (std::size_t k = 0; k < now->rgb.size(); ++k) {
    const double worst = static_cast<double>((now->rgb[k] - stored->rgb[k]).cwiseAbs().maxCoeff());
    sum += worst * worst;
    different += worst > 0.2 ? 1 : 0;
  }
  const auto pixels = static_cast<double>(now->rgb.size());
  EXPECT_LT(std::sqrt(sum / pixels), 0.01);
  EXPECT_LT(static_cast<double>(different) / pixels, 0.001);
}

}  // namespace annulus::test
