#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/sealed_file.h"
#include "base/clock.h"
#include "base/result.h"
#include "base/storage.h"
#include "station/store/store_types.h"

namespace annulus {

/// What a store that could not be opened as it should is good for (fault row D9).
enum class StoreState { kReady, kReadOnly };

/// Setting of the station (Store::SetSetting): days for which customers are kept, instead of StoreOptions::keep.
inline constexpr const char* kRetentionSetting = "retention_days";

struct StoreOptions {
  std::string folder;            ///< Made (0700) if it is not there.
  std::string station_key_file;  ///< As --key-file; made (0600) if `make_key`. Wraps the customers' keys.
  bool make_key = false;
  std::chrono::hours keep{24 * 90};  ///< Retention of new customers.
  std::chrono::hours keep_key_backups{24 * 30};
};

/// The station's memory: SQLite (WAL, synchronous FULL) and one file per recording and artefact, named by the hash of
/// what is in it. All that tells of a person is sealed with a key of that person's own, which is wrapped by the
/// station's; erasing the person destroys the key, then everything else. What a call returned is on the disk.
/// Waits at most 2 s for another writer (D8), then fails in words. Thread-safe.
class Store {
 public:
  /// Opens, and brings an older schema up to date (a copy is kept beside). A damaged database is opened read-only, with
  /// state() saying so; a newer schema, or a key that is not this store's, is an Error.
  static Result<std::unique_ptr<Store>> Open(const StoreOptions& options, Storage& storage, const Clock& clock);
  virtual ~Store() = default;

  [[nodiscard]] virtual StoreState state() const = 0;
  /// Why it is read-only; empty if it is not.
  [[nodiscard]] virtual std::string problem() const = 0;
  /// Version of the database's schema (docs/store.md).
  virtual Result<int> Schema() = 0;

  // Customers and consents.
  /// `id` and `created` are given by the store, and `keep_until` if it is 0: kRetentionSetting, or StoreOptions::keep,
  /// from now.
  virtual Result<Customer> AddCustomer(Customer customer) = 0;
  virtual Result<Customer> GetCustomer(const std::string& id) = 0;
  virtual Status ChangeCustomer(const Customer& customer) = 0;
  /// Newest first; `search` matches id or any part of name or contact, letter case and width (NFKC) set aside.
  virtual Result<std::vector<Customer>> FindCustomers(std::string_view search, std::size_t limit) = 0;
  /// Who agrees, and who is scanned, is kept from then on as long as a new customer; never shorter than before.
  virtual Result<Consent> AddConsent(Consent consent) = 0;
  virtual Result<std::vector<Consent>> Consents(const std::string& customer_id) = 0;
  virtual Status WithdrawConsent(const std::string& consent_id) = 0;

  // Scans and what comes of them.
  /// Takes a recording into the store: opened with `keys` (null: it is not sealed), sealed again with the customer's
  /// key, synced, the row written; `file` is removed last. Fails unless the consent is the customer's and in force.
  virtual Result<ScanRow> AddScan(ScanRow scan, const std::string& file, const KeySource* keys) = 0;
  virtual Status JudgeScan(const std::string& scan_id, const std::string& verdict, const std::string& summary_json) = 0;
  virtual Result<ScanRow> GetScan(const std::string& id) = 0;
  virtual Result<std::vector<ScanRow>> ScansOf(const std::string& customer_id) = 0;
  virtual Result<std::vector<ScanRow>> LatestScans(std::size_t limit) = 0;
  /// The recording's bytes, opened.
  virtual Result<std::vector<std::byte>> ReadRecording(const std::string& scan_id) = 0;
  virtual Result<Artefact> PutArtefact(Artefact artefact,
                                       std::span<const std::byte> bytes) = 0;  ///< Replaces kind + name.
  virtual Result<std::vector<std::byte>> ReadArtefact(const std::string& id) = 0;
  virtual Result<Artefact> GetArtefact(const std::string& id) = 0;
  virtual Result<std::vector<Artefact>> ArtefactsOf(const std::string& scan_id) = 0;
  virtual Status RemoveArtefact(const std::string& id) = 0;
  /// Drops all derived artefacts of a scan (or of all, ""), so that they are made again.
  virtual Status DropDerived(const std::string& scan_id) = 0;

  // Erasure and retention.
  virtual Result<ErasureProof> Erase(const std::string& customer_id) = 0;
  virtual Result<std::vector<Customer>> Expired() = 0;
  virtual Status KeepUntil(const std::string& customer_id, StoreTime until) = 0;

  // Calibrations (CAL.json, not of a person).
  virtual Result<std::string> AddCalibration(const std::string& name, std::string_view json) = 0;
  virtual Result<std::vector<Artefact>> Calibrations() = 0;
  virtual Result<std::string> ReadCalibration(const std::string& id) = 0;

  // Users. Passwords and PINs come hashed (station/console/passwords.h).
  virtual Status AddUser(const User& user, const std::string& password_hash) = 0;
  virtual Result<std::optional<User>> GetUser(const std::string& name) = 0;
  virtual Result<std::vector<User>> Users() = 0;
  virtual Status ChangeUser(const User& user) = 0;
  virtual Status RemoveUser(const std::string& name) = 0;
  /// `what`: "password", "pin", "totp"; an empty secret removes it. Secrets are sealed with the station's key.
  virtual Status SetSecret(const std::string& user, const std::string& what, const std::string& secret) = 0;
  virtual Result<std::string> Secret(const std::string& user, const std::string& what) = 0;
  virtual Status NoteLogin(const std::string& user) = 0;

  // Audit.
  /// Appends; number, time, hash are given by the store. On the disk when it returns.
  virtual Status Audit(AuditLine line) = 0;
  /// In their order, at most `limit`; from 0: the last ones.
  virtual Result<std::vector<AuditLine>> AuditLines(std::uint64_t from_number, std::size_t limit) = 0;
  /// The last hash; fails with the number of the first line that does not fit.
  virtual Result<std::string> VerifyAudit() = 0;

  // Settings of the station, small JSON texts by name.
  virtual Status SetSetting(const std::string& name, const std::string& json) = 0;
  virtual Result<std::optional<std::string>> Setting(const std::string& name) = 0;

  // Backups.
  /// Writes `folder`/annulus-backup-DATE (data, sealed by the customers' keys) and …-keys (the wrapped keys, which are
  /// to be destroyed within StoreOptions::keep_key_backups; erasures reach those in the store's own backup folder).
  virtual Result<std::string> Backup(const std::string& folder) = 0;
};

/// Makes a store in an empty folder of a backup and its keys. Customers whose keys are not in it are left out, named by
/// their ids in what is returned.
Result<std::vector<std::string>> RestoreStore(const StoreOptions& options, const std::string& backup,
                                              const std::string& keys, Storage& storage, const Clock& clock);

}  // namespace annulus
