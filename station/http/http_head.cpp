#include "station/http/http_head.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "station/http/http_target.h"

namespace annulus {
namespace {

constexpr std::string_view kLineEnd = "\r\n";
/// Beside the target in a request line: the longest method, two spaces, "HTTP/1.1".
constexpr std::size_t kRequestLineRest = 32;
constexpr std::size_t kMaxFields = 100;
constexpr std::size_t kLengthDigits = 15;
/// Base64 of the 16 bytes of Sec-WebSocket-Key.
constexpr std::size_t kSocketKeyLetters = 24;

using Problem = tl::unexpected<HttpProblem>;
Problem Refuse(int status, std::string reason) { return Problem(HttpProblem{status, std::move(reason)}); }

bool IsLetterOrDigit(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); }

/// RFC 9110 §5.6.2.
bool IsToken(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return IsLetterOrDigit(c) || std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
  });
}

/// RFC 9110 §5.5: visible characters, spaces and tabs, and bytes beyond ASCII (obs-text).
bool IsFieldValue(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    const auto octet = static_cast<unsigned char>(c);
    return octet == '\t' || (octet >= 0x20 && octet != 0x7F);
  });
}

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::string_view Trim(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// The members of a comma-separated list in all fields of this name, in lower case.
std::vector<std::string> ListOf(const HttpRequest& request, std::string_view name) {
  std::vector<std::string> members;
  for (const HttpField& field : request.headers) {
    if (field.first != name) continue;
    std::string_view rest = field.second;
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find(','), rest.size());
      members.push_back(Lower(Trim(rest.substr(0, end))));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  return members;
}

bool Contains(const std::vector<std::string>& members, std::string_view member) {
  return std::find(members.begin(), members.end(), member) != members.end();
}

std::optional<HttpProblem> ParseMethod(std::string_view method, HttpHead& head) {
  constexpr std::array<std::string_view, 7> kMethods{"GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS", "PATCH"};
  if (!IsToken(method)) return HttpProblem{400, "malformed request line"};
  if (std::find(kMethods.begin(), kMethods.end(), method) == kMethods.end()) return HttpProblem{501, "unknown method"};
  head.head_only = method == "HEAD";
  head.request.method = head.head_only ? "GET" : std::string(method);
  return std::nullopt;
}

/// RFC 9112 §2.3: "HTTP/" DIGIT "." DIGIT.
std::optional<HttpProblem> ParseVersion(std::string_view version, HttpHead& head) {
  const auto digit = [&](std::size_t i) { return version[i] >= '0' && version[i] <= '9'; };
  const bool formed = version.size() == 8 && version.starts_with("HTTP/") && digit(5) && version[6] == '.' && digit(7);
  if (!formed) return HttpProblem{400, "malformed request line"};
  if (version != "HTTP/1.1" && version != "HTTP/1.0") return HttpProblem{505, "a version other than HTTP/1.0 or 1.1"};
  head.minor_version = version == "HTTP/1.1" ? 1 : 0;
  return std::nullopt;
}

std::optional<HttpProblem> ParseRequestLine(std::string_view line, const HttpLimits& limits, HttpHead& head) {
  const std::size_t first = line.find(' ');
  const std::size_t last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) return HttpProblem{400, "malformed request line"};
  if (auto problem = ParseMethod(line.substr(0, first), head)) return problem;
  if (auto problem = ParseVersion(line.substr(last + 1), head)) return problem;
  const std::string_view target = line.substr(first + 1, last - first - 1);
  if (target.size() > limits.target_bytes) return HttpProblem{414, "target too long"};
  auto parsed = ParseTarget(target);
  if (!parsed) return HttpProblem{400, "malformed target: " + parsed.error()};
  head.request.path = std::move(parsed->path);
  head.request.query = std::move(parsed->query);
  return std::nullopt;
}

