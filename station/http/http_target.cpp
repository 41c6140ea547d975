#include "station/http/http_target.h"

#include <algorithm>
#include <cstdint>
#include <optional>

namespace annulus {
namespace {

using Failure = tl::unexpected<std::string>;

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// RFC 3986: pchar, without "%".
bool IsPathOctet(char c) {
  if ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9')) return true;
  return std::string_view("-._~!$&'()*+,;=:@").find(c) != std::string_view::npos;
}

bool IsQueryOctet(char c) { return IsPathOctet(c) || c == '/' || c == '?'; }

enum class Part { kPath, kQuery };

/// One segment of a path, or a name or value of a query.
tl::expected<std::string, std::string> Decode(std::string_view text, Part part) {
  std::string decoded;
  decoded.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%') {
      const int high = i + 1 < text.size() ? HexDigit(text[i + 1]) : -1;
      const int low = i + 2 < text.size() ? HexDigit(text[i + 2]) : -1;
      if (high < 0 || low < 0) return Failure("a percent sign without two hex digits");
      decoded.push_back(static_cast<char>(16 * high + low));
      i += 2;
    } else if (part == Part::kQuery && text[i] == '+') {
      decoded.push_back(' ');
    } else if (part == Part::kPath ? IsPathOctet(text[i]) : IsQueryOctet(text[i])) {
      decoded.push_back(text[i]);
    } else {
      return Failure("a character that a target may not hold");
    }
  }
  if (!IsPlainUtf8(decoded)) return Failure("encoded bytes that are no text");
  return decoded;
}

tl::expected<std::string, std::string> ParsePath(std::string_view text) {
  if (text.empty() || text.front() != '/') return Failure("a target that does not begin with a slash");
  std::string path;
  while (!text.empty()) {
    text.remove_prefix(1);
    const std::size_t end = std::min(text.find('/'), text.size());
    auto segment = Decode(text.substr(0, end), Part::kPath);
    if (!segment) return Failure(segment.error());
    if (*segment == "." || *segment == "..") return Failure("a path with a dot segment");
    if (segment->find_first_of("/\\") != std::string::npos) return Failure("a path with an encoded separator");
    if (segment->empty() && end < text.size()) return Failure("a path with an empty segment");
    path += '/' + *segment;
    text.remove_prefix(end);
  }
  return path;
}

tl::expected<std::vector<HttpField>, std::string> ParseQuery(std::string_view text) {
  std::vector<HttpField> pairs;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('&'), text.size());
    const std::string_view pair = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (pair.empty()) continue;
    if (pairs.size() == kMaxQueryPairs) return Failure("a query with too many pairs");
    const std::size_t equals = std::min(pair.find('='), pair.size());
    auto name = Decode(pair.substr(0, equals), Part::kQuery);
    if (!name) return Failure(name.error());
    if (name->empty()) return Failure("a query with a nameless value");
    auto value = Decode(pair.substr(std::min(equals + 1, pair.size())), Part::kQuery);
    if (!value) return Failure(value.error());
    pairs.emplace_back(std::move(*name), std::move(*value));
  }
  return pairs;
}

/// Length of the well-formed sequence that `text` begins with (RFC 3629 §4), 0 if there is none; its code point in
/// `code`.
struct Sequence {
  std::size_t bytes = 0;
  std::uint32_t code = 0;
};

Sequence FirstSequence(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text[0]);
  if (lead < 0x80) return {1, lead};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return {};
  std::uint32_t code = lead & (0xFFU >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    const auto next = static_cast<unsigned char>(text[i]);
    if ((next & 0xC0) != 0x80) return {};
    code = code << 6 | (next & 0x3FU);
  }
  constexpr std::uint32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (code < kSmallest[bytes] || code > 0x10FFFF || surrogate) return {};
  return {bytes, code};
}

}  // namespace

bool IsPlainUtf8(std::string_view text) {
  while (!text.empty()) {
    const Sequence sequence = FirstSequence(text);
    const bool control = sequence.code < 0x20 || (sequence.code >= 0x7F && sequence.code <= 0x9F);
    if (sequence.bytes == 0 || control) return false;
    text.remove_prefix(sequence.bytes);
  }
  return true;
}

tl::expected<HttpTarget, std::string> ParseTarget(std::string_view target) {
  const std::size_t mark = std::min(target.find('?'), target.size());
  auto path = ParsePath(target.substr(0, mark));
  if (!path) return Failure(path.error());
  auto query = ParseQuery(target.substr(std::min(mark + 1, target.size())));
  if (!query) return Failure(query.error());
  return HttpTarget{std::move(*path), std::move(*query)};
}

}  // namespace annulus
