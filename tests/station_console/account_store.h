#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "station/store/store.h"

namespace annulus::test {

/// A store that keeps users, their secrets, settings and the audit in memory; all else is refused. Thread-bound.
class AccountStore final : public Store {
 public:
  std::vector<AuditLine> audit;  ///< What was written, in order.
  StoreState store_state = StoreState::kReady;
  std::vector<Customer> expired;  ///< What Expired says; Erase takes them away.

  [[nodiscard]] StoreState state() const override { return store_state; }
  [[nodiscard]] std::string problem() const override {
    return store_state == StoreState::kReady ? "" : "the database is damaged";
  }
  Result<int> Schema() override { return 1; }

  Status AddUser(const User& user, const std::string& password_hash) override {
    users_[user.name] = user;
    secrets_[user.name]["password"] = password_hash;
    return {};
  }
  Result<std::optional<User>> GetUser(const std::string& name) override {
    const auto found = users_.find(name);
    if (found == users_.end()) return std::optional<User>();
    return std::optional<User>(WithSecrets(found->second));
  }
  Result<std::vector<User>> Users() override {
    std::vector<User> all;
    for (const auto& [name, user] : users_) all.push_back(WithSecrets(user));
    return all;
  }
  Status ChangeUser(const User& user) override {
    users_[user.name] = user;
    return {};
  }
  Status RemoveUser(const std::string& name) override {
    users_.erase(name);
    secrets_.erase(name);
    return {};
  }
  Status SetSecret(const std::string& user, const std::string& what, const std::string& secret) override {
    secrets_[user][what] = secret;
    return {};
  }
  Result<std::string> Secret(const std::string& user, const std::string& what) override { return secrets_[user][what]; }
  Status NoteLogin(const std::string& user) override {
    users_[user].last_login = StoreTime(1);
    return {};
  }
  Status Audit(AuditLine line) override {
    line.number = audit.size() + 1;
    line.hash = std::to_string(line.number);
    audit.push_back(std::move(line));
    return {};
  }
  Result<std::vector<AuditLine>> AuditLines(std::uint64_t from, std::size_t limit) override {
    std::vector<AuditLine> lines;
    if (from == 0) from = audit.size() - std::min(limit, audit.size()) + 1;
    for (const AuditLine& line : audit) {
      if (line.number >= from && lines.size() < limit) lines.push_back(line);
    }
    return lines;
  }
  Result<std::string> VerifyAudit() override { return audit.empty() ? "" : audit.back().hash; }
  Status SetSetting(const std::string& name, const std::string& json) override {
    settings_[name] = json;
    return {};
  }
  Result<std::optional<std::string>> Setting(const std::string& name) override {
    const auto found = settings_.find(name);
    return found == settings_.end() ? std::optional<std::string>() : std::optional<std::string>(found->second);
  }
  Result<std::vector<Customer>> Expired() override { return expired; }
  Result<ErasureProof> Erase(const std::string& id) override {
    std::erase_if(expired, [&](const Customer& one) { return one.id == id; });
    ErasureProof proof;
    proof.customer_id = id;
    proof.key_destroyed = true;
    return proof;
  }
  Result<std::string> Backup(const std::string& folder) override { return folder + "/annulus-backup-2026-11-29"; }
  Result<std::vector<Customer>> FindCustomers(std::string_view, std::size_t) override {
    return std::vector<Customer>();
  }
  Result<std::vector<ScanRow>> LatestScans(std::size_t) override { return std::vector<ScanRow>(); }

  Result<Customer> AddCustomer(Customer) override { return NotHere(); }
  Result<Customer> GetCustomer(const std::string&) override { return NotHere(); }
  Status ChangeCustomer(const Customer&) override { return NotHere(); }
  Result<Consent> AddConsent(Consent) override { return NotHere(); }
  Result<std::vector<Consent>> Consents(const std::string&) override { return NotHere(); }
  Status WithdrawConsent(const std::string&) override { return NotHere(); }
  Result<ScanRow> AddScan(ScanRow, const std::string&, const KeySource*) override { return NotHere(); }
  Status JudgeScan(const std::string&, const std::string&, const std::string&) override { return NotHere(); }
  Result<ScanRow> GetScan(const std::string&) override { return NotHere(); }
  Result<std::vector<ScanRow>> ScansOf(const std::string&) override { return NotHere(); }
  Result<std::vector<std::byte>> ReadRecording(const std::string&) override { return NotHere(); }
  Result<Artefact> PutArtefact(Artefact, std::span<const std::byte>) override { return NotHere(); }
  Result<std::vector<std::byte>> ReadArtefact(const std::string&) override { return NotHere(); }
  Result<Artefact> GetArtefact(const std::string&) override { return NotHere(); }
  Result<std::vector<Artefact>> ArtefactsOf(const std::string&) override { return NotHere(); }
  Status RemoveArtefact(const std::string&) override { return NotHere(); }
  Status DropDerived(const std::string&) override { return NotHere(); }
  Status KeepUntil(const std::string&, StoreTime) override { return NotHere(); }
  Result<std::string> AddCalibration(const std::string&, std::string_view) override { return NotHere(); }
  Result<std::vector<Artefact>> Calibrations() override { return NotHere(); }
  Result<std::string> ReadCalibration(const std::string&) override { return NotHere(); }

 private:
  static tl::unexpected<Error> NotHere() {
    return Fail("use a store of accounts", "this is not kept in it", "use a real store");
  }
  User WithSecrets(User user) {
    user.has_pin = !secrets_[user.name]["pin"].empty();
    user.has_totp = !secrets_[user.name]["totp"].empty();
    return user;
  }

  std::map<std::string, User> users_;
  std::map<std::string, std::map<std::string, std::string>> secrets_;
  std::map<std::string, std::string> settings_;
};

}  // namespace annulus::test
