#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"

namespace annulus {

/// A boothd of the console's own, for `annulus serve --simulated`: the simulated booth in a process that ends with the
/// console, however that ends (PR_SET_PDEATHSIG). Thread-bound: the thread that starts it must live as long.
class BoothProcess {
 public:
  /// Runs this very program as boothd on `socket`, with `arguments` beside.
  static Result<std::unique_ptr<BoothProcess>> Start(const std::string& socket,
                                                     const std::vector<std::string>& arguments);
  /// Asks it to end, waits a second, then kills it and removes its socket.
  ~BoothProcess();
  BoothProcess(const BoothProcess&) = delete;
  BoothProcess& operator=(const BoothProcess&) = delete;

  /// Asks it to end, without waiting.
  void RequestStop() const;
  [[nodiscard]] bool runs();

 private:
  BoothProcess(pid_t pid, std::string socket) : pid_(pid), socket_(std::move(socket)) {}
  pid_t pid_;
  std::string socket_;
  bool ended_ = false;
};

}  // namespace annulus
