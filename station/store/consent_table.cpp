#include "station/store/consent_table.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

namespace annulus {
namespace {

constexpr std::array<std::string_view, 4> kPurposes{"measure", "glasses", "reshape", "research"};

constexpr std::string_view kColumns =
    "SELECT id, customer_id, purposes, text_version, language, taken_by, given_ms, withdrawn_ms FROM consents ";

Consent RowFrom(const SqlRow& row) {
  Consent consent;
  consent.id = row.Text(0);
  consent.customer_id = row.Text(1);
  const auto purposes = nlohmann::json::parse(row.Text(2), nullptr, false);
  for (const auto& purpose : purposes) {
    if (purpose.is_string()) consent.purposes.push_back(purpose.get<std::string>());
  }
  consent.text_version = row.Text(3);
  consent.language = row.Text(4);
  consent.taken_by = row.Text(5);
  consent.given = StoreTime(row.Number(6));
  if (!row.IsNull(7)) consent.withdrawn = StoreTime(row.Number(7));
  return consent;
}

}  // namespace

Result<Consent> ConsentTable::Add(Consent consent) {
  const std::string attempted = "store a consent of " + consent.customer_id;
  if (consent.purposes.empty()) return Fail(attempted, "it is for no purpose", "choose at least one");
  for (const std::string& purpose : consent.purposes) {
    if (std::find(kPurposes.begin(), kPurposes.end(), purpose) == kPurposes.end()) {
      return Fail(attempted, "'" + purpose + "' is no purpose", "choose of measure, glasses, reshape, research");
    }
  }
  RETURN_IF_ERROR(CheckText("consent's text version", consent.text_version));
  RETURN_IF_ERROR(CheckText("consent's language", consent.language));
  RETURN_IF_ERROR(CheckText("name of who took the consent", consent.taken_by));
  const auto customer = parts_.database.Number("SELECT 1 FROM customers WHERE id = ?1", {consent.customer_id});
  if (!customer) return Fail(customer);
  if (!*customer) return NoSuchRow("customer", consent.customer_id);
  const auto next = NextRowId(parts_.database, 'C');
  if (!next) return Fail(next);
  consent.id = next->id;
  consent.given = parts_.Now();
  consent.withdrawn.reset();
  const std::string purposes = nlohmann::json(consent.purposes).dump();
  RETURN_IF_ERROR(parts_.database.Run("INSERT INTO consents VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, NULL)",
                                      {next->number, consent.id, consent.customer_id, purposes, consent.text_version,
                                       consent.language, consent.taken_by, consent.given.count()}));
  return consent;
}

Result<std::vector<Consent>> ConsentTable::Of(const std::string& customer_id) {
  std::vector<Consent> consents;
  const Status status = parts_.database.ForEach(std::string(kColumns) + "WHERE customer_id = ?1 ORDER BY number",
                                                {customer_id}, [&](const SqlRow& row) {
                                                  consents.push_back(RowFrom(row));
                                                  return Status();
                                                });
  if (!status) return Fail(status);
  return consents;
}

Status ConsentTable::Withdraw(const std::string& id) {
  RETURN_IF_ERROR(parts_.database.Run("UPDATE consents SET withdrawn_ms = coalesce(withdrawn_ms, ?2) WHERE id = ?1",
                                      {id, parts_.Now().count()}));
  if (parts_.database.changes() == 0) return NoSuchRow("consent", id);
  return {};
}

Status ConsentTable::CheckInForce(const std::string& id, const std::string& customer_id) {
  const std::string attempted = "scan " + customer_id;
  std::optional<Consent> consent;
  RETURN_IF_ERROR(parts_.database.ForEach(std::string(kColumns) + "WHERE id = ?1", {id}, [&](const SqlRow& row) {
    consent = RowFrom(row);
    return Status();
  }));
  if (!consent || consent->customer_id != customer_id) {
    return Fail(attempted, "the consent '" + id + "' is not this customer's", "ask the customer for their consent");
  }
  if (consent->withdrawn) {
    return Fail(attempted, "the consent " + id + " was withdrawn", "ask the customer for a new one");
  }
  return {};
}

}  // namespace annulus
