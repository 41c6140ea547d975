#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/store/store_parts.h"

namespace annulus {

/// Who may log in. Their secrets (hashes of passwords and PINs, keys of second factors) are sealed with the station's
/// key. Thread-bound.
class UserTable {
 public:
  explicit UserTable(StoreParts& parts) : parts_(parts) {}

  Status Add(const User& user, const std::string& password_hash);
  Result<std::optional<User>> Get(const std::string& name);
  /// By name.
  Result<std::vector<User>> All();
  /// Role and whether enabled.
  Status Change(const User& user);
  Status Remove(const std::string& name);
  Status SetSecret(const std::string& user, const std::string& what, const std::string& secret);
  Result<std::string> Secret(const std::string& user, const std::string& what);
  Status NoteLogin(const std::string& name);

 private:
  StoreParts& parts_;
};

}  // namespace annulus
