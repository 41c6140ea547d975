#include "station/console/retention.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "base/log.h"
#include "station/console/model_cache.h"
#include "station/store/store.h"

namespace annulus {
namespace {

/// Setting of the store: when retention was applied last, ms since 1970.
constexpr const char* kAppliedSetting = "retention_applied_ms";

void Audit(Store& store, const std::string& action, const std::string& subject, const std::string& result) {
  AuditLine line;
  line.origin = "program";
  line.action = action;
  line.subject = subject;
  line.result = result;
  const Status written = store.Audit(std::move(line));
  if (!written) Log(LogLevel::kError, "the audit does not take a line: " + written.error().Text());
}

}  // namespace

int RetentionDays(Store& store, const StoreConfig& config) {
  const auto setting = store.Setting(kRetentionSetting);
  if (!setting || !*setting) return config.keep_days;
  const auto days = nlohmann::json::parse(**setting, nullptr, false);
  return days.is_number_integer() ? days.get<int>() : config.keep_days;
}

Result<std::optional<StoreTime>> Retention::LastApplied() {
  const auto setting = store_.Setting(kAppliedSetting);
  if (!setting) return Fail(setting);
  const auto time = nlohmann::json::parse(setting->value_or(""), nullptr, false);
  if (!time.is_number_integer()) return std::optional<StoreTime>();
  return std::optional<StoreTime>(time.get<std::int64_t>());
}

Result<bool> Retention::IsHeld() {
  const auto last = LastApplied();
  if (!last) return Fail(last);
  const auto now = std::chrono::floor<StoreTime>(clock_.WallNow());
  if (!*last || now - **last <= kLongestGap) return false;
  const auto expired = store_.Expired();
  if (!expired) return Fail(expired);
  return !expired->empty();
}

Result<std::vector<ErasureProof>> Retention::Apply(const Note& note) {
  const auto expired = store_.Expired();
  if (!expired) return Fail(expired);
  if (!expired->empty()) models_.DropAll();
  std::vector<ErasureProof> proofs;
  for (const Customer& customer : *expired) {
    auto proof = store_.Erase(customer.id);
    note(customer.id, proof ? "ok" : "failed");
    if (!proof) return Fail(proof);
    proofs.push_back(std::move(*proof));
  }
  const auto now = std::chrono::floor<StoreTime>(clock_.WallNow());
  RETURN_IF_ERROR(store_.SetSetting(kAppliedSetting, std::to_string(now.count())));
  return proofs;
}

Result<std::vector<ErasureProof>> Retention::ApplyByItself() {
  const auto held = IsHeld();
  if (!held) return Fail(held);
  if (*held) {
    Audit(store_, "apply retention", "", "held back: not applied for more than 31 days, or the clock has jumped");
    return std::vector<ErasureProof>();
  }
  return Apply([this](const std::string& id, const std::string& result) { Audit(store_, "erase", id, result); });
}

bool Retention::IsDue() {
  const auto now = clock_.Now();
  if (looked_ && now - *looked_ < kEvery) return false;
  looked_ = now;
  return true;
}

}  // namespace annulus
