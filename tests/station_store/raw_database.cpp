#include "tests/station_store/raw_database.h"

#include <sqlite3.h>

namespace annulus::test {

RawDatabase::RawDatabase(const std::string& path) {
  EXPECT_EQ(sqlite3_open(path.c_str(), &handle_), SQLITE_OK) << path;
}

RawDatabase::~RawDatabase() { sqlite3_close(handle_); }

std::string RawDatabase::Try(const std::string& sql) {
  if (sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK) return {};
  return sqlite3_errmsg(handle_);
}

std::string RawDatabase::Ask(const std::string& sql) {
  std::string answer;
  const auto first = [](void* target, int, char** values, char**) {
    auto* text = static_cast<std::string*>(target);
    if (text->empty() && values[0] != nullptr) *text = values[0];
    return 0;
  };
  EXPECT_EQ(sqlite3_exec(handle_, sql.c_str(), first, &answer, nullptr), SQLITE_OK) << sqlite3_errmsg(handle_);
  return answer;
}

}  // namespace annulus::test
