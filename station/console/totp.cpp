#include "station/console/totp.h"

#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <sodium.h>

#include <array>
#include <charconv>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr std::size_t kKeyBytes = 20;  // of SHA-1, RFC 4226 §4 R6
constexpr std::string_view kBase32 = "ABCDEFGHIJKLMNOPQRSTUVWXYZ234567";

/// RFC 4648 §6 without padding.
std::string Base32(std::string_view bytes) {
  std::string text;
  unsigned buffer = 0;
  int bits = 0;
  for (const char byte : bytes) {
    buffer = (buffer << 8U | static_cast<unsigned char>(byte)) & 0xFFFFU;
    for (bits += 8; bits >= 5; bits -= 5) {
      text += kBase32[(buffer >> static_cast<unsigned>(bits - 5)) & 31U];
    }
  }
  if (bits > 0) text += kBase32[(buffer << static_cast<unsigned>(5 - bits)) & 31U];
  return text;
}

std::optional<std::string> FromBase32(std::string_view text) {
  std::string bytes;
  unsigned buffer = 0;
  int bits = 0;
  for (const char letter : text) {
    const std::size_t value = kBase32.find(letter);
    if (value == std::string_view::npos) return std::nullopt;
    buffer = (buffer << 5U | static_cast<unsigned>(value)) & 0xFFFFU;
    bits += 5;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>((buffer >> static_cast<unsigned>(bits)) & 0xFFU);
  }
  return bytes;
}

}  // namespace

std::string TotpCode(std::string_view key, std::uint64_t step, int digits) {
  ENSURE(digits >= 6 && digits <= 8, "RFC 4226 knows codes of 6 to 8 digits");
  std::array<unsigned char, 8> counter{};
  for (std::size_t i = 0; i < counter.size(); ++i) counter[7 - i] = static_cast<unsigned char>(step >> (8 * i));
  std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
  unsigned size = 0;
  ENSURE(HMAC(EVP_sha1(), key.data(), static_cast<int>(key.size()), counter.data(), counter.size(), hash.data(),
              &size) != nullptr,
         "HMAC-SHA-1 cannot be computed");
  // Dynamic truncation, RFC 4226 §5.3.
  const std::size_t offset = hash[size - 1] & 15U;
  std::uint32_t number = hash[offset] & 0x7FU;
  for (std::size_t i = 1; i < 4; ++i) number = number << 8U | hash[offset + i];
  std::string code(static_cast<std::size_t>(digits), '0');
  for (std::size_t i = code.size(); i-- > 0; number /= 10) code[i] = static_cast<char>('0' + number % 10);
  return code;
}

TotpSecret TotpSecret::Random() {
  ENSURE(sodium_init() >= 0, "libsodium finds no random numbers");
  TotpSecret secret;
  secret.key.resize(kKeyBytes);
  randombytes_buf(secret.key.data(), secret.key.size());
  return secret;
}

std::string TotpSecret::Text() const { return Base32(key) + " " + std::to_string(last_step); }

Result<TotpSecret> TotpSecret::Parse(std::string_view text) {
  const std::size_t blank = text.find(' ');
  const auto key = FromBase32(text.substr(0, blank));
  const std::string_view number = blank == std::string_view::npos ? std::string_view() : text.substr(blank + 1);
  TotpSecret secret;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), secret.last_step);
  if (!key || key->size() < kKeyBytes || error != std::errc() || end != number.data() + number.size()) {
    return Fail("read a second factor", "it is damaged", "let an admin make a new one");
  }
  secret.key = *key;
  return secret;
}

std::string TotpSecret::Uri(const std::string& user) const {
  return "otpauth://totp/annulus:" + user + "?secret=" + Base32(key) + "&issuer=annulus";
}

std::optional<std::uint64_t> VerifyTotp(const TotpSecret& secret, std::string_view code,
                                        std::chrono::nanoseconds wall) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(wall);
  const auto now = static_cast<std::uint64_t>(std::max<std::int64_t>(seconds / kTotpStep, 1));
  std::optional<std::uint64_t> found;
  for (std::uint64_t step = now - 1; step <= now + 1; ++step) {
    const std::string right = TotpCode(secret.key, step);
    const bool same = code.size() == right.size() && sodium_memcmp(code.data(), right.data(), right.size()) == 0;
    if (same && step > secret.last_step) found = step;
  }
  return found;
}

}  // namespace annulus
