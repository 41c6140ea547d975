#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "base/storage.h"
#include "station/config.h"

namespace annulus {

class Accounts;
class Store;

struct ConsoleServerOptions {
  Config config;
  std::string config_path;  ///< As it was given: "sim" or a file.
  std::string folder;       ///< Of the store, the station key unless the configuration says otherwise, the certificate.
  std::vector<std::string> remote;  ///< Addresses to listen on beside loopback, in digits.
  std::uint16_t port = 8437;        ///< 0: any that is free.
  std::string booth_socket;
  std::string web_folder;
  std::string job_program = "/proc/self/exe";  ///< What jobs run: this program.
};

/// The operator's console as a whole: store, line to boothd, jobs, routes, and the HTTPS server on top. Made in two
/// steps, since who may log in is looked at in between.
class ConsoleServer {
 public:
  /// Opens what is to be served; nothing listens yet. Storage and clock are borrowed.
  static Result<std::unique_ptr<ConsoleServer>> Open(ConsoleServerOptions options, Storage& storage,
                                                     const Clock& clock);
  /// Tells browsers "going away", ends jobs; within 2 s.
  virtual ~ConsoleServer() = default;

  /// Listens, and connects to boothd, from now on.
  virtual Status Listen() = 0;
  /// What is to be done about once a second: sessions whose time is over, the certificate, retention.
  virtual void Tick() = 0;

  [[nodiscard]] virtual Accounts& accounts() = 0;
  [[nodiscard]] virtual Store& store() = 0;
  [[nodiscard]] virtual std::uint16_t port() const = 0;
  /// SHA-256 of the certificate authority's certificate, "AB:CD:…".
  [[nodiscard]] virtual std::string fingerprint() const = 0;
  /// What the station lacks but can do without; for the terminal.
  [[nodiscard]] virtual std::vector<std::string> notes() const = 0;

 protected:
  ConsoleServer() = default;
};

/// The key of the station that `options` say: sealed recordings of boothd are opened with it.
[[nodiscard]] std::string StationKeyFile(const ConsoleServerOptions& options);

}  // namespace annulus