std::optional<HttpProblem> ParseField(std::string_view line, HttpHead& head) {
  if (line.front() == ' ' || line.front() == '\t') return HttpProblem{400, "folded header line"};
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || !IsToken(line.substr(0, colon))) {
    return HttpProblem{400, "malformed header name"};
  }
  const std::string_view value = Trim(line.substr(colon + 1));
  if (!IsFieldValue(value)) return HttpProblem{400, "malformed header value"};
  if (head.request.headers.size() == kMaxFields) return HttpProblem{431, "too many headers"};
  head.request.headers.emplace_back(Lower(line.substr(0, colon)), std::string(value));
  return std::nullopt;
}

/// RFC 9112 §3.2: one Host, of an authority's characters (RFC 3986 §3.2, without user information).
std::optional<HttpProblem> CheckHost(const HttpRequest& request) {
  if (request.HeaderCount("host") != 1) return HttpProblem{400, "no Host, or more than one"};
  const std::string_view host = *request.Header("host");
  const bool formed = !host.empty() && std::all_of(host.begin(), host.end(), [](char c) {
    return IsLetterOrDigit(c) || std::string_view("-._~:[]").find(c) != std::string_view::npos;
  });
  if (!formed) return HttpProblem{400, "malformed Host"};
  return std::nullopt;
}

std::optional<HttpProblem> ParseLength(std::string_view text, HttpHead& head) {
  const bool digits = std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (text.empty() || !digits) return HttpProblem{400, "malformed Content-Length"};
  if (text.size() > kLengthDigits) return HttpProblem{413, "body too large"};
  for (const char c : text) head.length = 10 * head.length + static_cast<std::uint64_t>(c - '0');
  if (head.length > 0) head.framing = HttpFraming::kLength;
  return std::nullopt;
}

std::size_t BodyLimit(const std::string& path, const HttpLimits& limits) {
  std::size_t bytes = limits.body_bytes;
  for (const auto& [prefix, larger] : limits.large_bodies) {
    if (path.starts_with(prefix)) bytes = std::max(bytes, larger);
  }
  return bytes;
}

/// RFC 9112 §6.
std::optional<HttpProblem> CheckFraming(const HttpLimits& limits, HttpHead& head) {
  const HttpRequest& request = head.request;
  const std::size_t lengths = request.HeaderCount("content-length");
  const std::size_t codings = request.HeaderCount("transfer-encoding");
  if (lengths > 0 && codings > 0) return HttpProblem{400, "both Content-Length and Transfer-Encoding"};
  if (lengths > 1) return HttpProblem{400, "more than one Content-Length"};
  if (lengths == 1) {
    if (auto problem = ParseLength(*request.Header("content-length"), head)) return problem;
  }
  if (codings > 0) {
    // With 1.0 there is no chunked coding: who sends it has been passed on by something that did not understand it.
    if (head.minor_version == 0) return HttpProblem{400, "Transfer-Encoding with HTTP/1.0"};
    if (codings > 1 || Lower(*request.Header("transfer-encoding")) != "chunked") {
      return HttpProblem{501, "a transfer coding other than chunked"};
    }
    head.framing = HttpFraming::kChunked;
  }
  if (head.framing != HttpFraming::kNone && request.method == "GET") return HttpProblem{400, "GET with a body"};
  head.body_limit = BodyLimit(request.path, limits);
  if (head.length > head.body_limit) return HttpProblem{413, "body too large"};
  return std::nullopt;
}

/// Base64 of exactly 16 bytes (RFC 4648 §4): 22 letters, of which the last carries four bits that count, and "==".
bool IsSocketKey(std::string_view key) {
  if (key.size() != kSocketKeyLetters || !key.ends_with("==")) return false;
  const bool letters =
      std::all_of(key.begin(), key.end() - 2, [](char c) { return IsLetterOrDigit(c) || c == '+' || c == '/'; });
  return letters && std::string_view("AQgw").find(key[kSocketKeyLetters - 3]) != std::string_view::npos;
}

