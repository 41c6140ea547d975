#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace annulus::test {

/// An answer as this client reads it: with a reader of its own, not the server's.
struct RawAnswer {
  int status = 0;
  std::map<std::string, std::string> headers;  ///< Names in lower case.
  std::string body;
};

/// A frame of RFC 6455 §5.2 from the server.
struct RawFrame {
  int opcode = -1;
  bool final = false;
  std::string payload;
};

/// How a client connects.
struct RawTarget {
  std::uint16_t port = 0;
  std::string address = "127.0.0.1";
  std::string source;         ///< Address to come from: another peer, as 127.0.0.2. Empty: whatever the system takes.
  std::string authority_pem;  ///< With TLS: whom to trust. Empty: no TLS.
  std::string name = "localhost";
  int receive_buffer_bytes = 0;  ///< 0: the system's.
};

/// A client that can do everything wrong: bytes over TCP or TLS, with POSIX and OpenSSL. Waits at most `patience` for
/// each thing. Thread-bound.
class RawClient {
 public:
  /// Null if the connection or its handshake failed.
  static std::unique_ptr<RawClient> Connect(const RawTarget& target);
  virtual ~RawClient() = default;

  /// False if the other side has closed, or takes nothing.
  virtual bool Send(std::string_view bytes) = 0;
  /// What there is, at least one byte; empty at the end of the stream, on an error, or when patience is over.
  virtual std::string Receive() = 0;
  /// The time for each Send and Receive.
  virtual void SetPatience(std::chrono::milliseconds patience) = 0;
  /// Ends the sending side only.
  virtual void HalfClose() = 0;
  /// Closes so that the other side gets a reset.
  virtual void Reset() = 0;

  /// Everything up to the end of the stream.
  std::string ReceiveAll();
  /// The next answer; status 0 if none came whole. `head_only`: an answer to HEAD.
  RawAnswer ReadAnswer(bool head_only = false);
  /// Sends a request and reads its answer.
  RawAnswer Ask(std::string_view request);
  /// True if the server ends the connection (and says nothing more) within the time.
  bool SeesEnd();

  /// Opens a WebSocket; the answer to the handshake.
  RawAnswer OpenWebSocket(const std::string& path = "/live", const std::string& more_headers = {});
  /// Sends a masked frame.
  bool SendFrame(int opcode, std::string_view payload, bool final = true);
  /// The next frame; opcode −1 if none came.
  RawFrame ReadFrame();

 protected:
  std::string pending_;  ///< Received, not yet read.

 private:
  bool Fill();
};

/// A GET of `path` with what every request needs.
[[nodiscard]] std::string Get(const std::string& path, const std::string& more_headers = {});
/// A POST with a body and its length.
[[nodiscard]] std::string Post(const std::string& path, const std::string& body, const std::string& more_headers = {});

}  // namespace annulus::test
