#include "station/store/database.h"

#include <sqlite3.h>

#include <algorithm>
#include <utility>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

struct Finalizer {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using StatementHandle = std::unique_ptr<sqlite3_stmt, Finalizer>;

/// What a reader of the message can do about an SQLite result code.
std::string AdviceFor(int primary) {
  switch (primary) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "wait until the other program (a backup, another annulus) is done, then try again";
    case SQLITE_FULL:
      return "free space on this disk; nothing was changed";
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return "restore the last backup: annulus store restore";
    case SQLITE_IOERR:
      return "check the disk; nothing was changed";
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return "check the permissions of the store's folder";
    default:
      return "nothing was changed; please report this if it happens again";
  }
}

std::string WordsFor(int primary, const std::string& message) {
  if (primary == SQLITE_BUSY || primary == SQLITE_LOCKED) {
    return "another program has held its lock for " + std::to_string(Database::kLockWait.count() / 1000) + " s";
  }
  if (primary == SQLITE_FULL) return "the disk is full";
  if (primary == SQLITE_CORRUPT || primary == SQLITE_NOTADB) return "it is damaged (" + message + ")";
  return message;
}

int BindOne(sqlite3_stmt* statement, int index, const SqlValue& value) {
  if (const auto* number = std::get_if<std::int64_t>(&value)) return sqlite3_bind_int64(statement, index, *number);
  if (const auto* text = std::get_if<std::string_view>(&value)) {
    // A null pointer would bind null, which an empty text is not.
    return sqlite3_bind_text64(statement, index, text->data() == nullptr ? "" : text->data(), text->size(),
                               SQLITE_STATIC, SQLITE_UTF8);
  }
  if (const auto* bytes = std::get_if<std::span<const std::byte>>(&value)) {
    if (bytes->empty()) return sqlite3_bind_zeroblob(statement, index, 0);
    return sqlite3_bind_blob64(statement, index, bytes->data(), bytes->size(), SQLITE_STATIC);
  }
  return sqlite3_bind_null(statement, index);
}

}  // namespace

SqlValue OrNull(std::string_view text) { return text.empty() ? SqlValue() : SqlValue(text); }
SqlValue OrNull(const std::optional<std::int64_t>& number) { return number ? SqlValue(*number) : SqlValue(); }

