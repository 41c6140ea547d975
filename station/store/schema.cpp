#include "station/store/schema.h"

#include <array>

#include "base/ensure.h"

namespace annulus {
namespace {

/// "ANST": what PRAGMA application_id says of our databases.
constexpr std::int64_t kApplicationId = 0x414E5354;

// Times are UTC, ms since 1970. `sealed` columns: docs/store.md, "Keys and seals". Texts that tell of a person are in
// sealed columns only.
constexpr const char* kVersion1 = R"sql(
CREATE TABLE sequences(name TEXT PRIMARY KEY, last INTEGER NOT NULL) STRICT, WITHOUT ROWID;

CREATE TABLE customers(
  number INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE,
  sealed BLOB NOT NULL, created_ms INTEGER NOT NULL, keep_until_ms INTEGER NOT NULL) STRICT;
CREATE INDEX customers_by_end ON customers(keep_until_ms);

CREATE TABLE consents(
  number INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE,
  customer_id TEXT NOT NULL REFERENCES customers(id),
  purposes TEXT NOT NULL, text_version TEXT NOT NULL, language TEXT NOT NULL, taken_by TEXT NOT NULL,
  given_ms INTEGER NOT NULL, withdrawn_ms INTEGER) STRICT;
CREATE INDEX consents_by_customer ON consents(customer_id);

CREATE TABLE scans(
  number INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE,
  customer_id TEXT NOT NULL REFERENCES customers(id), consent_id TEXT NOT NULL REFERENCES consents(id),
  profile TEXT NOT NULL, verdict TEXT NOT NULL CHECK (verdict IN ('', 'good', 'usable', 'repeat')),
  recording TEXT, source_tag BLOB, taken_ms INTEGER NOT NULL, sealed BLOB NOT NULL,
  UNIQUE (customer_id, source_tag)) STRICT;
CREATE INDEX scans_by_consent ON scans(consent_id);
CREATE INDEX scans_by_recording ON scans(recording);

CREATE TABLE artefacts(
  number INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE,
  scan_id TEXT NOT NULL REFERENCES scans(id), customer_id TEXT NOT NULL REFERENCES customers(id),
  kind TEXT NOT NULL, name_tag BLOB NOT NULL, derived INTEGER NOT NULL CHECK (derived IN (0, 1)),
  made_ms INTEGER NOT NULL, bytes INTEGER NOT NULL, file TEXT NOT NULL, sealed BLOB NOT NULL,
  UNIQUE (scan_id, kind, name_tag)) STRICT;
CREATE INDEX artefacts_by_customer ON artefacts(customer_id);
CREATE INDEX artefacts_by_file ON artefacts(file);

CREATE TABLE removals(file TEXT PRIMARY KEY) STRICT, WITHOUT ROWID;

CREATE TABLE erasures(
  customer_id TEXT PRIMARY KEY, begun_ms INTEGER NOT NULL, finished_ms INTEGER,
  files INTEGER NOT NULL DEFAULT 0, rows INTEGER NOT NULL DEFAULT 0, key_destroyed INTEGER NOT NULL DEFAULT 0,
  bytes_searched INTEGER NOT NULL DEFAULT 0, marker_hits INTEGER NOT NULL DEFAULT 0) STRICT;

CREATE TABLE backups(
  path TEXT PRIMARY KEY, keys_path TEXT NOT NULL, made_ms INTEGER NOT NULL) STRICT;

CREATE TABLE calibrations(
  number INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE,
  name TEXT NOT NULL, made_ms INTEGER NOT NULL, json TEXT NOT NULL) STRICT;

CREATE TABLE users(
  name TEXT PRIMARY KEY, role TEXT NOT NULL CHECK (role IN ('none', 'operator', 'technician', 'admin')),
  enabled INTEGER NOT NULL CHECK (enabled IN (0, 1)), created_ms INTEGER NOT NULL, last_login_ms INTEGER) STRICT;
CREATE TABLE secrets(
  user TEXT NOT NULL REFERENCES users(name) ON DELETE CASCADE,
  what TEXT NOT NULL CHECK (what IN ('password', 'pin', 'totp')), sealed BLOB NOT NULL,
  PRIMARY KEY (user, what)) STRICT;

CREATE TABLE settings(name TEXT PRIMARY KEY, json TEXT NOT NULL) STRICT;
-- What opens only with the station's key: tells at once if another key is given.
CREATE TABLE station_check(one INTEGER PRIMARY KEY CHECK (one = 1), sealed BLOB NOT NULL) STRICT;

CREATE TABLE audit(
  number INTEGER PRIMARY KEY, time_ms INTEGER NOT NULL, monotonic_ns INTEGER NOT NULL,
  user TEXT NOT NULL, origin TEXT NOT NULL, action TEXT NOT NULL, subject TEXT NOT NULL, result TEXT NOT NULL,
  hash TEXT NOT NULL) STRICT;
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
  BEGIN SELECT RAISE(ABORT, 'lines of the audit are not changed'); END;
CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
  BEGIN SELECT RAISE(ABORT, 'lines of the audit are not deleted'); END;
CREATE TRIGGER audit_has_no_gaps BEFORE INSERT ON audit
  WHEN NEW.number <> (SELECT coalesce(max(number), 0) + 1 FROM audit)
  BEGIN SELECT RAISE(ABORT, 'lines of the audit are numbered without gaps'); END;
-- The last line's number and hash, sealed with the station's key: lines cut off at the end are missed.
CREATE TABLE audit_head(one INTEGER PRIMARY KEY CHECK (one = 1), sealed BLOB NOT NULL) STRICT;
)sql";

constexpr std::array<Migration, 1> kMigrations{{{1, kVersion1}}};

Status RunStep(Database& database, const Migration& migration) {
  Transaction transaction(database);
  RETURN_IF_ERROR(transaction.Begin());
  // Another process may have done it while this one waited for the lock.
  const auto version = SchemaVersion(database);
  if (!version) return Fail(version);
  if (*version >= migration.version) return {};
  RETURN_IF_ERROR(database.Script(migration.sql));
  RETURN_IF_ERROR(database.Script("PRAGMA application_id=" + std::to_string(kApplicationId) +
                                  "; PRAGMA user_version=" + std::to_string(migration.version) + ";"));
  return transaction.Commit();
}

Status KeepCopy(Database& database, int version, Storage& storage) {
  const std::string copy = database.path() + ".schema-" + std::to_string(version);
  if (storage.Exists(copy)) return {};  // of an attempt that failed: as good
  const std::string part = copy + ".part";
  if (storage.Exists(part)) RETURN_IF_ERROR(storage.Remove(part));
  RETURN_IF_ERROR(database.CopyTo(part));
  return storage.Rename(part, copy);
}

}  // namespace

