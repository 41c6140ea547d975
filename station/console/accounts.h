#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <tl/expected.hpp>

#include "base/clock.h"
#include "base/result.h"
#include "station/console/login_guard.h"
#include "station/store/store_types.h"

namespace annulus {

class Store;

/// 1 … 64 letters, digits, '-', '_' and '.'.
[[nodiscard]] bool IsUserName(std::string_view name);

/// Somebody asks to be let in: with a password, or a PIN.
struct LoginAttempt {
  std::string user;
  std::string secret;  ///< Password or PIN.
  bool is_pin = false;
  std::string totp;       ///< "" if none was given.
  bool loopback = false;  ///< On the booth's own screen.
  std::string peer;
};

/// Why not. Whoever asks is told only whether to wait; `why` is for the audit.
struct LoginRefusal {
  std::chrono::seconds wait{0};  ///< 0: refused; else not even looked at.
  std::string why;
};

/// Who may log in, and how. Passwords and PINs are kept hashed; second factors sealed by the store. Thread-safe.
class Accounts {
 public:
  /// All borrowed.
  Accounts(Store& store, LoginGuard& guard, const Clock& clock) : store_(store), guard_(guard), clock_(clock) {}

  /// The user, if everything is right. A PIN is good for operators on the booth's own screen. From afar technicians and
  /// admins need their second factor, and everybody who has one; an account of theirs without one is not let in.
  /// Takes the same time for a user who is not there.
  [[nodiscard]] tl::expected<User, LoginRefusal> LogIn(const LoginAttempt& attempt);

  /// Whether this is the password of somebody who is logged in; counts as a try.
  [[nodiscard]] tl::expected<void, LoginRefusal> IsPassword(const std::string& user, const std::string& password,
                                                            const std::string& peer, bool loopback);

  /// There is not a single user: the station waits to be set up.
  [[nodiscard]] Result<bool> Empty();
  /// Makes the first user, an admin; fails if there is one.
  Status MakeFirst(const std::string& name, const std::string& password);
  /// A new user with a password that passes CheckNewPassword.
  Status Add(const std::string& name, StationRole role, const std::string& password);
  Status SetPassword(const std::string& user, const std::string& password);
  /// "" takes it away.
  Status SetPin(const std::string& user, const std::string& pin);
  /// A new second factor: what an authenticator takes (totp.h). Shown once.
  Result<std::string> NewTotp(const std::string& user);
  Status DropTotp(const std::string& user);
  /// Changes role or whether it is enabled. Fails if no enabled admin would be left.
  Status Change(const User& changed);
  Status Remove(const std::string& user);
  /// Whether an enabled admin with a password is there (a station that is reached from afar must have one).
  [[nodiscard]] Result<bool> HasAdmin();

 private:
  [[nodiscard]] std::string HashFor(const User& user, const LoginAttempt& attempt, std::string& why);
  [[nodiscard]] bool SecondFactorFits(const User& user, const LoginAttempt& attempt);
  [[nodiscard]] Status CheckAdminStays(const std::string& without);

  Store& store_;
  LoginGuard& guard_;
  const Clock& clock_;
  std::mutex change_;  ///< Over looking and then changing.
};

}  // namespace annulus
