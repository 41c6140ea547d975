#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

struct sqlite3;

namespace annulus::test {

/// SQLite as another program would use it on a store's database.
class RawDatabase {
 public:
  explicit RawDatabase(const std::string& path);
  ~RawDatabase();
  RawDatabase(const RawDatabase&) = delete;
  RawDatabase& operator=(const RawDatabase&) = delete;

  /// Runs statements; what SQLite says, empty if all went well.
  std::string Try(const std::string& sql);
  /// The first column of the first row, as text.
  std::string Ask(const std::string& sql);

 private:
  sqlite3* handle_ = nullptr;
};

}  // namespace annulus::test
