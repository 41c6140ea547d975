#include "firmware_iface/crc32c.h"

#include <gtest/gtest.h>

#include <string_view>
#include <vector>

namespace annulus {
namespace {

std::uint32_t OfText(std::string_view text) { return Crc32c(std::as_bytes(std::span(text.data(), text.size()))); }

// RFC 3720, appendix B.4.
TEST(Crc32c, GivesTheStandardsExamples) {
  EXPECT_EQ(OfText("123456789"), 0xE3069283U);
  EXPECT_EQ(Crc32c(std::vector<std::byte>(32, std::byte{0x00})), 0x8A9136AAU);
  EXPECT_EQ(Crc32c(std::vector<std::byte>(32, std::byte{0xFF})), 0x62A8AB43U);
  std::vector<std::byte> rising;
  for (int i = 0; i < 32; ++i) rising.push_back(static_cast<std::byte>(i));
  EXPECT_EQ(Crc32c(rising), 0x46DD794EU);
}

TEST(Crc32c, OfNothingIsZero) { EXPECT_EQ(OfText(""), 0U); }

}  // namespace
}  // namespace annulus
