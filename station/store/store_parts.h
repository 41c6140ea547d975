#pragma once

#include <string>

#include "base/clock.h"
#include "base/result.h"
#include "base/storage.h"
#include "station/store/content_files.h"
#include "station/store/database.h"
#include "station/store/key_vault.h"
#include "station/store/store.h"
#include "station/store/store_types.h"

namespace annulus {

/// What the tables of one store share; they work within a transaction that the store has begun. Borrowed: outlives
/// them.
struct StoreParts {
  StoreOptions options;
  Storage& storage;
  const Clock& clock;
  Database& database;
  KeyVault& vault;
  ContentFiles files;

  [[nodiscard]] StoreTime Now() const;
};

/// A row's number and its id, "K-000042".
struct RowId {
  std::int64_t number = 0;
  std::string id;
};

/// The next id of a series: 'K' customers, 'C' consents, 'S' scans, 'A' artefacts, 'L' calibrations. Never given twice.
Result<RowId> NextRowId(Database& database, char series);

/// Fails if `text` is not UTF-8. `what` names the field.
Status CheckText(const std::string& what, std::string_view text);

/// The error of an id that is not in the store.
[[nodiscard]] tl::unexpected<Error> NoSuchRow(const std::string& what, const std::string& id);

/// Makes a folder that only its owner may enter (0700); one that is there is made so.
Status MakePrivateFolder(Storage& storage, const std::string& path);

/// Where the parts of a store are, below its folder.
[[nodiscard]] std::string DatabasePath(const std::string& folder);
[[nodiscard]] std::string KeysFolder(const std::string& folder);
[[nodiscard]] std::string FilesFolder(const std::string& folder);
[[nodiscard]] std::string BackupsFolder(const std::string& folder);
[[nodiscard]] std::string AnchorsPath(const std::string& folder);

}  // namespace annulus
