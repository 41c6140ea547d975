#include "modeling/exchange/base64.h"

#include <gtest/gtest.h>

#include <random>

namespace annulus {
namespace {

std::string Encode(std::string_view text) { return EncodeBase64(std::as_bytes(std::span(text.data(), text.size()))); }

std::optional<std::string> Decode(std::string_view text) {
  const auto bytes = DecodeBase64(text);
  if (!bytes) return std::nullopt;
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

TEST(Base64, AgreesWithTheTestVectorsOfRfc4648) {
  // RFC 4648, section 10.
  const std::pair<const char*, const char*> vectors[] = {
      {"", ""},
      {"f", "Zg=="},
      {"fo", "Zm8="},
      {"foo", "Zm9v"},
      {"foob", "Zm9vYg=="},
      {"fooba", "Zm9vYmE="},
      {"foobar", "Zm9vYmFy"},
  };
  for (const auto& [plain, coded] : vectors) {
    EXPECT_EQ(Encode(plain), coded);
    EXPECT_EQ(Decode(coded), plain);
  }
}

TEST(Base64, UsesPlusAndSlash) {
  // python3 -c "import base64; print(base64.b64encode(bytes([0xfb, 0xff, 0xbf])))"
  EXPECT_EQ(Encode("\xfb\xff\xbf"), "+/+/");
  EXPECT_EQ(Decode("+/+/"), "\xfb\xff\xbf");
}

TEST(Base64, ReadsBackAnyBytes) {
  std::mt19937_64 random(1);
  for (std::size_t size = 0; size < 300; ++size) {
    std::string bytes;
    for (std::size_t k = 0; k < size; ++k) bytes += static_cast<char>(random() & 255U);
    EXPECT_EQ(Decode(Encode(bytes)), bytes);
  }
}

TEST(Base64, RefusesAWrongLength) {
  for (const char* text : {"Z", "Zg", "Zg=", "Zm9vY", "=", "=="}) EXPECT_FALSE(Decode(text)) << text;
}

TEST(Base64, RefusesForeignCharacters) {
  for (const char* text : {"Zm9\n", "Zm 9", "Zm-_", "Zm9\x80", "Z\xff==", "zm9{"}) EXPECT_FALSE(Decode(text)) << text;
  EXPECT_FALSE(Decode(std::string_view("Zm\0v", 4)));
}

TEST(Base64, RefusesPaddingAnywhereButAtTheEnd) {
  for (const char* text : {"Zg==Zg==", "Z===", "====", "=m9v", "Zm=v"}) EXPECT_FALSE(Decode(text)) << text;
}

TEST(Base64, RefusesBitsThatNoEncoderWrites) {
  // RFC 4648, section 3.5: the bits of the last character that the padding drops are zero; otherwise two texts would
  // be the same bytes.
  EXPECT_FALSE(Decode("Zh=="));
  EXPECT_FALSE(Decode("Zm9="));
}

}  // namespace
}  // namespace annulus
