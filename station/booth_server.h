#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "acquisition/scanner.h"
#include "base/result.h"
#include "station/booth_messages.h"
#include "station/booth_socket.h"
#include "station/level_mailbox.h"

namespace annulus {

/// The booth as the server sees it. Called by the server's thread only; no call may take longer than some milliseconds.
class BoothPort {
 public:
  virtual ~BoothPort() = default;
  [[nodiscard]] virtual const BoothDescription& description() const = 0;
  virtual Status Home() = 0;
  virtual Status Arm(const ArmOrder& order) = 0;
  virtual Status Start(std::uint64_t version) = 0;
  virtual Status Cancel() = 0;
  virtual Status Acknowledge(CauseRole role) = 0;
  virtual Status Jog(Scanner::JogDirection direction) = 0;
  [[nodiscard]] virtual ScannerStatus status() const = 0;
};

/// Limits of the server.
namespace booth_limit {
inline constexpr std::size_t kViewers = 16;  ///< Beside the one session that holds control.
inline constexpr std::size_t kConnections = 32;
inline constexpr std::size_t kQueueBytes = std::size_t{1} << 20;  ///< Unread by a client: it is dropped.
inline constexpr double kRequestsPerSecond = 100.0;
inline constexpr double kBurst = 200.0;
inline constexpr int kRefusals = 1000;                          ///< Too fast so often in a row: dropped.
inline constexpr std::chrono::seconds kHelloWithin{2};          ///< Or dropped.
inline constexpr std::chrono::milliseconds kStatusEvery{500};   ///< At least.
inline constexpr std::chrono::milliseconds kStatusAtMost{100};  ///< When nothing but a position or progress changed.
inline constexpr std::chrono::milliseconds kLook{20};           ///< Between looks at the booth's status.
}  // namespace booth_limit

/// Serves the booth to its clients on a Unix socket (docs/wire_protocol.md):
///
///     connected --hello--> viewer                    may: cancel, status, subscribe
///               --hello, control, nobody has it-->   operator: and home, arm, start, acknowledge
///                                                    technician: and jog, and acknowledge service faults
///
/// Cancel is for everybody, also before hello and from who sends too much. A session that held control and goes away
/// leaves a running scan alone, but ends a jog at once. Who does not read loses the connection, never the booth's time.
/// Thread-bound: Serve runs in the caller's thread.
class BoothServer {
 public:
  /// Takes a socket that listens; who has connected to it already is served then. Borrows port and levels.
  static Result<std::unique_ptr<BoothServer>> Make(BoothSocket socket, BoothPort& port, LevelMailbox& levels);
  ~BoothServer();
  BoothServer(const BoothServer&) = delete;
  BoothServer& operator=(const BoothServer&) = delete;

  /// Until a stop is asked for; then all clients are told goodbye.
  void Serve(const std::stop_token& stop);

 private:
  class Impl;
  explicit BoothServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace annulus
