#include "station/store/sqlite_store.h"

#include <algorithm>
#include <utility>

#include "base/log.h"
#include "station/store/backup.h"
#include "station/store/erasure.h"
#include "station/store/schema.h"

namespace annulus {
namespace {

/// More files or keys without a row than a crash leaves: the database is probably an older copy, put there by hand.
constexpr std::size_t kMostOrphans = 16;

void LogFailure(const Status& status) {
  if (!status) Log(LogLevel::kWarning, status.error().Text());
}

}  // namespace

SqliteStore::SqliteStore(StoreOptions options, OpenedStore opened, Storage& storage, const Clock& clock)
    : database_(std::move(opened.database)),
      vault_(std::move(opened.vault)),
      problem_(std::move(opened.problem)),
      parts_{options, storage, clock, *database_, *vault_, ContentFiles(FilesFolder(options.folder), storage)},
      customers_(parts_),
      consents_(parts_),
      scans_(parts_),
      artefacts_(parts_),
      users_(parts_),
      station_(parts_),
      audit_(*database_, *vault_, AnchorsPath(options.folder), storage) {}

template <class Work>
auto SqliteStore::Reading(const Work& work) -> std::invoke_result_t<Work> {
  const std::lock_guard lock(mutex_);
  NoticeOthers();
  auto result = work();
  NoteDamage();
  return result;
}

template <class Work>
auto SqliteStore::Writing(const Work& work) -> std::invoke_result_t<Work> {
  const std::lock_guard lock(mutex_);
  return Changing(work);
}

template <class Work>
auto SqliteStore::Changing(const Work& work) -> std::invoke_result_t<Work> {
  RETURN_IF_ERROR(CheckWritable());
  std::invoke_result_t<Work> result = [&]() -> std::invoke_result_t<Work> {
    Transaction transaction(*database_);
    RETURN_IF_ERROR(transaction.Begin());
    NoticeOthers();
    auto done = work();
    if (!done) return done;
    RETURN_IF_ERROR(transaction.Commit());
    return done;
  }();
  if (!result) customers_.ForgetNames();  // they may hold what was undone
  NoteDamage();
  return result;
}

Status SqliteStore::CheckWritable() const {
  if (problem_.empty()) return {};
  return Fail("change the store", "it can only be read: " + problem_, "restore the last backup: annulus store restore");
}

void SqliteStore::NoticeOthers() {
  const auto version = database_->DataVersion();
  if (version && *version == data_version_) return;
  data_version_ = version.value_or(0);
  vault_->Forget();
  customers_.ForgetNames();
}

void SqliteStore::NoteDamage() {
  if (!database_->damaged() || !problem_.empty()) return;
  problem_ = "the database is damaged";
  LogFailure(database_->RefuseWrites());
}

void SqliteStore::RemoveNoted() {
  if (const auto removed = RemoveNotedFiles(parts_); !removed) LogFailure(Fail(removed));
}

void SqliteStore::TidyUp() {
  const std::lock_guard lock(mutex_);
  if (!problem_.empty()) return;
  LogFailure(FinishErasures());
  RemoveNoted();
  LogFailure(Changing([&] { return RemoveOrphans(); }));
  LogFailure(DestroyOldBackupKeys(parts_));
}

Status SqliteStore::FinishErasures() {
  const auto unfinished = UnfinishedErasures(*database_);
  if (!unfinished) return Fail(unfinished);
  for (const std::string& id : *unfinished) {
    Erasure erasure(parts_, id);
    RETURN_IF_ERROR(erasure.Run());
    if (const auto proof = erasure.Finish(ByteSearch({})); !proof) return Fail(proof);
  }
  return {};
}

Status SqliteStore::RemoveOrphans() {
  // Within the writer's lock: no other process is between its file or key and the row for it.
  RETURN_IF_ERROR(parts_.files.RemoveAbandoned());
  auto files = parts_.files.All();
  if (!files) return Fail(files);
  auto named = FilesNamedIn(*database_);
  if (!named) return Fail(named);
  std::sort(named->begin(), named->end());
  std::erase_if(*files,
                [&](const std::string& file) { return std::binary_search(named->begin(), named->end(), file); });
  RETURN_IF_ERROR(vault_->RemoveAbandoned());
  auto keys = vault_->Ids();
  if (!keys) return Fail(keys);
  std::vector<std::string> customers;
  RETURN_IF_ERROR(database_->ForEach("SELECT id FROM customers ORDER BY id", {}, [&](const SqlRow& row) {
    customers.push_back(row.Text(0));
    return Status();
  }));
  std::erase_if(*keys,
                [&](const std::string& id) { return std::binary_search(customers.begin(), customers.end(), id); });
  if (files->size() > kMostOrphans || keys->size() > kMostOrphans) {
    return Fail("tidy up the store",
                std::to_string(files->size()) + " files and " + std::to_string(keys->size()) + " keys have no row",
                "is the database an older copy? Nothing was removed; restore with 'annulus store restore'");
  }
  for (const std::string& file : *files) RETURN_IF_ERROR(parts_.files.Remove(file));
  for (const std::string& id : *keys) RETURN_IF_ERROR(vault_->Destroy(id));
  return {};
}

StoreState SqliteStore::state() const {
  const std::lock_guard lock(mutex_);
  return problem_.empty() ? StoreState::kReady : StoreState::kReadOnly;
}

std::string SqliteStore::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

Result<int> SqliteStore::Schema() {
  return Reading([&] { return SchemaVersion(*database_); });
}

Result<Customer> SqliteStore::AddCustomer(Customer customer) {
  return Writing([&] { return customers_.Add(std::move(customer)); });
}
Result<Customer> SqliteStore::GetCustomer(const std::string& id) {
  return Reading([&] { return customers_.Get(id); });
}
Status SqliteStore::ChangeCustomer(const Customer& customer) {
  return Writing([&] { return customers_.Change(customer); });
}
Result<std::vector<Customer>> SqliteStore::FindCustomers(std::string_view search, std::size_t limit) {
  return Reading([&] { return customers_.Find(search, limit); });
}
Result<Consent> SqliteStore::AddConsent(Consent consent) {
  return Writing([&]() -> Result<Consent> {
    auto added = consents_.Add(std::move(consent));
    if (added) RETURN_IF_ERROR(customers_.KeepFromNow(added->customer_id));
    return added;
  });
}
Result<std::vector<Consent>> SqliteStore::Consents(const std::string& customer_id) {
  return Reading([&] { return consents_.Of(customer_id); });
}
Status SqliteStore::WithdrawConsent(const std::string& consent_id) {
  return Writing([&] { return consents_.Withdraw(consent_id); });
}

Result<ScanRow> SqliteStore::AddScan(ScanRow scan, const std::string& file, const KeySource* keys) {
  const std::lock_guard lock(mutex_);
  auto added = Changing([&]() -> Result<ScanTable::Added> {
    RETURN_IF_ERROR(consents_.CheckInForce(scan.consent_id, scan.customer_id));
    auto taken = scans_.Add(std::move(scan), file, keys);
    if (taken && taken->file) RETURN_IF_ERROR(customers_.KeepFromNow(taken->row.customer_id));
    return taken;
  });
  if (!added) return Fail(added);
  if (added->file) added->file->Keep();
  if (!file.empty()) LogFailure(parts_.storage.Remove(file));
  return std::move(added->row);
}
Status SqliteStore::JudgeScan(const std::string& scan_id, const std::string& verdict, const std::string& summary_json) {
  return Writing([&] { return scans_.Judge(scan_id, verdict, summary_json); });
}
Result<ScanRow> SqliteStore::GetScan(const std::string& id) {
  return Reading([&] { return scans_.Get(id); });
}
Result<std::vector<ScanRow>> SqliteStore::ScansOf(const std::string& customer_id) {
  return Reading([&] { return scans_.Of(customer_id); });
}
Result<std::vector<ScanRow>> SqliteStore::LatestScans(std::size_t limit) {
  return Reading([&] { return scans_.Latest(limit); });
}
Result<std::vector<std::byte>> SqliteStore::ReadRecording(const std::string& scan_id) {
  return Reading([&] { return scans_.ReadRecording(scan_id); });
}

Result<Artefact> SqliteStore::PutArtefact(Artefact artefact, std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  auto put = Changing([&] { return artefacts_.Write(std::move(artefact), bytes); });
  if (!put) return Fail(put);
  put->file->Keep();
  RemoveNoted();
  return std::move(put->row);
}
Result<std::vector<std::byte>> SqliteStore::ReadArtefact(const std::string& id) {
  return Reading([&] { return artefacts_.Read(id); });
}
Result<Artefact> SqliteStore::GetArtefact(const std::string& id) {
  return Reading([&] { return artefacts_.Get(id); });
}
Result<std::vector<Artefact>> SqliteStore::ArtefactsOf(const std::string& scan_id) {
  return Reading([&] { return artefacts_.Of(scan_id); });
}
Status SqliteStore::RemoveArtefact(const std::string& id) {
  const std::lock_guard lock(mutex_);
  RETURN_IF_ERROR(Changing([&] { return artefacts_.Remove(id); }));
  RemoveNoted();
  return {};
}
Status SqliteStore::DropDerived(const std::string& scan_id) {
  const std::lock_guard lock(mutex_);
  RETURN_IF_ERROR(Changing([&] { return artefacts_.DropDerived(scan_id); }));
  RemoveNoted();
  return {};
}

Result<ErasureProof> SqliteStore::Erase(const std::string& customer_id) {
  Erasure erasure(parts_, customer_id);
  std::unique_ptr<ByteSearch> search;
  std::vector<std::string> backups;
  {
    const std::lock_guard lock(mutex_);
    RETURN_IF_ERROR(CheckWritable());
    NoticeOthers();
    const auto proof = ProofOf(*database_, customer_id);
    if (!proof) return Fail(proof);
    if (*proof) return **proof;  // asked for again
    const auto known = database_->Number(
        "SELECT 1 FROM customers WHERE id = ?1 UNION SELECT 1 FROM erasures WHERE customer_id = ?1", {customer_id});
    if (!known) return Fail(known);
    if (!*known) return NoSuchRow("customer", customer_id);
    auto markers = erasure.Markers();
    if (!markers) return Fail(markers);
    search = std::make_unique<ByteSearch>(std::move(*markers));
    customers_.ForgetNames(customer_id);
    const Status erased = erasure.Run();
    NoteDamage();
    RETURN_IF_ERROR(erased);
    RETURN_IF_ERROR(erasure.SearchDatabase(*search));
    auto paths = BackupPaths(*database_);
    if (!paths) return Fail(paths);
    backups = std::move(*paths);
  }
  RETURN_IF_ERROR(SearchFiles(*search, parts_.options.folder, backups));
  const std::lock_guard lock(mutex_);
  return erasure.Finish(*search);
}
Result<std::vector<Customer>> SqliteStore::Expired() {
  return Reading([&] { return customers_.Expired(); });
}
Status SqliteStore::KeepUntil(const std::string& customer_id, StoreTime until) {
  return Writing([&] { return customers_.KeepUntil(customer_id, until); });
}

Result<std::string> SqliteStore::AddCalibration(const std::string& name, std::string_view json) {
  return Writing([&] { return station_.AddCalibration(name, json); });
}
Result<std::vector<Artefact>> SqliteStore::Calibrations() {
  return Reading([&] { return station_.Calibrations(); });
}
Result<std::string> SqliteStore::ReadCalibration(const std::string& id) {
  return Reading([&] { return station_.ReadCalibration(id); });
}

Status SqliteStore::AddUser(const User& user, const std::string& password_hash) {
  return Writing([&] { return users_.Add(user, password_hash); });
}
Result<std::optional<User>> SqliteStore::GetUser(const std::string& name) {
  return Reading([&] { return users_.Get(name); });
}
Result<std::vector<User>> SqliteStore::Users() {
  return Reading([&] { return users_.All(); });
}
Status SqliteStore::ChangeUser(const User& user) {
  return Writing([&] { return users_.Change(user); });
}
Status SqliteStore::RemoveUser(const std::string& name) {
  return Writing([&] { return users_.Remove(name); });
}
Status SqliteStore::SetSecret(const std::string& user, const std::string& what, const std::string& secret) {
  return Writing([&] { return users_.SetSecret(user, what, secret); });
}
Result<std::string> SqliteStore::Secret(const std::string& user, const std::string& what) {
  return Reading([&] { return users_.Secret(user, what); });
}
Status SqliteStore::NoteLogin(const std::string& user) {
  return Writing([&] { return users_.NoteLogin(user); });
}

Status SqliteStore::Audit(AuditLine line) {
  const std::lock_guard lock(mutex_);
  RETURN_IF_ERROR(Changing([&] {
    line.time = parts_.Now();
    line.monotonic_ns = parts_.clock.Now().count();
    return audit_.Append(std::move(line));
  }));
  const auto new_day = audit_.KeepAnchor();
  if (!new_day) LogFailure(Fail(new_day));
  if (new_day && *new_day) LogFailure(DestroyOldBackupKeys(parts_));
  return {};
}
Result<std::vector<AuditLine>> SqliteStore::AuditLines(std::uint64_t from_number, std::size_t limit) {
  return Reading([&] { return audit_.Lines(from_number, limit); });
}
Result<std::string> SqliteStore::VerifyAudit() {
  return Reading([&] { return audit_.Verify(); });
}

Status SqliteStore::SetSetting(const std::string& name, const std::string& json) {
  return Writing([&] { return station_.SetSetting(name, json); });
}
Result<std::optional<std::string>> SqliteStore::Setting(const std::string& name) {
  return Reading([&] { return station_.Setting(name); });
}

Result<std::string> SqliteStore::Backup(const std::string& folder) {
  class Backup backup(parts_, folder);
  {
    const std::lock_guard lock(mutex_);
    RETURN_IF_ERROR(Changing([&] { return backup.Begin(); }));
    RETURN_IF_ERROR(backup.WriteKeys());
    LogFailure(DestroyOldBackupKeys(parts_));
  }
  return backup.Copy();
}

}  // namespace annulus
