#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <vector>

#include "station/store/artefact_table.h"
#include "station/store/audit_log.h"
#include "station/store/consent_table.h"
#include "station/store/customer_table.h"
#include "station/store/scan_table.h"
#include "station/store/station_table.h"
#include "station/store/store.h"
#include "station/store/store_parts.h"
#include "station/store/user_table.h"

namespace annulus {

/// What an opened store is made of.
struct OpenedStore {
  std::unique_ptr<Database> database;
  std::unique_ptr<KeyVault> vault;
  std::string problem;  ///< Why it may only be read; empty if it may be written.
};

/// The store behind its interface: one lock, one connection, every change in one transaction. Thread-safe.
class SqliteStore final : public Store {
 public:
  SqliteStore(StoreOptions options, OpenedStore opened, Storage& storage, const Clock& clock);

  /// What an earlier process may have left undone: erasures, files without rows, old keys of backups. What fails is
  /// logged, and tried again next time.
  void TidyUp();

  [[nodiscard]] StoreState state() const override;
  [[nodiscard]] std::string problem() const override;
  Result<int> Schema() override;

  Result<Customer> AddCustomer(Customer customer) override;
  Result<Customer> GetCustomer(const std::string& id) override;
  Status ChangeCustomer(const Customer& customer) override;
  Result<std::vector<Customer>> FindCustomers(std::string_view search, std::size_t limit) override;
  Result<Consent> AddConsent(Consent consent) override;
  Result<std::vector<Consent>> Consents(const std::string& customer_id) override;
  Status WithdrawConsent(const std::string& consent_id) override;

  Result<ScanRow> AddScan(ScanRow scan, const std::string& file, const KeySource* keys) override;
  Status JudgeScan(const std::string& scan_id, const std::string& verdict, const std::string& summary_json) override;
  Result<ScanRow> GetScan(const std::string& id) override;
  Result<std::vector<ScanRow>> ScansOf(const std::string& customer_id) override;
  Result<std::vector<ScanRow>> LatestScans(std::size_t limit) override;
  Result<std::vector<std::byte>> ReadRecording(const std::string& scan_id) override;
  Result<Artefact> PutArtefact(Artefact artefact, std::span<const std::byte> bytes) override;
  Result<std::vector<std::byte>> ReadArtefact(const std::string& id) override;
  Result<Artefact> GetArtefact(const std::string& id) override;
  Result<std::vector<Artefact>> ArtefactsOf(const std::string& scan_id) override;
  Status RemoveArtefact(const std::string& id) override;
  Status DropDerived(const std::string& scan_id) override;

  Result<ErasureProof> Erase(const std::string& customer_id) override;
  Result<std::vector<Customer>> Expired() override;
  Status KeepUntil(const std::string& customer_id, StoreTime until) override;

  Result<std::string> AddCalibration(const std::string& name, std::string_view json) override;
  Result<std::vector<Artefact>> Calibrations() override;
  Result<std::string> ReadCalibration(const std::string& id) override;

  Status AddUser(const User& user, const std::string& password_hash) override;
  Result<std::optional<User>> GetUser(const std::string& name) override;
  Result<std::vector<User>> Users() override;
  Status ChangeUser(const User& user) override;
  Status RemoveUser(const std::string& name) override;
  Status SetSecret(const std::string& user, const std::string& what, const std::string& secret) override;
  Result<std::string> Secret(const std::string& user, const std::string& what) override;
  Status NoteLogin(const std::string& user) override;

  Status Audit(AuditLine line) override;
  Result<std::vector<AuditLine>> AuditLines(std::uint64_t from_number, std::size_t limit) override;
  Result<std::string> VerifyAudit() override;

  Status SetSetting(const std::string& name, const std::string& json) override;
  Result<std::optional<std::string>> Setting(const std::string& name) override;

  Result<std::string> Backup(const std::string& folder) override;

 private:
  /// Does `work` under the lock.
  template <class Work>
  auto Reading(const Work& work) -> std::invoke_result_t<Work>;
  /// Does `work` under the lock, in a transaction that is committed if it succeeds.
  template <class Work>
  auto Writing(const Work& work) -> std::invoke_result_t<Work>;
  // The rest with the lock held.
  template <class Work>
  auto Changing(const Work& work) -> std::invoke_result_t<Work>;
  [[nodiscard]] Status CheckWritable() const;
  void NoticeOthers();
  void NoteDamage();
  void RemoveNoted();
  Status FinishErasures();
  Status RemoveOrphans();

  mutable std::mutex mutex_;
  std::unique_ptr<Database> database_;
  std::unique_ptr<KeyVault> vault_;
  std::string problem_;
  StoreParts parts_;
  CustomerTable customers_;
  ConsentTable consents_;
  ScanTable scans_;
  ArtefactTable artefacts_;
  UserTable users_;
  StationTable station_;
  AuditLog audit_;
  std::int64_t data_version_ = 0;
};

}  // namespace annulus
