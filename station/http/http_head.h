#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "station/http/http_message.h"
#include "station/http/http_server.h"

namespace annulus {

/// Why the server itself refuses a request: the status of the answer and the reason in words that repeat nothing of
/// what was sent (it goes to a log).
struct HttpProblem {
  int status = 400;
  std::string reason;
};

/// How the end of a request's body is known (RFC 9112 §6.3).
enum class HttpFraming { kNone, kLength, kChunked };

/// The head of a request: what a handler will see, without the body, and what the server needs for the rest.
struct HttpHead {
  HttpRequest request;      ///< Method GET for a HEAD. Peer, loopback, tls and body are left to the connection.
  int minor_version = 1;    ///< Of HTTP/1.
  bool head_only = false;   ///< It was a HEAD: the answer goes without its body.
  bool keep_alive = false;  ///< The connection may go on after the answer.
  bool web_socket = false;  ///< A valid opening handshake of RFC 6455 §4.2.1.
  bool expects_continue = false;
  HttpFraming framing = HttpFraming::kNone;
  std::uint64_t length = 0;    ///< Of the body, with kLength.
  std::size_t body_limit = 0;  ///< Largest body that this path may have.
};

/// Bytes of the head at the beginning of `received`, with its empty line; 0 if it is not all there.
/// `searched`: bytes that were there at the last call, so that a trickle is not searched again and again.
[[nodiscard]] std::size_t FindHeadEnd(std::string_view received, std::size_t searched);

/// Why an incomplete head is refused before it is all there: too long by now, or already malformed. Status 0: go on.
[[nodiscard]] HttpProblem CheckPartialHead(std::string_view received, const HttpLimits& limits);

/// Parses a head, from the request line to the empty line. Stricter than RFC 9112 asks where programs in a chain have
/// disagreed (request smuggling): lines end in CR LF; no folded lines; no space before a colon; one Host, always; one
/// Content-Length, digits only; never both Content-Length and Transfer-Encoding; no coding but "chunked"; no body with
/// GET or HEAD. Beyond that: targets as ParseTarget takes them (no absolute-form: there is no proxy); methods of
/// RFC 9110 and PATCH without CONNECT and TRACE; no upgrade but to websocket; no expectation but 100-continue.
/// Statuses: 400, 413, 414, 417, 426, 431, 501, 505.
[[nodiscard]] tl::expected<HttpHead, HttpProblem> ParseHead(std::string_view head, const HttpLimits& limits);

}  // namespace annulus
