#include "station/http/chunked_body.h"

#include <algorithm>
#include <string_view>

namespace annulus {
namespace {

/// Of a size with its extensions.
constexpr std::size_t kMaxSizeLine = 256;
constexpr std::size_t kMaxSizeDigits = 8;

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// What may follow the size: nothing, or spaces and ";" and anything that is visible.
bool IsExtension(std::string_view text) {
  if (text.empty()) return true;
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos || text[begin] != ';') return false;
  return std::none_of(text.begin(), text.end(), [](char c) { return (c >= 0 && c < 0x20 && c != '\t') || c == 0x7F; });
}

}  // namespace

ChunkedBody::Step ChunkedBody::TakeSize(std::string& received, std::size_t& at, std::size_t body_bytes) {
  const std::string_view rest = std::string_view(received).substr(at);
  const std::size_t feed = rest.find('\n');
  if (feed == std::string_view::npos && rest.size() <= kMaxSizeLine) return Step::kMore;
  const bool formed = feed != std::string_view::npos && feed > 0 && feed <= kMaxSizeLine && rest[feed - 1] == '\r';
  if (!formed) return Step::kMalformed;
  const std::string_view line = rest.substr(0, feed - 1);
  std::size_t digits = 0;
  left_ = 0;
  for (; digits < line.size() && HexDigit(line[digits]) >= 0; ++digits) {
    if (digits == kMaxSizeDigits) return Step::kTooLarge;
    left_ = 16 * left_ + static_cast<std::size_t>(HexDigit(line[digits]));
  }
  if (digits == 0 || !IsExtension(line.substr(digits))) return Step::kMalformed;
  if (left_ > limit_ - body_bytes) return Step::kTooLarge;
  at += feed + 1;
  part_ = left_ == 0 ? Part::kTrailer : Part::kData;
  return Step::kNext;
}

ChunkedBody::Step ChunkedBody::TakeData(std::string& received, std::size_t& at, std::string& body) {
  const std::size_t taken = std::min(left_, received.size() - at);
  body.append(received, at, taken);
  at += taken;
  left_ -= taken;
  if (left_ > 0) return Step::kMore;
  part_ = Part::kDataEnd;
  return Step::kNext;
}

ChunkedBody::Step ChunkedBody::TakeLineEnd(std::string& received, std::size_t& at, Part next) {
  const std::string_view rest = std::string_view(received).substr(at, 2);
  if (!std::string_view("\r\n").starts_with(rest)) return Step::kMalformed;
  if (rest.size() < 2) return Step::kMore;
  at += 2;
  if (part_ == Part::kTrailer) return Step::kDone;
  part_ = next;
  return Step::kNext;
}

ChunkedBody::State ChunkedBody::Take(std::string& received, std::string& body) {
  std::size_t at = 0;
  Step step = Step::kNext;
  while (step == Step::kNext) {
    switch (part_) {
      case Part::kSize:
        step = TakeSize(received, at, body.size());
        break;
      case Part::kData:
        step = TakeData(received, at, body);
        break;
      case Part::kDataEnd:
      case Part::kTrailer:
        step = TakeLineEnd(received, at, Part::kSize);
        break;
    }
  }
  received.erase(0, at);
  switch (step) {
    case Step::kDone:
      return State::kDone;
    case Step::kMalformed:
      return State::kMalformed;
    case Step::kTooLarge:
      return State::kTooLarge;
    default:
      return State::kMore;
  }
}

}  // namespace annulus
