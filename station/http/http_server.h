#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "station/http/http_message.h"

namespace annulus {

/// The other end of a WebSocket. Thread-safe. Kept by the handler as long as it likes: after the connection's end its
/// calls do nothing.
class WebSocketPeer {
 public:
  virtual ~WebSocketPeer() = default;
  /// Queues a text; never waits. A client with more than HttpLimits::socket_queue_bytes unread is dropped.
  virtual void SendText(std::shared_ptr<const std::string> text) = 0;
  /// The same for bytes.
  virtual void SendBinary(std::shared_ptr<const std::string> bytes) = 0;
  /// Bytes that wait to be sent.
  [[nodiscard]] virtual std::size_t queued_bytes() const = 0;
  /// Says goodbye with a code of RFC 6455 §7.4 and a reason of at most 123 bytes.
  virtual void Close(std::uint16_t code, std::string reason) = 0;
};

/// What the server asks of the program. Called by the server's worker threads, several at once: thread-safe. Must not
/// throw; what does is answered with 500 and logged.
class HttpHandler {
 public:
  virtual ~HttpHandler() = default;
  /// Answers a request. May take as long as HttpLimits::handler, since a few workers are all there are.
  virtual HttpResponse Handle(const HttpRequest& request) = 0;
  /// Whether a WebSocket may be opened: nothing if so, else the answer that refuses it. `peer` may be kept from here
  /// on.
  virtual std::optional<HttpResponse> Open(const HttpRequest& request, const std::shared_ptr<WebSocketPeer>& peer) = 0;
  /// A whole text that a WebSocket has sent. Calls for one peer come in order, never two at once. (Bytes are refused by
  /// the server: nothing that a client has to say is binary.)
  virtual void Received(const std::shared_ptr<WebSocketPeer>& peer, std::string_view text) = 0;
  /// A WebSocket has ended, whoever ended it. The last call for this peer.
  virtual void Closed(const std::shared_ptr<WebSocketPeer>& peer) = 0;
  /// A request that never became one was refused by the server itself (malformed, too large, too slow, too many): for
  /// the audit. At most once a second for each peer address.
  virtual void Refused(const std::string& peer, const std::string& reason) = 0;
};

/// What a client may cost. Beyond: the answer is 400, 408, 413, 414, 429, 431 or 503, and the connection ends.
struct HttpLimits {
  std::size_t connections = 256;
  std::size_t connections_per_peer = 64;
  std::size_t header_bytes = 16 << 10;
  std::size_t target_bytes = 4 << 10;
  std::size_t body_bytes = 1 << 20;
  /// Bodies of these paths may be larger: prefix and bytes (imports).
  std::vector<std::pair<std::string, std::size_t>> large_bodies;
  /// Of all bodies together that are larger than body_bytes; beyond: 503.
  std::size_t large_bodies_bytes = 256 << 20;
  std::chrono::milliseconds handshake{5000};  ///< Of TLS.
  std::chrono::milliseconds header{5000};     ///< From the first byte to the end of the head (slowloris).
  std::chrono::milliseconds body{30000};
  std::chrono::milliseconds idle{60000};     ///< Between requests of one connection.
  std::chrono::milliseconds write{30000};    ///< For an answer to be taken.
  std::chrono::milliseconds handler{30000};  ///< Advice to handlers; nothing is cut.
  double requests_per_second = 200.0;        ///< Per peer address; bad ones count four times.
  double burst = 400.0;
  std::size_t socket_message_bytes = 64 << 10;            ///< Of a text that a WebSocket sends.
  std::size_t socket_queue_bytes = std::size_t{1} << 20;  ///< Unread by a WebSocket client: it is dropped.
  std::chrono::milliseconds socket_ping{15000};  ///< A WebSocket that does not answer a ping within this is dropped.
};

struct HttpServerOptions {
  std::vector<std::string> addresses{"127.0.0.1", "::1"};  ///< To listen on; IPv6 that the system lacks is left out.
  std::uint16_t port = 0;                                  ///< 0: any free one, the same for all addresses.
  std::string certificate_pem;                             ///< Chain; empty together with the key: no TLS (tests only).
  std::string private_key_pem;
  int worker_threads = 4;
  /// Paths (whole) whose requests have a thread and a token bucket of their own, so that neither slow handlers nor a
  /// peer's other requests can hold them up: what stops the machine. Their handlers must be quick.
  std::vector<std::string> urgent_paths;
  HttpLimits limits;
};

/// HTTP/1.1 and WebSocket (RFC 9110, 9112, 6455) over TLS 1.2 or 1.3. One thread for the sockets, some workers for the
/// handler; a slow client holds neither.
class HttpServer {
 public:
  /// Listens at once. `handler` is borrowed. Fails if no address can be taken, or the certificate does not fit the key.
  static Result<std::unique_ptr<HttpServer>> Make(HttpServerOptions options, HttpHandler& handler);
  /// Ends all connections: WebSockets are told "going away", answers that are under way have a second.
  virtual ~HttpServer() = default;
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] virtual std::uint16_t port() const = 0;
  /// Takes another certificate for new connections (renewal). Fails if it does not fit the key.
  virtual Status SetIdentity(const std::string& certificate_pem, const std::string& private_key_pem) = 0;

 protected:
  HttpServer() = default;
};

}  // namespace annulus
