#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "station/http/http_message.h"

namespace annulus {

/// The target of a request, taken apart and decoded.
struct HttpTarget {
  std::string path;
  std::vector<HttpField> query;
};

/// Largest number of pairs in a query.
inline constexpr std::size_t kMaxQueryPairs = 64;

/// Takes an origin-form target ("/api/scans?limit=3", RFC 9112 §3.2.1, RFC 3986) apart. Strict, so that a path means
/// one thing only: each octet is one that RFC 3986 allows there; what is percent-encoded decodes to UTF-8 (RFC 3629)
/// without control characters; the path has no "\\", no encoded "/", no empty segment but the last, and none that is
/// "." or "..", encoded or not. In the query "+" is a space, pairs are split at "&", a name is never empty. Fails with
/// what was wrong, in words that repeat nothing of the target.
[[nodiscard]] tl::expected<HttpTarget, std::string> ParseTarget(std::string_view target);

/// Whether `text` is well-formed UTF-8 without control characters (U+0000–U+001F, U+007F–U+009F).
[[nodiscard]] bool IsPlainUtf8(std::string_view text);

}  // namespace annulus
