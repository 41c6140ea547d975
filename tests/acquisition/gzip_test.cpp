#include "acquisition/gzip.h"

#include <gtest/gtest.h>

#include <array>

namespace annulus {
namespace {

constexpr std::uint64_t kLimit = 1'000'000;

// python3 -c "import gzip; print(gzip.compress(b'hello, gzip\n', mtime=0).hex())"
constexpr std::array<unsigned char, 32> kHello{0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x03, 0xcb,
                                               0x48, 0xcd, 0xc9, 0xc9, 0xd7, 0x51, 0x48, 0xaf, 0xca, 0x2c, 0xe0,
                                               0x02, 0x00, 0x86, 0x1f, 0x82, 0xa4, 0x0c, 0x00, 0x00, 0x00};

std::span<const std::byte> Bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

std::string Packed(std::string_view text) {
  GzipPacker packer;
  std::string packed = packer.Pack(text);
  packed += packer.Finish();
  return packed;
}

TEST(Gunzip, ReadsWhatPythonPacked) {
  const auto text = GunzipText(std::as_bytes(std::span(kHello)), "f", kLimit);
  ASSERT_TRUE(text) << text.error().Text();
  EXPECT_EQ(*text, "hello, gzip\n");
}

TEST(Gunzip, GivesBackWhatWasPackedInPieces) {
  std::string whole;
  GzipPacker packer;
  std::string packed;
  for (int i = 0; i < 20'000; ++i) {
    const std::string piece = std::to_string(i) + ",";
    whole += piece;
    packed += packer.Pack(piece);
  }
  packed += packer.Finish();
  const auto text = GunzipText(Bytes(packed), "f", kLimit);
  ASSERT_TRUE(text);
  EXPECT_EQ(*text, whole);
}

TEST(Gunzip, JoinsMembersAndIgnoresPadding) {
  const auto text = GunzipText(Bytes(Packed("one,") + Packed("two") + std::string(700, '\0')), "f", kLimit);
  ASSERT_TRUE(text);
  EXPECT_EQ(*text, "one,two");
}

TEST(Gunzip, RefusesEveryTruncation) {
  const std::string packed = Packed(std::string(3000, 'x') + "and an end");
  for (std::size_t cut = 0; cut < packed.size(); ++cut) {
    const auto text = GunzipText(Bytes(packed).first(cut), "f", kLimit);
    ASSERT_FALSE(text) << "cut at " << cut;
    EXPECT_EQ(text.error().seen, "the gzip data is truncated");
  }
}

TEST(Gunzip, RefusesAWrongChecksumAndForeignBytesAfterTheEnd) {
  std::string packed = Packed("some text");
  EXPECT_EQ(GunzipText(Bytes(packed + "tail"), "f", kLimit).error().seen, "something else follows the gzip data");
  packed[packed.size() - 6] = static_cast<char>(packed[packed.size() - 6] ^ 1);
  EXPECT_EQ(GunzipText(Bytes(packed), "f", kLimit).error().seen, "the gzip data is damaged");
}

TEST(Gunzip, StopsAtItsBound) {
  const auto text = GunzipText(Bytes(Packed(std::string(10 * kLimit, ' '))), "bomb.gz", kLimit);
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().seen, "it unpacks to more than 1000000 bytes");
}

}  // namespace
}  // namespace annulus
