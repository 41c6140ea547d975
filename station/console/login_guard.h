#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "base/clock.h"

namespace annulus {

/// How often somebody may try to log in.
struct LoginLimits {
  int free_tries = 5;                          ///< Of one user in one minute.
  int free_tries_of_address = 20;              ///< Of one address in one minute, whoever it says it is.
  std::chrono::seconds window{60};             ///< After so long without a try they are forgotten.
  std::chrono::seconds first_wait{30};         ///< After the last free try; doubles with every one that follows.
  std::chrono::seconds longest_wait{15 * 60};  ///< After so long behind a wait without a try, too.
};

/// Slows down guessing: counts tries by user and by address. Tries on the booth's own screen and from afar are counted
/// apart, so that nobody afar can lock out who stands at the booth. Memory is bounded: what has been quiet longest is
/// forgotten first. Thread-safe.
class LoginGuard {
 public:
  explicit LoginGuard(const Clock& clock, LoginLimits limits = {}) : clock_(clock), limits_(limits) {}

  /// Asks to try, and counts it (before the password is looked at, so that tries at the same time count too). Nothing
  /// if it may be tried, else how long to wait.
  [[nodiscard]] std::optional<std::chrono::seconds> Begin(const std::string& user, const std::string& peer,
                                                          bool loopback);
  /// The try was good: the user's tries are forgotten, the address's are not.
  void Succeeded(const std::string& user, bool loopback);

 private:
  struct Tries {
    int count = 0;
    std::chrono::nanoseconds last{0};
    std::chrono::nanoseconds not_before{0};
  };
  std::optional<std::chrono::seconds> Count(const std::string& key, int free_tries);
  void MakeRoom();

  const Clock& clock_;
  LoginLimits limits_;
  std::mutex mutex_;
  std::map<std::string, Tries> tries_;
};

}  // namespace annulus
