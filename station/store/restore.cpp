// RestoreStore: a backup and its keys become a store.

#include <filesystem>
#include <memory>
#include <sstream>
#include <utility>

#include "station/key_file.h"
#include "station/store/backup.h"
#include "station/store/erasure.h"
#include "station/store/schema.h"
#include "station/store/station_check.h"
#include "station/store/store.h"

namespace annulus {
namespace {

namespace fs = std::filesystem;

Status CheckEmpty(const std::string& folder) {
  std::error_code error;
  if (!fs::exists(folder, error) || (fs::is_directory(folder, error) && fs::is_empty(folder, error))) return {};
  return Fail("restore a store into " + folder, "something is there already", "give a folder that is not there yet");
}

Status AdoptKeys(KeyVault& vault, Storage& storage, const std::string& keys) {
  const auto text = ReadTextFile(storage, keys);
  if (!text) return Fail(text);
  std::istringstream lines(*text);
  std::string line;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line.front() == '#') continue;
    const auto wrapped = WrappedKey::Parse(line);
    if (!wrapped) {
      return Fail("read the keys " + keys, "line " + std::to_string(number) + " is damaged", "take another copy");
    }
    RETURN_IF_ERROR(vault.Adopt(*wrapped));
  }
  return {};
}

/// Deletes the customers that have no key; returns their ids.
Result<std::vector<std::string>> LeaveOutKeyless(Database& database, const KeyVault& vault) {
  std::vector<std::string> keyless;
  const Status listed = database.ForEach("SELECT id FROM customers ORDER BY number", {}, [&](const SqlRow& row) {
    if (!vault.Has(row.Text(0))) keyless.push_back(row.Text(0));
    return Status();
  });
  if (!listed) return Fail(listed);
  Transaction transaction(database);
  RETURN_IF_ERROR(transaction.Begin());
  for (const std::string& id : keyless) {
    if (const auto deleted = DeleteCustomerRows(database, id); !deleted) return Fail(deleted);
  }
  RETURN_IF_ERROR(database.Run("DELETE FROM removals"));  // none of these files is copied
  RETURN_IF_ERROR(transaction.Commit());
  return keyless;
}

Result<std::vector<std::string>> FillFolder(const StoreOptions& options, const std::string& part,
                                            const std::string& backup, const std::string& keys, Storage& storage) {
  auto station = ReadKeyFile(options.station_key_file);
  if (!station) return Fail(station);
  KeyVault vault(KeysFolder(part), std::move(*station), storage);
  const auto database_bytes = storage.ReadAll(DatabasePath(backup), kMaxInputBytes);
  if (!database_bytes) return Fail(database_bytes);
  RETURN_IF_ERROR(WriteFileAtomically(storage, DatabasePath(part), *database_bytes));
  auto database = Database::Open(DatabasePath(part), Database::Access::kReadWrite);
  if (!database) return Fail(database);
  RETURN_IF_ERROR((*database)->QuickCheck());
  const auto version = SchemaVersion(**database);
  if (!version) return Fail(version);
  RETURN_IF_ERROR(BringUpToDate(**database, StoreMigrations(), storage));
  RETURN_IF_ERROR(CheckStationKey(**database, vault));
  RETURN_IF_ERROR(AdoptKeys(vault, storage, keys));
  auto keyless = LeaveOutKeyless(**database, vault);
  if (!keyless) return Fail(keyless);
  RETURN_IF_ERROR((*database)->TruncateWal());
  ContentFiles files(FilesFolder(backup), storage);
  RETURN_IF_ERROR(CopyContentFiles(**database, files, FilesFolder(part), storage));
  if (storage.Exists(AnchorsPath(backup))) {
    const auto anchors = ReadTextFile(storage, AnchorsPath(backup));
    if (!anchors) return Fail(anchors);
    RETURN_IF_ERROR(WriteFileAtomically(storage, AnchorsPath(part), *anchors));
  }
  return keyless;
}

}  // namespace

Result<std::vector<std::string>> RestoreStore(const StoreOptions& options, const std::string& backup,
                                              const std::string& keys, Storage& storage, const Clock& clock) {
  static_cast<void>(clock);
  RETURN_IF_ERROR(CheckEmpty(options.folder));
  const std::string part = options.folder + ".restoring";
  std::error_code error;
  fs::remove_all(part, error);  // of an attempt that was cut short
  RETURN_IF_ERROR(MakePrivateFolder(storage, part));
  RETURN_IF_ERROR(MakePrivateFolder(storage, KeysFolder(part)));
  RETURN_IF_ERROR(MakePrivateFolder(storage, FilesFolder(part)));
  auto left_out = FillFolder(options, part, backup, keys, storage);
  const Status placed = left_out ? storage.Rename(part, options.folder) : Status(Fail(left_out));
  if (!placed) {
    fs::remove_all(part, error);
    return Fail(placed);
  }
  return left_out;
}

}  // namespace annulus
