#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

#include "base/result.h"

namespace annulus {

/// A boothd of the console's own, for `annulus serve --simulated`: the simulated booth in a process that ends with the
/// console, however that ends (PR_SET_PDEATHSIG). Thread-bound: the thread that starts it must live as long.
class BoothProcess {
 public:
  /// Runs this very program with `arguments`. Called before other threads hold locks that the child would wait for.
  static Result<std::unique_ptr<BoothProcess>> Start(const std::vector<std::string>& arguments);
  /// Asks it to end, waits a second, then kills it.
  ~BoothProcess();
  BoothProcess(const BoothProcess&) = delete;
  BoothProcess& operator=(const BoothProcess&) = delete;

  /// Asks it to end, without waiting.
  void RequestStop() const;
  [[nodiscard]] bool runs();

 private:
  explicit BoothProcess(pid_t pid) : pid_(pid) {}
  pid_t pid_;
  bool ended_ = false;
};

}  // namespace annulus