/// RFC 6455 §4.2.1.
std::optional<HttpProblem> CheckUpgrade(HttpHead& head) {
  const HttpRequest& request = head.request;
  if (request.HeaderCount("upgrade") == 0) return std::nullopt;
  const std::vector<std::string> upgrades = ListOf(request, "upgrade");
  if (upgrades.size() != 1 || upgrades.front() != "websocket")
    return HttpProblem{400, "an upgrade other than websocket"};
  const bool get = request.method == "GET" && !head.head_only && head.minor_version == 1;
  if (!get || !Contains(ListOf(request, "connection"), "upgrade")) {
    return HttpProblem{400, "malformed WebSocket handshake"};
  }
  if (request.HeaderCount("sec-websocket-version") != 1 || *request.Header("sec-websocket-version") != "13") {
    return HttpProblem{426, "a WebSocket version other than 13"};
  }
  if (request.HeaderCount("sec-websocket-key") != 1 || !IsSocketKey(*request.Header("sec-websocket-key"))) {
    return HttpProblem{400, "malformed WebSocket handshake"};
  }
  head.web_socket = true;
  return std::nullopt;
}

std::optional<HttpProblem> CheckConnection(HttpHead& head) {
  if (head.request.HeaderCount("expect") > 0) {
    const std::vector<std::string> expectations = ListOf(head.request, "expect");
    if (expectations.size() != 1 || expectations.front() != "100-continue") {
      return HttpProblem{417, "an expectation other than 100-continue"};
    }
    // RFC 9110 §10.1.1: of a 1.0 client it is passed over.
    head.expects_continue = head.minor_version == 1 && head.framing != HttpFraming::kNone;
  }
  if (auto problem = CheckUpgrade(head)) return problem;
  head.keep_alive = head.minor_version == 1 && !Contains(ListOf(head.request, "connection"), "close");
  return std::nullopt;
}

}  // namespace

std::size_t FindHeadEnd(std::string_view received, std::size_t searched) {
  constexpr std::string_view kEnd = "\r\n\r\n";
  const std::size_t from = searched < kEnd.size() ? 0 : searched - (kEnd.size() - 1);
  const std::size_t found = received.find(kEnd, from);
  return found == std::string_view::npos ? 0 : found + kEnd.size();
}

HttpProblem CheckPartialHead(std::string_view received, const HttpLimits& limits) {
  const std::size_t line = received.find('\n');
  if (line == std::string_view::npos && received.size() > limits.target_bytes + kRequestLineRest) {
    return {414, "target too long"};
  }
  if (received.size() >= limits.header_bytes) return {431, "head too large"};
  if (line != std::string_view::npos && (line == 0 || received[line - 1] != '\r')) return {400, "malformed line end"};
  // What no request line begins with: another protocol altogether. Its end would never come.
  if (!received.empty() && !IsToken(received.substr(0, 1))) return {400, "malformed request line"};
  return {0, {}};
}

tl::expected<HttpHead, HttpProblem> ParseHead(std::string_view text, const HttpLimits& limits) {
  if (text.size() > limits.header_bytes) return Refuse(431, "head too large");
  HttpHead head;
  bool first = true;
  while (true) {
    const std::size_t end = text.find(kLineEnd);
    if (end == std::string_view::npos) return Refuse(400, "malformed line end");
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + kLineEnd.size());
    if (line.empty() && !first) break;
    auto problem = first ? ParseRequestLine(line, limits, head) : ParseField(line, head);
    if (problem) return Problem(std::move(*problem));
    first = false;
  }
  if (!text.empty()) return Refuse(400, "malformed line end");
  if (auto problem = CheckHost(head.request)) return Problem(std::move(*problem));
  if (auto problem = CheckFraming(limits, head)) return Problem(std::move(*problem));
  if (auto problem = CheckConnection(head)) return Problem(std::move(*problem));
  return head;
}

}  // namespace annulus
