#pragma once

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <set>

#include "acquisition/recording.h"
#include "station/store/store.h"

namespace annulus::test {

/// The store's promises to the routes, kept in memory: no seals, no disk. Can be told to be away.
class MemoryStore final : public Store {
 public:
  explicit MemoryStore(Storage& storage) : storage_(storage) {}

  bool read_only = false;
  bool away = false;  ///< Nothing is taken any more.

  [[nodiscard]] StoreState state() const override { return read_only ? StoreState::kReadOnly : StoreState::kReady; }
  [[nodiscard]] std::string problem() const override { return read_only ? "the database is damaged" : ""; }
  Result<int> Schema() override { return 1; }

  Result<Customer> AddCustomer(Customer customer) override {
    const std::lock_guard lock(mutex_);
    if (away) return Away();
    customer.id = NewId("K-");
    customers_[customer.id] = customer;
    return customer;
  }
  Result<Customer> GetCustomer(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    const auto found = customers_.find(id);
    if (found == customers_.end()) return None(id);
    return found->second;
  }
  Status ChangeCustomer(const Customer& customer) override {
    const std::lock_guard lock(mutex_);
    if (away) return Away();
    customers_[customer.id] = customer;
    return {};
  }
  Result<std::vector<Customer>> FindCustomers(std::string_view search, std::size_t limit) override {
    const std::lock_guard lock(mutex_);
    std::vector<Customer> found;
    for (auto one = customers_.rbegin(); one != customers_.rend() && found.size() < limit; ++one) {
      if (one->second.name.find(search) != std::string::npos) found.push_back(one->second);
    }
    return found;
  }
  Result<Consent> AddConsent(Consent consent) override {
    const std::lock_guard lock(mutex_);
    consent.id = NewId("C-");
    consents_[consent.id] = consent;
    return consent;
  }
  Result<std::vector<Consent>> Consents(const std::string& customer_id) override {
    const std::lock_guard lock(mutex_);
    std::vector<Consent> list;
    for (const auto& [id, consent] : consents_) {
      if (consent.customer_id == customer_id) list.push_back(consent);
    }
    return list;
  }
  Status WithdrawConsent(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    if (!consents_.contains(id)) return None(id);
    consents_[id].withdrawn = StoreTime(1);
    return {};
  }