std::span<const Migration> StoreMigrations() { return kMigrations; }

Result<int> SchemaVersion(Database& database) {
  const auto version = database.Number("PRAGMA user_version");
  if (!version) return Fail(version);
  const auto application = database.Number("PRAGMA application_id");
  if (!application) return Fail(application);
  const auto tables = database.Number("SELECT count(*) FROM sqlite_schema");
  if (!tables) return Fail(tables);
  if (application->value_or(0) == kApplicationId) return static_cast<int>(version->value_or(0));
  if (tables->value_or(0) == 0) return 0;
  return Fail("open the store " + database.path(), "this database is not a store's", "give the folder of a store");
}

Status BringUpToDate(Database& database, std::span<const Migration> migrations, Storage& storage) {
  const auto version = SchemaVersion(database);
  if (!version) return Fail(version);
  ENSURE(!migrations.empty(), "there is a schema");
  const int newest = migrations.back().version;
  if (*version > newest) {
    return Fail(
        "open the store " + database.path(),
        "its schema is version " + std::to_string(*version) + ", this program knows up to " + std::to_string(newest),
        "take the newer version of the program that made it");
  }
  if (*version > 0 && *version < newest) RETURN_IF_ERROR(KeepCopy(database, *version, storage));
  for (const Migration& migration : migrations) {
    if (migration.version > *version) RETURN_IF_ERROR(RunStep(database, migration));
  }
  return {};
}

}  // namespace annulus
