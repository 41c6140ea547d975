#include "station/console/scan_tickets.h"

#include <sodium.h>

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSetting = "scan_tickets";
constexpr std::size_t kKept = 1000;

std::string NewId() {
  std::array<unsigned char, 16> random{};
  ::randombytes_buf(random.data(), random.size());
  std::array<char, 33> hex{};
  ::sodium_bin2hex(hex.data(), hex.size(), random.data(), random.size());
  return "T-" + std::string(hex.data());
}

Json ToJson(const ScanTicket& ticket) {
  return {{"id", ticket.id},
          {"customer_id", ticket.customer_id},
          {"consent_id", ticket.consent_id},
          {"profile", ticket.profile},
          {"user", ticket.user},
          {"armed_ms", ticket.armed.count()}};
}

Result<Json> ReadAll(Store& store) {
  const auto text = store.Setting(kSetting);
  if (!text) return Fail(text);
  if (!*text) return Json::array();
  Json list = Json::parse(**text, nullptr, false);
  if (!list.is_array()) return Fail("read the tickets of scans", "they are damaged", "restore a backup of the store");
  return list;
}

bool IsOf(const Json& entry, const std::string& id) { return entry.is_object() && entry.value("id", "") == id; }

}  // namespace

Result<ScanTicket> ScanTickets::Add(ScanTicket ticket) {
  const std::lock_guard lock(mutex_);
  ticket.id = NewId();
  auto list = ReadAll(store_);
  if (!list) return Fail(list);
  while (list->size() >= kKept) list->erase(list->begin());
  list->push_back(ToJson(ticket));
  RETURN_IF_ERROR(store_.SetSetting(kSetting, list->dump()));
  return ticket;
}

Status ScanTickets::Remove(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto list = ReadAll(store_);
  if (!list) return Fail(list);
  Json kept = Json::array();
  for (const Json& entry : *list) {
    if (!IsOf(entry, id)) kept.push_back(entry);
  }
  return store_.SetSetting(kSetting, kept.dump());
}

Result<std::optional<ScanTicket>> ScanTickets::Find(const std::string& id) const {
  const auto list = ReadAll(store_);
  if (!list) return Fail(list);
  for (const Json& entry : *list) {
    if (!IsOf(entry, id)) continue;
    ScanTicket ticket{id, entry.value("customer_id", ""), entry.value("consent_id", ""), entry.value("profile", ""),
                      entry.value("user", "")};
    ticket.armed = StoreTime(entry.value("armed_ms", std::int64_t{0}));
    return std::optional(std::move(ticket));
  }
  return std::optional<ScanTicket>();
}

}  // namespace annulus
