#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace annulus {

/// A header or a query's pair: name and value.
using HttpField = std::pair<std::string, std::string>;

/// A request as a handler sees it: whole, within the server's limits, and well-formed.
struct HttpRequest {
  std::string method;              ///< "GET", "POST" …
  std::string path;                ///< Decoded, begins with '/', has no "." or ".." segments, no control characters.
  std::vector<HttpField> query;    ///< Decoded, in order.
  std::vector<HttpField> headers;  ///< Names in lower case, in order; repeated ones are kept.
  std::string body;
  std::string peer;       ///< Address of the other side, without its port.
  bool loopback = false;  ///< The other side is on this machine.
  bool tls = false;

  /// Value of the first header of this lower-case name.
  [[nodiscard]] std::optional<std::string_view> Header(std::string_view name) const;
  /// How many headers of this lower-case name there are.
  [[nodiscard]] std::size_t HeaderCount(std::string_view name) const;
  /// Value of the first query pair of this name.
  [[nodiscard]] std::optional<std::string_view> Query(std::string_view name) const;
  /// Value of the cookie of this name; nothing if it is there twice.
  [[nodiscard]] std::optional<std::string_view> Cookie(std::string_view name) const;
};

/// An answer. The server adds Content-Length, Date, Connection.
struct HttpResponse {
  int status = 200;
  std::string content_type;
  std::vector<HttpField> headers;  ///< Beside Content-Type.
  std::string body;
};

}  // namespace annulus
