#include "station/console/passwords.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <mutex>
#include <optional>

#include "base/ensure.h"
#include "station/console/common_passwords.h"

namespace annulus {
namespace {

constexpr unsigned long long kPasses = 2;
constexpr std::size_t kMemoryBytes = std::size_t{64} << 20;
constexpr std::size_t kLeastCharacters = 12;
constexpr std::size_t kMostBytes = 256;
constexpr std::size_t kLeastDigits = 6;
constexpr std::size_t kMostDigits = 12;

/// One computation at a time.
std::mutex& Turn() {
  static std::mutex turn;
  return turn;
}

void NeedSodium() { ENSURE(sodium_init() >= 0, "libsodium finds no random numbers"); }

/// A hash that no password has: of random bytes, made once.
const std::string& NobodysHash() {
  static const std::string hash = [] {
    std::array<char, 32> secret{};
    randombytes_buf(secret.data(), secret.size());
    std::array<char, crypto_pwhash_STRBYTES> text{};
    const int failed = crypto_pwhash_str_alg(text.data(), secret.data(), secret.size(), kPasses, kMemoryBytes,
                                             crypto_pwhash_ALG_ARGON2ID13);
    return failed == 0 ? std::string(text.data()) : std::string();
  }();
  return hash;
}

/// Characters of UTF-8 text; nothing if it is none or has control characters.
std::optional<std::size_t> CharacterCount(std::string_view text) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < text.size(); ++count) {
    const auto lead = static_cast<unsigned char>(text[i]);
    if (lead < 0x20 || lead == 0x7F) return std::nullopt;
    const std::size_t length = lead < 0x80                   ? 1
                               : lead >= 0xF0 && lead < 0xF5 ? 4
                               : lead >= 0xE0                ? 3
                               : lead >= 0xC2                ? 2
                                                             : 0;
    if (length == 0 || lead >= 0xF5 || i + length > text.size()) return std::nullopt;
    for (std::size_t k = 1; k < length; ++k) {
      if ((static_cast<unsigned char>(text[i + k]) & 0xC0U) != 0x80U) return std::nullopt;
    }
    i += length;
  }
  return count;
}

Status Refused(const std::string& what, const std::string& seen, const std::string& advice) {
  return Fail("take a new " + what, seen, advice);
}

/// Every digit is the one before plus `step` (modulo 10).
bool Steps(std::string_view digits, int step) {
  return std::adjacent_find(digits.begin(), digits.end(),
                            [step](char a, char b) { return (a - '0' + step + 10) % 10 != b - '0'; }) == digits.end();
}

}  // namespace

Result<std::string> HashPassword(std::string_view password) {
  NeedSodium();
  const std::lock_guard one_at_a_time(Turn());
  std::array<char, crypto_pwhash_STRBYTES> text{};
  if (crypto_pwhash_str_alg(text.data(), password.data(), password.size(), kPasses, kMemoryBytes,
                            crypto_pwhash_ALG_ARGON2ID13) != 0) {
    return Fail("hash a password", "64 MiB of memory could not be had", "end other programs and try again");
  }
  return std::string(text.data());
}

bool VerifyPassword(const std::string& hash, std::string_view password) {
  NeedSodium();
  const std::lock_guard one_at_a_time(Turn());
  const bool ours = hash.starts_with("$argon2id$") && hash.size() < crypto_pwhash_STRBYTES;
  const std::string& compared = ours ? hash : NobodysHash();
  if (compared.empty() || password.size() > kMostBytes) return false;
  const bool same = crypto_pwhash_str_verify(compared.c_str(), password.data(), password.size()) == 0;
  return same && ours;
}

Status CheckNewPassword(std::string_view password, std::string_view user) {
  const auto characters = CharacterCount(password);
  if (!characters) return Refused("password", "it is no text, or has control characters", "type another one");
  if (*characters < kLeastCharacters) {
    return Refused("password", "it has " + std::to_string(*characters) + " characters",
                   "take at least 12; four words that do not belong together are easy to remember");
  }
  if (password.size() > kMostBytes) return Refused("password", "it has more than 256 bytes", "take a shorter one");
  if (IsCommonPassword(password, user)) {
    return Refused("password", "it is among those that are guessed first, or made of your name",
                   "take four words that do not belong together");
  }
  return {};
}

Status CheckNewPin(std::string_view pin) {
  const bool digits = std::all_of(pin.begin(), pin.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!digits || pin.size() < kLeastDigits || pin.size() > kMostDigits) {
    return Refused("PIN", "it is not 6 to 12 digits", "take 6 or more digits");
  }
  bool repeats = false;
  for (std::size_t period = 1; 2 * period <= pin.size(); ++period) {
    repeats = repeats || pin.substr(period) == pin.substr(0, pin.size() - period);
  }
  if (repeats || Steps(pin, 1) || Steps(pin, -1)) {
    return Refused("PIN", "it repeats itself or counts up or down", "take digits without an order");
  }
  return {};
}

std::string RandomPassword() {
  NeedSodium();
  constexpr std::string_view kLetters = "abcdefghjkmnpqrstuvwxyz023456789";  // 32: no i, l, o, 1
  static_assert(kLetters.size() == 32);
  std::string password;
  for (int i = 0; i < 20; ++i) {
    if (i > 0 && i % 5 == 0) password += '-';
    password += kLetters[randombytes_uniform(kLetters.size())];
  }
  return password;
}

}  // namespace annulus
