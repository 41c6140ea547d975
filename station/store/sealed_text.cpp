#include "station/store/sealed_text.h"

#include <sodium.h>

#include <algorithm>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr unsigned char kVersion = 1;
constexpr std::size_t kNonceBytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;
constexpr std::size_t kTagBytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;
constexpr std::size_t kOverhead = 1 + kNonceBytes + kTagBytes;
constexpr std::size_t kShortTagBytes = 16;

const unsigned char* Octets(std::span<const std::byte> bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

void StartSodium() { ENSURE(sodium_init() >= 0, "libsodium starts"); }

}  // namespace

std::string SealContext(std::initializer_list<std::string_view> parts) {
  std::string context = "annulus store";
  for (const std::string_view part : parts) {
    context += ' ' + std::to_string(part.size()) + ':';
    context += part;
  }
  return context;
}

std::vector<std::byte> SealBytes(const SealKey& key, std::span<const std::byte> plain, std::string_view context) {
  StartSodium();
  std::vector<std::byte> sealed(kOverhead + plain.size());
  sealed[0] = std::byte{kVersion};
  auto* nonce = reinterpret_cast<unsigned char*>(sealed.data() + 1);
  randombytes_buf(nonce, kNonceBytes);
  unsigned long long written = 0;
  crypto_aead_xchacha20poly1305_ietf_encrypt(nonce + kNonceBytes, &written, Octets(plain), plain.size(),
                                             Octets(BytesOf(context)), context.size(), nullptr, nonce,
                                             key.bytes.data());
  return sealed;
}

std::vector<std::byte> SealText(const SealKey& key, std::string_view plain, std::string_view context) {
  return SealBytes(key, BytesOf(plain), context);
}

Result<std::vector<std::byte>> OpenBytes(const SealKey& key, std::span<const std::byte> sealed,
                                         std::string_view context, const std::string& name) {
  StartSodium();
  const auto refuse = [&] {
    return Fail("open " + name, "it is damaged, was moved from another place, or is sealed with another key",
                "run 'annulus store verify'; restore the last backup");
  };
  if (sealed.size() < kOverhead || sealed[0] != std::byte{kVersion}) return refuse();
  const unsigned char* nonce = Octets(sealed.subspan(1));
  std::vector<std::byte> plain(sealed.size() - kOverhead);
  unsigned long long opened = 0;
  if (crypto_aead_xchacha20poly1305_ietf_decrypt(
          reinterpret_cast<unsigned char*>(plain.data()), &opened, nullptr, nonce + kNonceBytes,
          sealed.size() - 1 - kNonceBytes, Octets(BytesOf(context)), context.size(), nonce, key.bytes.data()) != 0) {
    return refuse();
  }
  return plain;
}

Result<std::string> OpenText(const SealKey& key, std::span<const std::byte> sealed, std::string_view context,
                             const std::string& name) {
  auto plain = OpenBytes(key, sealed, context, name);
  if (!plain) return Fail(plain);
  std::string text(reinterpret_cast<const char*>(plain->data()), plain->size());
  sodium_memzero(plain->data(), plain->size());
  return text;
}

SealKey RandomSealKey() {
  StartSodium();
  SealKey key;
  randombytes_buf(key.bytes.data(), key.bytes.size());
  return key;
}

std::vector<std::byte> KeyedTag(const SealKey& key, std::span<const std::byte> text, std::string_view context) {
  StartSodium();
  std::vector<std::byte> tag(kShortTagBytes);
  crypto_generichash_state state;
  crypto_generichash_init(&state, key.bytes.data(), key.bytes.size(), tag.size());
  crypto_generichash_update(&state, Octets(BytesOf(context)), context.size());
  crypto_generichash_update(&state, Octets(text), text.size());
  crypto_generichash_final(&state, reinterpret_cast<unsigned char*>(tag.data()), tag.size());
  sodium_memzero(&state, sizeof state);
  return tag;
}

std::string HexOf(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string hex;
  hex.reserve(2 * bytes.size());
  for (const std::byte byte : bytes) {
    hex += kDigits[std::to_integer<std::size_t>(byte >> 4U)];
    hex += kDigits[std::to_integer<std::size_t>(byte & std::byte{0xF})];
  }
  return hex;
}

std::vector<std::byte> BytesOfHex(std::string_view hex) {
  const auto digit = [](char c) { return c >= 'a' ? c - 'a' + 10 : c - '0'; };
  if (hex.size() % 2 != 0 || hex.find_first_not_of("0123456789abcdef") != std::string_view::npos) return {};
  std::vector<std::byte> bytes(hex.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::byte>(16 * digit(hex[2 * i]) + digit(hex[2 * i + 1]));
  }
  return bytes;
}

void Wipe(std::string& text) {
  sodium_memzero(text.data(), text.size());
  text.clear();
}

std::span<const std::byte> BytesOf(std::string_view text) { return std::as_bytes(std::span(text.data(), text.size())); }

}  // namespace annulus
