#include "station/store/customer_table.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/store/sealed_text.h"
#include "station/store/search_text.h"
#include "station/store/station_table.h"

namespace annulus {
namespace {

std::string ContextOf(const std::string& id) { return SealContext({"customers", id}); }

/// "42", "K-42" or "k-000042" as a customer's number; nothing if it is none.
std::optional<std::int64_t> NumberIn(std::string_view search) {
  if (search.starts_with("k-")) search.remove_prefix(2);
  constexpr std::size_t kMaxDigits = 15;
  if (search.empty() || search.size() > kMaxDigits ||
      search.find_first_not_of("0123456789") != std::string_view::npos) {
    return std::nullopt;
  }
  return std::stoll(std::string(search));
}

Customer RowFrom(const SqlRow& row) {
  Customer customer;
  customer.id = row.Text(0);
  customer.created = StoreTime(row.Number(1));
  customer.keep_until = StoreTime(row.Number(2));
  return customer;
}

Status CheckTexts(const Customer& customer) {
  RETURN_IF_ERROR(CheckText("customer's name", customer.name));
  RETURN_IF_ERROR(CheckText("customer's contact", customer.contact));
  RETURN_IF_ERROR(CheckText("note on the customer", customer.note));
  return CheckText("prescription", customer.prescription_json.value_or(""));
}

}  // namespace

Result<std::vector<std::byte>> CustomerTable::Sealed(const Customer& customer, const SealKey& key) {
  nlohmann::json json{{"name", customer.name}, {"contact", customer.contact}, {"note", customer.note}};
  if (customer.height_mm) json["height_mm"] = *customer.height_mm;
  if (customer.prescription_json) json["prescription"] = *customer.prescription_json;
  std::string text = json.dump();
  auto sealed = SealText(key, text, ContextOf(customer.id));
  Wipe(text);
  return sealed;
}

Result<Customer> CustomerTable::Opened(Customer row, const std::vector<std::byte>& sealed) {
  const auto key = parts_.vault.Key(row.id);
  if (!key) return Fail(key);
  auto text = OpenText(*key, sealed, ContextOf(row.id), "the customer " + row.id);
  if (!text) return Fail(text);
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  Wipe(*text);
  if (!json.is_object()) return Fail("open the customer " + row.id, "what is sealed is no JSON", "restore a backup");
  row.name = json.value("name", "");
  row.contact = json.value("contact", "");
  row.note = json.value("note", "");
  if (json.contains("height_mm")) row.height_mm = json.value("height_mm", 0);
  if (json.contains("prescription")) row.prescription_json = json.value("prescription", "");
  return row;
}

Result<Customer> CustomerTable::Add(Customer customer) {
  RETURN_IF_ERROR(CheckTexts(customer));
  const auto next = NextRowId(parts_.database, 'K');
  if (!next) return Fail(next);
  customer.id = next->id;
  customer.created = parts_.Now();
  if (customer.keep_until == StoreTime(0)) {
    const auto until = EndOfKeeping();
    if (!until) return Fail(until);
    customer.keep_until = *until;
  }
  const auto key = parts_.vault.MakeKey(customer.id);  // durable before the row that needs it
  if (!key) return Fail(key);
  const auto sealed = Sealed(customer, *key);
  if (!sealed) return Fail(sealed);
  RETURN_IF_ERROR(parts_.database.Run(
      "INSERT INTO customers(number, id, sealed, created_ms, keep_until_ms) VALUES (?1, ?2, ?3, ?4, ?5)",
      {next->number, customer.id, *sealed, customer.created.count(), customer.keep_until.count()}));
  Remember(next->number, customer);
  return customer;
}

Result<Customer> CustomerTable::Get(const std::string& id) {
  std::optional<Customer> row;
  std::vector<std::byte> sealed;
  RETURN_IF_ERROR(parts_.database.ForEach("SELECT id, created_ms, keep_until_ms, sealed FROM customers WHERE id = ?1",
                                          {id}, [&](const SqlRow& found) {
                                            row = RowFrom(found);
                                            sealed = found.Bytes(3);
                                            return Status();
                                          }));
  if (!row) return NoSuchRow("customer", id);
  return Opened(std::move(*row), sealed);
}

Status CustomerTable::Change(const Customer& customer) {
  RETURN_IF_ERROR(CheckTexts(customer));
  const auto number = parts_.database.Number("SELECT number FROM customers WHERE id = ?1", {customer.id});
  if (!number) return Fail(number);
  if (!*number) return NoSuchRow("customer", customer.id);
  const auto key = parts_.vault.Key(customer.id);
  if (!key) return Fail(key);
  const auto sealed = Sealed(customer, *key);
  if (!sealed) return Fail(sealed);
  RETURN_IF_ERROR(parts_.database.Run("UPDATE customers SET sealed = ?2 WHERE id = ?1", {customer.id, *sealed}));
  ForgetNames(customer.id);
  Remember(**number, customer);
  return {};
}

Result<std::vector<Customer>> CustomerTable::Find(std::string_view search, std::size_t limit) {
  std::vector<Customer> found;
  const std::string form = SearchForm(search);
  if (form.empty()) {
    RETURN_IF_ERROR(parts_.database.ForEach(
        "SELECT id, created_ms, keep_until_ms, sealed FROM customers ORDER BY number DESC LIMIT ?1",
        {static_cast<std::int64_t>(limit)}, [&](const SqlRow& row) {
          auto opened = Opened(RowFrom(row), row.Bytes(3));
          found.push_back(opened ? std::move(*opened) : RowFrom(row));
          return Status();
        }));
    return found;
  }
  if (!names_) RETURN_IF_ERROR(LoadNames());
  const auto number = NumberIn(form);
  for (auto names = names_->rbegin(); names != names_->rend() && found.size() < limit; ++names) {
    if (names->number != number && names->name.find(form) == std::string::npos &&
        names->contact.find(form) == std::string::npos) {
      continue;
    }
    auto customer = Get(names->id);
    if (customer) found.push_back(std::move(*customer));
  }
  return found;
}

Result<std::vector<Customer>> CustomerTable::Expired() {
  std::vector<Customer> expired;
  const Status status = parts_.database.ForEach(
      "SELECT id, created_ms, keep_until_ms, sealed FROM customers WHERE keep_until_ms < ?1 ORDER BY keep_until_ms",
      {parts_.Now().count()}, [&](const SqlRow& row) {
        auto opened = Opened(RowFrom(row), row.Bytes(3));
        expired.push_back(opened ? std::move(*opened) : RowFrom(row));
        return Status();
      });
  if (!status) return Fail(status);
  return expired;
}

Result<StoreTime> CustomerTable::EndOfKeeping() {
  const auto setting = StationTable(parts_).Setting(kRetentionSetting);
  if (!setting) return Fail(setting);
  const auto days = nlohmann::json::parse(setting->value_or(""), nullptr, false);
  return parts_.Now() + (days.is_number_integer() ? std::chrono::hours(24 * days.get<int>()) : parts_.options.keep);
}

Status CustomerTable::KeepFromNow(const std::string& id) {
  const auto until = EndOfKeeping();
  if (!until) return Fail(until);
  return parts_.database.Run("UPDATE customers SET keep_until_ms = max(keep_until_ms, ?2) WHERE id = ?1",
                             {id, until->count()});
}

Status CustomerTable::KeepUntil(const std::string& id, StoreTime until) {
  RETURN_IF_ERROR(parts_.database.Run("UPDATE customers SET keep_until_ms = ?2 WHERE id = ?1", {id, until.count()}));
  if (parts_.database.changes() == 0) return NoSuchRow("customer", id);
  return {};
}

Status CustomerTable::LoadNames() {
  names_.emplace();
  const Status status =
      parts_.database.ForEach("SELECT id, created_ms, keep_until_ms, sealed, number FROM customers ORDER BY number", {},
                              [&](const SqlRow& row) {
                                const auto customer = Opened(RowFrom(row), row.Bytes(3));
                                if (customer) Remember(row.Number(4), *customer);
                                return Status();
                              });
  if (!status) ForgetNames();
  return status;
}

void CustomerTable::Remember(std::int64_t number, const Customer& customer) {
  if (!names_) return;
  const auto place = std::lower_bound(names_->begin(), names_->end(), number,
                                      [](const Names& names, std::int64_t value) { return names.number < value; });
  names_->insert(place, {number, customer.id, SearchForm(customer.name), SearchForm(customer.contact)});
}

void CustomerTable::ForgetNames() {
  if (!names_) return;
  for (Names& names : *names_) {
    Wipe(names.name);
    Wipe(names.contact);
  }
  names_.reset();
}

void CustomerTable::ForgetNames(const std::string& id) {
  if (!names_) return;
  const auto found = std::find_if(names_->begin(), names_->end(), [&](const Names& names) { return names.id == id; });
  if (found == names_->end()) return;
  Wipe(found->name);
  Wipe(found->contact);
  names_->erase(found);
}

}  // namespace annulus
