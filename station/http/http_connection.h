#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "sim/unix_socket.h"
#include "station/http/http_head.h"
#include "station/http/http_server.h"
#include "station/http/peer_budget.h"

// Boost and OpenSSL stay in http_connection.cpp and http_server.cpp.
namespace boost::asio {
class io_context;
}
struct ssl_ctx_st;

namespace annulus {

/// Which threads of the server do a piece of work: requests; those that nothing may hold up
/// (HttpServerOptions::urgent_paths); the life of WebSockets, one after the other.
enum class HttpLane { kRequests, kUrgent, kLive };

/// What the connections of one server share. Called by the io thread, except Run.
class HttpConnectionHost {
 public:
  virtual ~HttpConnectionHost() = default;
  [[nodiscard]] virtual const HttpLimits& limits() const = 0;
  [[nodiscard]] virtual HttpHandler& handler() = 0;
  [[nodiscard]] virtual PeerBudget& budget() = 0;
  [[nodiscard]] virtual bool IsUrgent(const std::string& path) const = 0;
  /// Thread-safe. False once the server ends.
  virtual bool Run(HttpLane lane, std::function<void()> work) = 0;
  /// Tells the handler of a refusal, once a second for each peer.
  virtual void Refused(const std::string& address, const std::string& key, const std::string& reason) = 0;
  /// Room in memory for a body that is larger than HttpLimits::body_bytes; false if there is none now.
  virtual bool TakeRoom(std::size_t bytes) = 0;
  virtual void GiveRoom(std::size_t bytes) = 0;
};

/// The other side of a connection.
struct HttpPeer {
  std::string address;
  std::string key;  ///< Its account in PeerBudget.
  bool loopback = false;
};

/// One connection, from the handshake to its end. All by the io thread; what waits for the handler waits elsewhere.
///
///     handshake -> head -> [body] -> handler -> answer -> head …
///         |          |        |         |         '-> linger -> ended      (refused, "close", or the server ends)
///         |          |        |         '-> web socket -> ended
///         '----------'--------'-> ended                                    (gone, or too slow)
///
/// Every state but "handler" has a deadline (HttpLimits). Linger: all is said; what the client still sends is read and
/// thrown away for a second, because closing on unread bytes would take the answer back (RFC 9112 §9.6).
class HttpConnection {
 public:
  virtual ~HttpConnection() = default;
  virtual void Start() = 0;
  /// Takes no other request; ends once an answer that is under way is out. A WebSocket is told "going away".
  virtual void Stop() = 0;
  /// Ends now.
  virtual void Abort() = 0;
};

/// `tls`: null for none. `ended` is called once, by the io thread, when nothing more will happen. The host must outlive
/// the connection.
std::shared_ptr<HttpConnection> MakeHttpConnection(boost::asio::io_context& io, sim::OwnedFd socket, bool ipv6,
                                                   std::shared_ptr<ssl_ctx_st> tls, HttpPeer peer,
                                                   HttpConnectionHost& host,
                                                   std::function<void(HttpConnection&)> ended);

}  // namespace annulus
