#include "station/console/accounts.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/log.h"
#include "station/console/passwords.h"
#include "station/console/totp.h"
#include "station/store/store.h"

namespace annulus {
namespace {

Error NoSuchUser(const std::string& attempted) { return {attempted, "there is no such user", "see the list of users"}; }

}  // namespace

bool IsUserName(std::string_view name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
           c == '.';
  });
}

std::string Accounts::HashFor(const User& user, const LoginAttempt& attempt, std::string& why) {
  if (!user.enabled) {
    why = "the account is switched off";
    return "";
  }
  if (attempt.is_pin && (!attempt.loopback || user.role != StationRole::kOperator)) {
    why = "a PIN is for operators at the booth";
    return "";
  }
  auto hash = store_.Secret(user.name, attempt.is_pin ? "pin" : "password");
  why = attempt.is_pin ? "wrong PIN" : "wrong password";
  return hash ? std::move(*hash) : std::string();
}

bool Accounts::SecondFactorFits(const User& user, const LoginAttempt& attempt) {
  const bool needed = !attempt.loopback && (user.role != StationRole::kOperator || user.has_totp);
  if (!needed) return true;
  const std::lock_guard lock(change_);  // one code opens one session
  const auto text = store_.Secret(user.name, "totp");
  if (!text) return false;
  auto secret = TotpSecret::Parse(*text);
  if (!secret) return false;
  const auto step = VerifyTotp(*secret, attempt.totp, clock_.WallNow());
  if (!step) return false;
  secret->last_step = *step;
  const Status kept = store_.SetSecret(user.name, "totp", secret->Text());
  if (!kept) Log(LogLevel::kError, "console: " + kept.error().Text());
  return kept.has_value();  // a code that could be used again is none
}

tl::expected<User, LoginRefusal> Accounts::LogIn(const LoginAttempt& attempt) {
  if (const auto wait = guard_.Begin(attempt.user, attempt.peer, attempt.loopback)) {
    return tl::unexpected(LoginRefusal{*wait, "too many tries"});
  }
  std::optional<User> user;
  if (IsUserName(attempt.user)) {
    auto found = store_.GetUser(attempt.user);
    if (found) user = std::move(*found);
  }
  std::string why = "no such account";
  const std::string hash = user ? HashFor(*user, attempt, why) : std::string();
  if (!VerifyPassword(hash, attempt.secret)) return tl::unexpected(LoginRefusal{{}, why});
  if (!SecondFactorFits(*user, attempt)) return tl::unexpected(LoginRefusal{{}, "no or wrong second factor"});
  guard_.Succeeded(attempt.user, attempt.loopback);
  if (const Status noted = store_.NoteLogin(user->name); !noted) {
    Log(LogLevel::kWarning, "console: " + noted.error().Text());  // a store that is read-only keeps nobody out
  }
  return std::move(*user);
}

tl::expected<void, LoginRefusal> Accounts::IsPassword(const std::string& user, const std::string& password,
                                                      const std::string& peer, bool loopback) {
  if (const auto wait = guard_.Begin(user, peer, loopback)) {
    return tl::unexpected(LoginRefusal{*wait, "too many tries"});
  }
  const auto hash = store_.Secret(user, "password");
  if (!VerifyPassword(hash ? *hash : "", password)) return tl::unexpected(LoginRefusal{{}, "wrong password"});
  guard_.Succeeded(user, loopback);
  return {};
}

Result<bool> Accounts::Empty() {
  const auto users = store_.Users();
  if (!users) return Fail(users);
  return users->empty();
}

Status Accounts::MakeFirst(const std::string& name, const std::string& password) {
  const std::lock_guard lock(change_);
  const auto empty = Empty();
  if (!empty) return Fail(empty);
  if (!*empty) return Fail("make the first user", "there are users", "log in as one of them");
  return Add(name, StationRole::kAdmin, password);
}

Status Accounts::Add(const std::string& name, StationRole role, const std::string& password) {
  if (!IsUserName(name)) {
    return Fail("make a user", "the name is not 1 to 64 letters, digits, '-', '_' or '.'", "take another name");
  }
  RETURN_IF_ERROR(CheckNewPassword(password, name));
  const auto there = store_.GetUser(name);
  if (!there) return Fail(there);
  if (*there) return Fail("make a user", "there is one of this name", "take another name");
  const auto hash = HashPassword(password);
  if (!hash) return Fail(hash);
  User user;
  user.name = name;
  user.role = role;
  return store_.AddUser(user, *hash);
}

Status Accounts::SetPassword(const std::string& user, const std::string& password) {
  RETURN_IF_ERROR(CheckNewPassword(password, user));
  const auto hash = HashPassword(password);
  if (!hash) return Fail(hash);
  return store_.SetSecret(user, "password", *hash);
}

Status Accounts::SetPin(const std::string& user, const std::string& pin) {
  if (pin.empty()) return store_.SetSecret(user, "pin", "");
  const auto found = store_.GetUser(user);
  if (!found) return Fail(found);
  if (!*found) return tl::unexpected(NoSuchUser("set a PIN"));
  if ((*found)->role != StationRole::kOperator) {
    return Fail("set a PIN", "the user is no operator", "a PIN is for operators; others use their passwords");
  }
  RETURN_IF_ERROR(CheckNewPin(pin));
  const auto hash = HashPassword(pin);
  if (!hash) return Fail(hash);
  return store_.SetSecret(user, "pin", *hash);
}

Result<std::string> Accounts::NewTotp(const std::string& user) {
  const TotpSecret secret = TotpSecret::Random();
  const std::lock_guard lock(change_);
  RETURN_IF_ERROR(store_.SetSecret(user, "totp", secret.Text()));
  return secret.Uri(user);
}

Status Accounts::DropTotp(const std::string& user) { return store_.SetSecret(user, "totp", ""); }

Status Accounts::CheckAdminStays(const std::string& without) {
  const auto users = store_.Users();
  if (!users) return Fail(users);
  const bool another = std::any_of(users->begin(), users->end(), [&](const User& user) {
    return user.role == StationRole::kAdmin && user.enabled && user.name != without;
  });
  if (another) return {};
  return Fail("change user " + without, "it is the last admin", "make another admin first");
}

Status Accounts::Change(const User& changed) {
  const std::lock_guard lock(change_);
  const bool stays_admin = changed.role == StationRole::kAdmin && changed.enabled;
  if (!stays_admin) RETURN_IF_ERROR(CheckAdminStays(changed.name));
  // A PIN is good for operators only: one who becomes something else loses it.
  if (changed.has_pin && changed.role != StationRole::kOperator) {
    RETURN_IF_ERROR(store_.SetSecret(changed.name, "pin", ""));
  }
  return store_.ChangeUser(changed);
}

Status Accounts::Remove(const std::string& user) {
  const std::lock_guard lock(change_);
  RETURN_IF_ERROR(CheckAdminStays(user));
  return store_.RemoveUser(user);
}

Result<bool> Accounts::HasAdmin() {
  const auto users = store_.Users();
  if (!users) return Fail(users);
  for (const User& user : *users) {
    if (user.role != StationRole::kAdmin || !user.enabled) continue;
    const auto hash = store_.Secret(user.name, "password");
    if (hash && !hash->empty()) return true;
  }
  return false;
}

}  // namespace annulus
