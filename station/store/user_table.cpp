#include "station/store/user_table.h"

#include <utility>

#include "station/store/sealed_text.h"

namespace annulus {
namespace {

constexpr std::string_view kColumns = R"sql(
SELECT name, role, enabled, created_ms, last_login_ms,
  EXISTS (SELECT 1 FROM secrets WHERE user = name AND what = 'pin'),
  EXISTS (SELECT 1 FROM secrets WHERE user = name AND what = 'totp') FROM users )sql";

User RowFrom(const SqlRow& row) {
  User user;
  user.name = row.Text(0);
  user.role = ParseStationRole(row.Text(1)).value_or(StationRole::kNone);
  user.enabled = row.Number(2) != 0;
  user.created = StoreTime(row.Number(3));
  if (!row.IsNull(4)) user.last_login = StoreTime(row.Number(4));
  user.has_pin = row.Number(5) != 0;
  user.has_totp = row.Number(6) != 0;
  return user;
}

Status CheckName(const std::string& name) {
  constexpr std::size_t kMaxName = 64;
  if (!name.empty() && name.size() <= kMaxName &&
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.") ==
          std::string::npos) {
    return {};
  }
  return Fail("store a user", "this is no user's name", "give 1 to 64 letters, digits, '-', '_' or '.'");
}

Status CheckWhat(const std::string& what) {
  if (what == "password" || what == "pin" || what == "totp") return {};
  return Fail("store a secret", "'" + what + "' is none of password, pin, totp", "give one of these");
}

std::string ContextOf(const std::string& user, const std::string& what) { return SealContext({"secrets", user, what}); }

}  // namespace

Status UserTable::Add(const User& user, const std::string& password_hash) {
  RETURN_IF_ERROR(CheckName(user.name));
  const auto known = Get(user.name);
  if (!known) return Fail(known);
  if (*known) return Fail("add the user " + user.name, "there is one of this name", "choose another name");
  RETURN_IF_ERROR(parts_.database.Run(
      "INSERT INTO users VALUES (?1, ?2, ?3, ?4, NULL)",
      {user.name, StationRoleName(user.role), static_cast<std::int64_t>(user.enabled ? 1 : 0), parts_.Now().count()}));
  return SetSecret(user.name, "password", password_hash);
}

Result<std::optional<User>> UserTable::Get(const std::string& name) {
  std::optional<User> user;
  const Status status =
      parts_.database.ForEach(std::string(kColumns) + "WHERE name = ?1", {name}, [&](const SqlRow& row) {
        user = RowFrom(row);
        return Status();
      });
  if (!status) return Fail(status);
  return user;
}

Result<std::vector<User>> UserTable::All() {
  std::vector<User> users;
  const Status status = parts_.database.ForEach(std::string(kColumns) + "ORDER BY name", {}, [&](const SqlRow& row) {
    users.push_back(RowFrom(row));
    return Status();
  });
  if (!status) return Fail(status);
  return users;
}

Status UserTable::Change(const User& user) {
  RETURN_IF_ERROR(
      parts_.database.Run("UPDATE users SET role = ?2, enabled = ?3 WHERE name = ?1",
                          {user.name, StationRoleName(user.role), static_cast<std::int64_t>(user.enabled ? 1 : 0)}));
  if (parts_.database.changes() == 0) return NoSuchRow("user", user.name);
  return {};
}

Status UserTable::Remove(const std::string& name) {
  RETURN_IF_ERROR(parts_.database.Run("DELETE FROM users WHERE name = ?1", {name}));
  if (parts_.database.changes() == 0) return NoSuchRow("user", name);
  return {};
}

Status UserTable::SetSecret(const std::string& user, const std::string& what, const std::string& secret) {
  RETURN_IF_ERROR(CheckWhat(what));
  const auto known = Get(user);
  if (!known) return Fail(known);
  if (!*known) return NoSuchRow("user", user);
  if (secret.empty()) {
    return parts_.database.Run("DELETE FROM secrets WHERE user = ?1 AND what = ?2", {user, what});
  }
  const auto sealed = parts_.vault.SealForStation(secret, ContextOf(user, what));
  if (!sealed) return Fail(sealed);
  return parts_.database.Run("INSERT OR REPLACE INTO secrets VALUES (?1, ?2, ?3)", {user, what, *sealed});
}

Result<std::string> UserTable::Secret(const std::string& user, const std::string& what) {
  RETURN_IF_ERROR(CheckWhat(what));
  std::optional<std::vector<std::byte>> sealed;
  RETURN_IF_ERROR(parts_.database.ForEach("SELECT sealed FROM secrets WHERE user = ?1 AND what = ?2", {user, what},
                                          [&](const SqlRow& row) {
                                            sealed = row.Bytes(0);
                                            return Status();
                                          }));
  if (!sealed) return Fail("read the " + what + " of " + user, "there is none", "set one");
  return parts_.vault.OpenForStation(*sealed, ContextOf(user, what), "the " + what + " of " + user);
}

Status UserTable::NoteLogin(const std::string& name) {
  RETURN_IF_ERROR(
      parts_.database.Run("UPDATE users SET last_login_ms = ?2 WHERE name = ?1", {name, parts_.Now().count()}));
  if (parts_.database.changes() == 0) return NoSuchRow("user", name);
  return {};
}

}  // namespace annulus
