#include "base/sha256.h"

#include <gtest/gtest.h>

#include <string_view>

#include "base/ensure.h"

namespace annulus {
namespace {

std::span<const std::byte> Bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

// The examples of FIPS 180-4 (one and two blocks), and the empty message: `printf '' | sha256sum`.
TEST(Sha256, GivesThePublishedDigests) {
  EXPECT_EQ(Sha256Hex({}), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(Sha256Hex(Bytes("abc")), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Sha256Hex(Bytes("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq")),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, DoesNotDependOnHowTheBytesAreCut) {
  const std::string_view text = "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq";
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    Sha256 hash;
    hash.Update(Bytes(text.substr(0, cut)));
    hash.Update(Bytes(text.substr(cut)));
    EXPECT_EQ(hash.Hex(), Sha256Hex(Bytes(text)));
  }
}

TEST(Sha256, IsReadOnce) {
  Sha256 hash;
  (void)hash.Hex();
  EXPECT_THROW((void)hash.Hex(), LogicError);
}

}  // namespace
}  // namespace annulus
