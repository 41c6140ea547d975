#pragma once

#include <span>
#include <string>

#include "base/result.h"
#include "base/storage.h"
#include "station/store/database.h"

namespace annulus {

/// One step of the schema: what brings a database from the version before to `version`.
struct Migration {
  int version;
  const char* sql;
};

/// All steps, from version 1, in order. Steps that were once released are never changed.
[[nodiscard]] std::span<const Migration> StoreMigrations();

/// The version of a database's schema; 0 if it is empty. Fails if it is no store's database.
Result<int> SchemaVersion(Database& database);

/// Runs the steps that a database lacks, each in a transaction of its own; before the first, a copy is made at
/// PATH.schema-VERSION. A newer schema is an Error.
Status BringUpToDate(Database& database, std::span<const Migration> migrations, Storage& storage);

}  // namespace annulus