bool SqlRow::IsNull(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
std::int64_t SqlRow::Number(int column) const { return sqlite3_column_int64(statement_, column); }

std::string SqlRow::Text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  if (text == nullptr) return {};
  return {text, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

std::vector<std::byte> SqlRow::Bytes(int column) const {
  const auto* bytes = static_cast<const std::byte*>(sqlite3_column_blob(statement_, column));
  if (bytes == nullptr) return {};
  return {bytes, bytes + sqlite3_column_bytes(statement_, column)};
}

void Database::Closer::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }

Database::Database(std::unique_ptr<sqlite3, Closer> handle, std::string path)
    : handle_(std::move(handle)), path_(std::move(path)) {}
Database::~Database() = default;

tl::unexpected<Error> Database::FailSql(int code) {
  const int primary = code & 0xFF;
  if (primary == SQLITE_CORRUPT || primary == SQLITE_NOTADB) damaged_ = true;
  return Fail("use the database " + path_, WordsFor(primary, sqlite3_errmsg(handle_.get())), AdviceFor(primary));
}

Result<std::unique_ptr<Database>> Database::Open(const std::string& path, Access access) {
  sqlite3* raw = nullptr;
  const int flags = access == Access::kReadOnly ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  const int code = sqlite3_open_v2(path.c_str(), &raw, flags | SQLITE_OPEN_FULLMUTEX | SQLITE_OPEN_EXRESCODE, nullptr);
  std::unique_ptr<sqlite3, Closer> handle(raw);
  if (!handle) return Fail("open the database " + path, "out of memory", "close other programs");
  std::unique_ptr<Database> database(new Database(std::move(handle), path));
  if (code != SQLITE_OK) return database->FailSql(code);
  if (const Status status = database->Configure(access); !status && !database->damaged()) return Fail(status);
  return database;
}

Status Database::Configure(Access access) {
  sqlite3* handle = handle_.get();
  sqlite3_busy_timeout(handle, static_cast<int>(kLockWait.count()));
  for (const auto& [option, value] :
       {std::pair(SQLITE_DBCONFIG_DEFENSIVE, 1), std::pair(SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0),
        std::pair(SQLITE_DBCONFIG_ENABLE_FKEY, 1), std::pair(SQLITE_DBCONFIG_DQS_DML, 0),
        std::pair(SQLITE_DBCONFIG_DQS_DDL, 0)}) {
    const int code = sqlite3_db_config(handle, option, value, nullptr);
    if (code != SQLITE_OK) return FailSql(code);
  }
  RETURN_IF_ERROR(Script("PRAGMA cell_size_check=ON; PRAGMA temp_store=MEMORY; PRAGMA secure_delete=ON;"));
  if (access == Access::kReadOnly) return Script("PRAGMA query_only=ON;");
  RETURN_IF_ERROR(Script("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;"));
  return {};
}

Status Database::Script(const std::string& sql) {
  const int code = sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return FailSql(code);
  return {};
}

Status Database::Run(std::string_view sql, std::initializer_list<SqlValue> values) {
  return ForEach(sql, values, [](const SqlRow&) { return Status(); });
}

Status Database::ForEach(std::string_view sql, std::initializer_list<SqlValue> values,
                         const std::function<Status(const SqlRow&)>& visit) {
  sqlite3_stmt* raw = nullptr;
  int code = sqlite3_prepare_v2(handle_.get(), sql.data(), static_cast<int>(sql.size()), &raw, nullptr);
  const StatementHandle statement(raw);
  if (code != SQLITE_OK) return FailSql(code);
  ENSURE(std::cmp_equal(sqlite3_bind_parameter_count(raw), values.size()), "every parameter has its value");
  int index = 0;
  for (const SqlValue& value : values) {
    if ((code = BindOne(raw, ++index, value)) != SQLITE_OK) return FailSql(code);
  }
  while ((code = sqlite3_step(raw)) == SQLITE_ROW) RETURN_IF_ERROR(visit(SqlRow(raw)));
  if (code != SQLITE_DONE) return FailSql(code);
  return {};
}

Result<std::optional<std::int64_t>> Database::Number(std::string_view sql, std::initializer_list<SqlValue> values) {
  std::optional<std::int64_t> number;
  const Status status = ForEach(sql, values, [&](const SqlRow& row) {
    if (!number && !row.IsNull(0)) number = row.Number(0);
    return Status();
  });
  if (!status) return Fail(status);
  return number;
}

std::uint64_t Database::changes() const { return static_cast<std::uint64_t>(sqlite3_changes64(handle_.get())); }

Result<std::int64_t> Database::DataVersion() {
  const auto version = Number("PRAGMA data_version");
  if (!version) return Fail(version);
  return version->value_or(0);
}

Status Database::QuickCheck() {
  std::string first;
  RETURN_IF_ERROR(ForEach("PRAGMA quick_check(1)", {}, [&](const SqlRow& row) {
    if (first.empty()) first = row.Text(0);
    return Status();
  }));
  if (first == "ok") return {};
  damaged_ = true;
  return Fail("check the database " + path_, "it is damaged (" + first + ")", AdviceFor(SQLITE_CORRUPT));
}

Status Database::RefuseWrites() { return Script("PRAGMA query_only=ON;"); }

Status Database::TruncateWal() {
  const int code = sqlite3_wal_checkpoint_v2(handle_.get(), nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr);
  if (code != SQLITE_OK) return FailSql(code);
  return {};
}

Status Database::Vacuum() { return Script("VACUUM;"); }

Status Database::CopyTo(const std::string& path) {
  auto copy = Open(path, Access::kReadWrite);
  if (!copy) return Fail(copy);
  sqlite3_backup* backup = sqlite3_backup_init((*copy)->handle_.get(), "main", handle_.get(), "main");
  if (backup == nullptr) return (*copy)->FailSql(sqlite3_errcode((*copy)->handle_.get()));
  const int stepped = sqlite3_backup_step(backup, -1);  // all at once: one moment, and readers do not block writers
  const int finished = sqlite3_backup_finish(backup);
  if (finished != SQLITE_OK) return (*copy)->FailSql(finished);
  if (stepped != SQLITE_DONE) return FailSql(stepped);
  return (*copy)->Script("PRAGMA journal_mode=DELETE;");
}

Status Database::VisitFile(void* file, std::size_t overlap,
                           const std::function<void(std::span<const std::byte>)>& visit) {
  auto* opened = static_cast<sqlite3_file*>(file);
  if (opened == nullptr || opened->pMethods == nullptr) return {};  // no WAL yet
  sqlite3_int64 size = 0;
  int code = opened->pMethods->xFileSize(opened, &size);
  if (code != SQLITE_OK) return FailSql(code);
  std::vector<std::byte> block;
  for (sqlite3_int64 at = 0; at < size;) {
    const auto bytes = std::min<sqlite3_int64>(size - at, kBlockBytes);
    block.resize(static_cast<std::size_t>(bytes));
    code = opened->pMethods->xRead(opened, block.data(), static_cast<int>(bytes), at);
    if (code != SQLITE_OK && code != SQLITE_IOERR_SHORT_READ) return FailSql(code);
    visit(block);
    if (at + bytes >= size) break;
    at += bytes - static_cast<sqlite3_int64>(overlap);
  }
  return {};
}

Status Database::VisitBytes(std::size_t overlap, const std::function<void(std::span<const std::byte>)>& visit) {
  ENSURE(overlap < kBlockBytes / 2, "blocks move on");
  for (const int which : {SQLITE_FCNTL_FILE_POINTER, SQLITE_FCNTL_JOURNAL_POINTER}) {
    sqlite3_file* file = nullptr;
    const int code = sqlite3_file_control(handle_.get(), "main", which, static_cast<void*>(&file));
    if (code != SQLITE_OK) return FailSql(code);
    RETURN_IF_ERROR(VisitFile(file, overlap, visit));
  }
  return {};
}

Transaction::~Transaction() {
  if (open_) static_cast<void>(database_.Script("ROLLBACK;"));  // SQLite may have done so already
}

Status Transaction::Begin() {
  RETURN_IF_ERROR(database_.Script("BEGIN IMMEDIATE;"));
  open_ = true;
  return {};
}

Status Transaction::Commit() {
  RETURN_IF_ERROR(database_.Script("COMMIT;"));
  open_ = false;
  return {};
}

}  // namespace annulus
