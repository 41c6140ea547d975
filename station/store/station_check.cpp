#include "station/store/station_check.h"

#include <optional>

#include "station/store/sealed_text.h"

namespace annulus {
namespace {

constexpr std::string_view kText = "this store's station key";

std::string CheckContext() { return SealContext({"station check"}); }

Result<std::optional<std::vector<std::byte>>> SealedCheck(Database& database) {
  std::optional<std::vector<std::byte>> sealed;
  const Status status = database.ForEach("SELECT sealed FROM station_check", {}, [&](const SqlRow& row) {
    sealed = row.Bytes(0);
    return Status();
  });
  if (!status) return Fail(status);
  return sealed;
}

}  // namespace

Result<bool> HasStationCheck(Database& database) {
  const auto sealed = SealedCheck(database);
  if (!sealed) return Fail(sealed);
  return sealed->has_value();
}

Status CheckStationKey(Database& database, const KeyVault& vault) {
  const auto sealed = SealedCheck(database);
  if (!sealed) return Fail(sealed);
  if (!*sealed) {
    const auto made = vault.SealForStation(kText, CheckContext());
    if (!made) return Fail(made);
    return database.Run("INSERT INTO station_check VALUES (1, ?1)", {*made});
  }
  const auto text = vault.OpenForStation(**sealed, CheckContext(), "the store");
  if (text && *text == kText) return {};
  return Fail("open the store " + database.path(), "the station's key is not the one that it was made with",
              "give the key file of this store (its copy, if it was lost)");
}

}  // namespace annulus
