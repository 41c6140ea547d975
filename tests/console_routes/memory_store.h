#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "station/store/store.h"

namespace annulus::test {

/// A store that keeps what the routes under test ask for, in memory; all else is refused. Thread-bound.
class MemoryStore final : public Store {
 public:
  /// Adds a scan with a recording ("" for none) and gives its id.
  std::string AddRecorded(const std::string& profile, std::vector<std::byte> recording) {
    ScanRow scan;
    scan.id = "S-" + std::to_string(scans_.size() + 1);
    scan.customer_id = "K-1";
    scan.consent_id = "C-1";
    scan.profile = profile;
    scan.taken = std::chrono::milliseconds(1000 + scans_.size());
    scan.recording = recording.empty() ? "" : "hash";
    scans_.push_back(scan);
    recordings_[scan.id] = std::move(recording);
    return scan.id;
  }

  [[nodiscard]] StoreState state() const override { return StoreState::kReady; }
  [[nodiscard]] std::string problem() const override { return ""; }
  Result<int> Schema() override { return 1; }
  Result<Customer> AddCustomer(Customer) override { return NotHere(); }
  Result<Customer> GetCustomer(const std::string&) override { return NotHere(); }
  Status ChangeCustomer(const Customer&) override { return NotHere(); }
  Result<std::vector<Customer>> FindCustomers(std::string_view, std::size_t) override { return NotHere(); }
  Result<Consent> AddConsent(Consent) override { return NotHere(); }
  /// What every customer has agreed to.
  std::vector<Consent> consents;
  Result<std::vector<Consent>> Consents(const std::string&) override { return consents; }
  Status WithdrawConsent(const std::string&) override { return NotHere(); }

  Result<ScanRow> AddScan(ScanRow, const std::string&, const KeySource*) override { return NotHere(); }
  Status JudgeScan(const std::string& id, const std::string& verdict, const std::string& summary) override {
    for (ScanRow& scan : scans_) {
      if (scan.id != id) continue;
      scan.verdict = verdict;
      scan.summary_json = summary;
      return {};
    }
    return NotHere();
  }
  Result<ScanRow> GetScan(const std::string& id) override {
    for (const ScanRow& scan : scans_) {
      if (scan.id == id) return scan;
    }
    return Fail("find scan " + id, "there is none", "look at the list");
  }
  Result<std::vector<ScanRow>> ScansOf(const std::string&) override { return scans_; }
  Result<std::vector<ScanRow>> LatestScans(std::size_t limit) override {
    std::vector<ScanRow> latest(scans_.rbegin(), scans_.rend());
    latest.resize(std::min(limit, latest.size()));
    return latest;
  }
  Result<std::vector<std::byte>> ReadRecording(const std::string& id) override {
    const auto found = recordings_.find(id);
    if (found != recordings_.end() && !found->second.empty()) return found->second;
    return Fail("read the recording of " + id, "it is not there", "look at the disk");
  }
  Result<Artefact> PutArtefact(Artefact artefact, std::span<const std::byte> bytes) override {
    std::erase_if(artefacts_, [&](const Kept& kept) {
      return kept.row.scan_id == artefact.scan_id && kept.row.kind == artefact.kind && kept.row.name == artefact.name;
    });
    if (artefact.id.empty()) artefact.id = "A-" + std::to_string(++last_artefact_);
    artefact.made = std::chrono::milliseconds(2000 + last_artefact_);
    artefact.bytes = bytes.size();
    artefacts_.push_back({artefact, {bytes.begin(), bytes.end()}});
    return artefact;
  }
  Result<std::vector<std::byte>> ReadArtefact(const std::string& id) override {
    for (const Kept& kept : artefacts_) {
      if (kept.row.id == id) return kept.bytes;
    }
    return Fail("read " + id, "it is not there", "look at the list");
  }
  Result<Artefact> GetArtefact(const std::string& id) override {
    for (const Kept& kept : artefacts_) {
      if (kept.row.id == id) return kept.row;
    }
    return Fail("find " + id, "it is not there", "look at the list");
  }
  Result<std::vector<Artefact>> ArtefactsOf(const std::string& scan_id) override {
    std::vector<Artefact> rows;
    for (const Kept& kept : artefacts_) {
      if (kept.row.scan_id == scan_id) rows.push_back(kept.row);
    }
    return rows;
  }
  Status RemoveArtefact(const std::string& id) override {
    std::erase_if(artefacts_, [&](const Kept& kept) { return kept.row.id == id; });
    return {};
  }
  Status DropDerived(const std::string&) override { return NotHere(); }

  Result<ErasureProof> Erase(const std::string&) override { return NotHere(); }
  Result<std::vector<Customer>> Expired() override { return NotHere(); }
  Status KeepUntil(const std::string&, StoreTime) override { return NotHere(); }

  Result<std::string> AddCalibration(const std::string& name, std::string_view json) override {
    Artefact row;
    row.id = "CAL-" + std::to_string(calibrations_.size() + 1);
    row.kind = "calibration";
    row.name = name;
    row.made = std::chrono::milliseconds(3000 + calibrations_.size());
    row.bytes = json.size();
    calibrations_.push_back({row, {}});
    texts_[row.id] = json;
    return row.id;
  }
  Result<std::vector<Artefact>> Calibrations() override {
    std::vector<Artefact> rows;
    for (const Kept& kept : calibrations_) rows.push_back(kept.row);
    return rows;
  }
  Result<std::string> ReadCalibration(const std::string& id) override {
    const auto found = texts_.find(id);
    if (found != texts_.end()) return found->second;
    return Fail("read calibration " + id, "it is not there", "look at the list");
  }

  Status AddUser(const User&, const std::string&) override { return NotHere(); }
  Result<std::optional<User>> GetUser(const std::string&) override { return NotHere(); }
  Result<std::vector<User>> Users() override { return NotHere(); }
  Status ChangeUser(const User&) override { return NotHere(); }
  Status RemoveUser(const std::string&) override { return NotHere(); }
  Status SetSecret(const std::string&, const std::string&, const std::string&) override { return NotHere(); }
  Result<std::string> Secret(const std::string&, const std::string&) override { return NotHere(); }
  Status NoteLogin(const std::string&) override { return NotHere(); }
  Status Audit(AuditLine) override { return {}; }
  Result<std::vector<AuditLine>> AuditLines(std::uint64_t, std::size_t) override { return NotHere(); }
  Result<std::string> VerifyAudit() override { return NotHere(); }
  Status SetSetting(const std::string& name, const std::string& json) override {
    settings_[name] = json;
    return {};
  }
  Result<std::optional<std::string>> Setting(const std::string& name) override {
    const auto found = settings_.find(name);
    return found == settings_.end() ? std::nullopt : std::optional(found->second);
  }
  Result<std::string> Backup(const std::string&) override { return NotHere(); }

 private:
  struct Kept {
    Artefact row;
    std::vector<std::byte> bytes;
  };
  static tl::unexpected<Error> NotHere() {
    return Fail("use a store in memory", "this is not kept in it", "use a real store");
  }

  std::vector<ScanRow> scans_;
  std::map<std::string, std::vector<std::byte>> recordings_;
  std::vector<Kept> artefacts_;
  std::uint64_t last_artefact_ = 0;
  std::vector<Kept> calibrations_;
  std::map<std::string, std::string> texts_;
  std::map<std::string, std::string> settings_;
};

}  // namespace annulus::test