  Result<ScanRow> AddScan(ScanRow scan, const std::string& file, const KeySource* keys) override {
    const std::lock_guard lock(mutex_);
    if (away) return Away();
    const auto consent = consents_.find(scan.consent_id);
    if (consent == consents_.end() || consent->second.customer_id != scan.customer_id || consent->second.withdrawn) {
      return Fail("add a scan", "the consent is not in force", "ask for it");
    }
    const auto bytes = storage_.ReadAll(file, kMaxInputBytes);
    if (!bytes) return Fail(bytes);
    scan.id = NewId("S-");
    scan.recording = "in memory";
    recordings_[scan.id] = *bytes;
    if (LooksSealed(*bytes)) recordings_[scan.id] = UnsealRecording(*bytes, file, keys)->bytes;
    scans_[scan.id] = scan;
    if (!die_before_removal) static_cast<void>(storage_.Remove(file));
    return scan;
  }
  bool die_before_removal = false;
  Status JudgeScan(const std::string& id, const std::string& verdict, const std::string& summary) override {
    const std::lock_guard lock(mutex_);
    if (!scans_.contains(id)) return None(id);
    scans_[id].verdict = verdict;
    scans_[id].summary_json = summary;
    return {};
  }
  Result<ScanRow> GetScan(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    const auto found = scans_.find(id);
    if (found == scans_.end()) return None(id);
    return found->second;
  }
  Result<std::vector<ScanRow>> ScansOf(const std::string& customer_id) override {
    const std::lock_guard lock(mutex_);
    std::vector<ScanRow> list;
    for (const auto& [id, scan] : scans_) {
      if (scan.customer_id == customer_id) list.push_back(scan);
    }
    return list;
  }
  Result<std::vector<ScanRow>> LatestScans(std::size_t limit) override {
    const std::lock_guard lock(mutex_);
    std::vector<ScanRow> list;
    for (auto one = scans_.rbegin(); one != scans_.rend() && list.size() < limit; ++one) list.push_back(one->second);
    return list;
  }
  Result<std::vector<std::byte>> ReadRecording(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    const auto found = recordings_.find(id);
    if (found == recordings_.end()) return None(id);
    return found->second;
  }
  Result<Artefact> PutArtefact(Artefact artefact, std::span<const std::byte> bytes) override {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, one] : artefacts_) {
      const bool same = one.scan_id == artefact.scan_id && one.kind == artefact.kind && one.name == artefact.name;
      if (!same) continue;
      artefacts_.erase(id);
      break;
    }
    artefact.id = NewId("A-");
    artefact.bytes = bytes.size();
    artefacts_[artefact.id] = artefact;
    contents_[artefact.id].assign(bytes.begin(), bytes.end());
    return artefact;
  }
  Result<std::vector<std::byte>> ReadArtefact(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    if (!artefacts_.contains(id)) return None(id);
    return contents_[id];
  }
  Result<Artefact> GetArtefact(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    const auto found = artefacts_.find(id);
    if (found == artefacts_.end()) return None(id);
    return found->second;
  }
  Result<std::vector<Artefact>> ArtefactsOf(const std::string& scan_id) override {
    const std::lock_guard lock(mutex_);
    std::vector<Artefact> list;
    for (const auto& [id, artefact] : artefacts_) {
      if (artefact.scan_id == scan_id) list.push_back(artefact);
    }
    return list;
  }
  Status RemoveArtefact(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    artefacts_.erase(id);
    return {};
  }
  Status DropDerived(const std::string&) override { return {}; }

  Result<ErasureProof> Erase(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    customers_.erase(id);
    ErasureProof proof;
    proof.customer_id = id;
    proof.key_destroyed = true;
    return proof;
  }
  Result<std::vector<Customer>> Expired() override { return std::vector<Customer>{}; }
  Status KeepUntil(const std::string&, StoreTime) override { return {}; }
  Result<std::string> AddCalibration(const std::string&, std::string_view) override { return std::string("L-1"); }
  Result<std::vector<Artefact>> Calibrations() override { return std::vector<Artefact>{}; }
  Result<std::string> ReadCalibration(const std::string& id) override { return None(id); }
  Status AddUser(const User&, const std::string&) override { return {}; }
  Result<std::optional<User>> GetUser(const std::string&) override { return std::optional<User>(); }
  Result<std::vector<User>> Users() override { return std::vector<User>{}; }
  Status ChangeUser(const User&) override { return {}; }
  Status RemoveUser(const std::string&) override { return {}; }
  Status SetSecret(const std::string&, const std::string&, const std::string&) override { return {}; }
  Result<std::string> Secret(const std::string&, const std::string&) override { return std::string(); }
  Status NoteLogin(const std::string&) override { return {}; }
  Status Audit(AuditLine line) override {
    const std::lock_guard lock(mutex_);
    audit_.push_back(std::move(line));
    return {};
  }
  Result<std::vector<AuditLine>> AuditLines(std::uint64_t, std::size_t) override {
    const std::lock_guard lock(mutex_);
    return audit_;
  }
  Result<std::string> VerifyAudit() override { return std::string(); }
  Status SetSetting(const std::string& name, const std::string& json) override {
    const std::lock_guard lock(mutex_);
    if (away) return Away();
    settings_[name] = json;
    return {};
  }
  Result<std::optional<std::string>> Setting(const std::string& name) override {
    const std::lock_guard lock(mutex_);
    const auto found = settings_.find(name);
    return found == settings_.end() ? std::optional<std::string>() : std::optional(found->second);
  }
  Result<std::string> Backup(const std::string&) override { return std::string(); }

 private:
  [[nodiscard]] static tl::unexpected<Error> None(const std::string& id) {
    return Fail("find " + id, "there is none", "look at the list");
  }
  [[nodiscard]] static tl::unexpected<Error> Away() { return Fail("write", "the store is away", "wait"); }
  std::string NewId(const std::string& prefix) {
    const std::string number = std::to_string(++last_);
    return prefix + std::string(6 - number.size(), '0') + number;
  }

  Storage& storage_;
  std::mutex mutex_;
  int last_ = 0;
  std::map<std::string, Customer> customers_;
  std::map<std::string, Consent> consents_;
  std::map<std::string, ScanRow> scans_;
  std::map<std::string, std::vector<std::byte>> recordings_;
  std::map<std::string, Artefact> artefacts_;
  std::map<std::string, std::vector<std::byte>> contents_;
  std::map<std::string, std::string> settings_;
  std::vector<AuditLine> audit_;
};

}  // namespace annulus::test
