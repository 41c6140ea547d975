#include "station/store/store.h"

#include <array>
#include <utility>

#include "station/key_file.h"
#include "station/store/schema.h"
#include "station/store/sqlite_store.h"
#include "station/store/station_check.h"

namespace annulus {
namespace {

constexpr std::array<std::pair<StationRole, std::string_view>, 4> kRoles{{{StationRole::kNone, "none"},
                                                                          {StationRole::kOperator, "operator"},
                                                                          {StationRole::kTechnician, "technician"},
                                                                          {StationRole::kAdmin, "admin"}}};

/// Checks the database and brings it up to date. What is wrong with a damaged one is returned: it may be read.
Result<std::string> PrepareDatabase(Database& database, Storage& storage) {
  const auto prepare = [&]() -> Status {
    RETURN_IF_ERROR(database.QuickCheck());
    return BringUpToDate(database, StoreMigrations(), storage);
  };
  const Status status = prepare();
  if (status) return std::string();
  if (!database.damaged()) return Fail(status);
  return status.error().seen;
}

/// The station's key; made if it may be, and if this store has none yet.
Result<std::unique_ptr<KeySource>> StationKeys(const StoreOptions& options, Database& database, Storage& storage) {
  if (options.make_key && !storage.Exists(options.station_key_file)) {
    const auto has = HasStationCheck(database);
    if (has && !*has) RETURN_IF_ERROR(MakeStationKeyFile(options.station_key_file));
  }
  if (options.station_key_file.empty()) {
    return Fail("open the store " + options.folder, "no key file was given", "give the station's with --key-file");
  }
  return ReadKeyFile(options.station_key_file);
}

Status CheckKey(Database& database, const KeyVault& vault) {
  Transaction transaction(database);
  const auto has = HasStationCheck(database);
  if (has && *has) return CheckStationKey(database, vault);
  RETURN_IF_ERROR(transaction.Begin());
  RETURN_IF_ERROR(CheckStationKey(database, vault));
  return transaction.Commit();
}

}  // namespace

std::string_view StationRoleName(StationRole role) {
  for (const auto& [known, name] : kRoles) {
    if (known == role) return name;
  }
  return "none";
}

std::optional<StationRole> ParseStationRole(std::string_view name) {
  for (const auto& [role, known] : kRoles) {
    if (known == name) return role;
  }
  return std::nullopt;
}

Result<std::unique_ptr<Store>> Store::Open(const StoreOptions& options, Storage& storage, const Clock& clock) {
  for (const std::string& folder : {options.folder, KeysFolder(options.folder), FilesFolder(options.folder)}) {
    RETURN_IF_ERROR(MakePrivateFolder(storage, folder));
  }
  OpenedStore opened;
  auto database = Database::Open(DatabasePath(options.folder), Database::Access::kReadWrite);
  if (!database) return Fail(database);
  opened.database = std::move(*database);
  auto problem = PrepareDatabase(*opened.database, storage);
  if (!problem) return Fail(problem);
  opened.problem = std::move(*problem);
  auto station = StationKeys(options, *opened.database, storage);
  if (!station) return Fail(station);
  opened.vault = std::make_unique<KeyVault>(KeysFolder(options.folder), std::move(*station), storage);
  const Status key =
      opened.problem.empty() ? CheckKey(*opened.database, *opened.vault) : opened.database->RefuseWrites();
  if (!key && opened.problem.empty()) {
    if (!opened.database->damaged()) return Fail(key);
    opened.problem = key.error().seen;
  }
  auto store = std::make_unique<SqliteStore>(options, std::move(opened), storage, clock);
  store->TidyUp();
  return store;
}

}  // namespace annulus
