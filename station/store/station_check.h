#pragma once

#include "base/result.h"
#include "station/store/database.h"
#include "station/store/key_vault.h"

namespace annulus {

/// True if the database knows its station's key already.
Result<bool> HasStationCheck(Database& database);

/// Fails unless the vault's station key is the one that the store was made with; a new store remembers it.
Status CheckStationKey(Database& database, const KeyVault& vault);

}  // namespace annulus
