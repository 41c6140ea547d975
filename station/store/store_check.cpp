#include "station/store/store_check.h"

namespace annulus {
namespace {

constexpr std::size_t kAll = 1'000'000'000;

template <class T>
bool Found(const Result<T>& result, StoreCheck& check) {
  if (!result) check.problems.push_back(result.error().Text());
  return result.has_value();
}

void CheckScan(Store& store, const ScanRow& scan, StoreCheck& check) {
  ++check.scans;
  if (!scan.recording.empty() && Found(store.ReadRecording(scan.id), check)) ++check.recordings;
  const auto artefacts = store.ArtefactsOf(scan.id);
  if (!Found(artefacts, check)) return;
  for (const Artefact& artefact : *artefacts) {
    if (Found(store.ReadArtefact(artefact.id), check)) ++check.artefacts;
  }
}

}  // namespace

StoreCheck CheckStore(Store& store) {
  StoreCheck check;
  if (!store.problem().empty()) check.problems.push_back(store.problem());
  const auto customers = store.FindCustomers("", kAll);
  if (Found(customers, check)) {
    for (const Customer& customer : *customers) {
      ++check.customers;
      Found(store.GetCustomer(customer.id), check);
      const auto scans = store.ScansOf(customer.id);
      if (!Found(scans, check)) continue;
      for (const ScanRow& scan : *scans) CheckScan(store, scan, check);
    }
  }
  const auto last = store.VerifyAudit();
  if (Found(last, check)) check.last_audit_hash = *last;
  const auto lines = store.AuditLines(1, kAll);
  if (Found(lines, check)) check.audit_lines = lines->size();
  return check;
}

}  // namespace annulus
