#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace annulus {

/// What is bound to a parameter of a statement: null, a number, text (UTF-8), or bytes. Borrows text and bytes.
using SqlValue = std::variant<std::monostate, std::int64_t, std::string_view, std::span<const std::byte>>;
/// An empty text as null.
[[nodiscard]] SqlValue OrNull(std::string_view text);
[[nodiscard]] SqlValue OrNull(const std::optional<std::int64_t>& number);

/// A row that a statement returns; columns from 0. Valid while it is visited. Null reads as 0 or as nothing.
class SqlRow {
 public:
  explicit SqlRow(sqlite3_stmt* statement) : statement_(statement) {}
  [[nodiscard]] bool IsNull(int column) const;
  [[nodiscard]] std::int64_t Number(int column) const;
  [[nodiscard]] std::string Text(int column) const;
  [[nodiscard]] std::vector<std::byte> Bytes(int column) const;

 private:
  sqlite3_stmt* statement_;
};

/// One connection to an SQLite database: WAL, synchronous FULL, foreign keys, secure_delete; no trust in the schema of
/// the file. Waits at most `kLockWait` for another writer, then fails in words (fault row D8). Thread-bound.
///
/// No other code of this process may open and close the file: POSIX would drop this connection's locks. Its bytes are
/// read with VisitBytes.
class Database {
 public:
  enum class Access { kReadWrite, kReadOnly };
  static constexpr std::chrono::milliseconds kLockWait{2000};

  /// Opens, or makes it (kReadWrite). A damaged file is opened as far as SQLite goes; QuickCheck tells.
  static Result<std::unique_ptr<Database>> Open(const std::string& path, Access access);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Runs statements that return nothing of interest.
  Status Script(const std::string& sql);
  /// Runs one statement with its parameters ?1, ?2 …
  Status Run(std::string_view sql, std::initializer_list<SqlValue> values = {});
  /// Runs one statement and hands over its rows; an Error of `visit` ends it.
  Status ForEach(std::string_view sql, std::initializer_list<SqlValue> values,
                 const std::function<Status(const SqlRow&)>& visit);
  /// The first column of the first row, as a number; nothing if there is no row or it is null.
  Result<std::optional<std::int64_t>> Number(std::string_view sql, std::initializer_list<SqlValue> values = {});

  /// Rows that the last Run changed.
  [[nodiscard]] std::uint64_t changes() const;
  /// Differs from before if another connection has changed the database.
  Result<std::int64_t> DataVersion();
  /// True once a call has met damage (fault row D9).
  [[nodiscard]] bool damaged() const { return damaged_; }

  /// Fails with the first damage that SQLite finds.
  Status QuickCheck();
  /// No statement changes anything from now on.
  Status RefuseWrites();
  /// Moves everything from the WAL into the database and empties it. Fails if a reader keeps it from that.
  Status TruncateWal();
  /// Writes the database anew, without what deleted rows may have left in unused space.
  Status Vacuum();
  /// Copies the database as it is at one moment into a new file `path` (rollback journal, synced).
  Status CopyTo(const std::string& path);
  /// Hands over the bytes of the database file and of its WAL, in blocks of at most 1 MiB that overlap by `overlap`.
  Status VisitBytes(std::size_t overlap, const std::function<void(std::span<const std::byte>)>& visit);

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  struct Closer {
    void operator()(sqlite3* handle) const;
  };
  Database(std::unique_ptr<sqlite3, Closer> handle, std::string path);
  Status Configure(Access access);
  [[nodiscard]] tl::unexpected<Error> FailSql(int code);
  [[nodiscard]] Status VisitFile(void* file, std::size_t overlap,
                                 const std::function<void(std::span<const std::byte>)>& visit);

  std::unique_ptr<sqlite3, Closer> handle_;
  std::string path_;
  bool damaged_ = false;
};

/// A transaction that takes the writer's lock at once; undone unless it is committed.
class Transaction {
 public:
  explicit Transaction(Database& database) : database_(database) {}
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  Status Begin();
  /// Everything is on the disk when it returns.
  Status Commit();

 private:
  Database& database_;
  bool open_ = false;
};

}  // namespace annulus
