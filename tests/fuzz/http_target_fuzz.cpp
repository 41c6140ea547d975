/// The target of a request. Beyond "no crash": what is accepted holds what http_target.h promises, and, encoded anew,
/// means the same.
#include <cstdint>
#include <string>
#include <string_view>

#include "base/ensure.h"
#include "station/http/http_target.h"

namespace {

using namespace annulus;

std::string Encoded(std::string_view text, std::string_view kept) {
  constexpr char kHex[] = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text) {
    const auto octet = static_cast<unsigned char>(c);
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (plain || kept.find(c) != std::string_view::npos) {
      encoded.push_back(c);
    } else {
      encoded += {'%', kHex[octet >> 4], kHex[octet & 15U]};
    }
  }
  return encoded;
}

void CheckPath(const std::string& path) {
  ENSURE(path.starts_with('/') && IsPlainUtf8(path), "a path is text that begins with a slash");
  ENSURE(path.find('\\') == std::string::npos && path.find("//") == std::string::npos,
         "a path has no other separators");
  const std::string closed = path + '/';
  ENSURE(closed.find("/./") == std::string::npos && closed.find("/../") == std::string::npos, "a path leads down only");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto target = ParseTarget({reinterpret_cast<const char*>(data), size});
  if (!target) {
    ENSURE(!target.error().empty() && IsPlainUtf8(target.error()), "a refusal says why");
    return 0;
  }
  CheckPath(target->path);
  std::string again = Encoded(target->path, "/-._~");
  char separator = '?';
  for (const auto& [name, value] : target->query) {
    ENSURE(!name.empty() && IsPlainUtf8(name) && IsPlainUtf8(value), "a query is text");
    again += separator + Encoded(name, "") + '=' + Encoded(value, "");
    separator = '&';
  }
  const auto parsed = ParseTarget(again);
  ENSURE(parsed && parsed->path == target->path && parsed->query == target->query, "a target means one thing");
  return 0;
}
