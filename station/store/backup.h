#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/storage.h"
#include "station/store/database.h"
#include "station/store/store_parts.h"

namespace annulus {

/// A backup is a folder with what is sealed, and beside it a file with the keys:
///
///     annulus-backup-2026-11-29-223015/annulus.db       as it was at one moment
///                                     /files/ab/…       all files that it names
///                                     /audit-anchors.txt
///     annulus-backup-2026-11-29-223015-keys             the wrapped keys; short-lived
///
/// Both appear under their names once they are whole and on the disk; until then the folder's ends in ".part". One that
/// fails is removed with its keys; one that a crash cut short, by the next backup to the same place.
class Backup {
 public:
  /// `folder`: where it goes; the store's own if empty.
  Backup(StoreParts& parts, const std::string& folder);
  ~Backup();
  Backup(const Backup&) = delete;
  Backup& operator=(const Backup&) = delete;

  /// Within a transaction: notes the backup, so that erasures reach its keys.
  Status Begin();
  /// Under the store's lock: writes the keys.
  Status WriteKeys();
  /// Needs no lock (a connection of its own): copies database and files. Returns the backup's path.
  Result<std::string> Copy();

 private:
  [[nodiscard]] std::string Part() const;
  Status RemoveAbandoned();
  Result<std::string> KeyLines();

  StoreParts& parts_;
  std::string folder_;
  std::string path_;
  std::unique_ptr<AppendFile> mark_;  ///< Until the backup is whole.
};

/// Copies the files that a database names, each held against its hash; those that are missing are left out.
Status CopyContentFiles(Database& database, ContentFiles& from, const std::string& to, Storage& storage);

/// The file of a backup's keys.
[[nodiscard]] std::string KeysOfBackup(const std::string& backup);

/// Takes a customer's key out of a backup's keys and overwrites the old file; success if there is none.
Status RemoveKeyOfBackup(Storage& storage, const std::string& keys_path, const std::string& customer_id);

/// All files that rows of a database name.
Result<std::vector<std::string>> FilesNamedIn(Database& database);

/// Destroys the keys of backups that are older than StoreOptions::keep_key_backups.
Status DestroyOldBackupKeys(StoreParts& parts);

}  // namespace annulus
