#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/store/byte_search.h"
#include "station/store/store_parts.h"

namespace annulus {

/// Erases one customer, in an order that may be interrupted at any point and is then finished at the next start:
///
///     begun     a row says so; from here on there is no way back
///     key       destroyed, in the store and in the keys of backups: nothing of the customer opens any more
///     rows      deleted with secure_delete, their files noted for removal, in one transaction
///     files     unlinked, folders synced
///     remnants  WAL emptied; the database written anew if a deleted row can still be found in it
///     search    of all files for the customer's name, contact and keys
///     proof     in place of the customer
///
/// All but Search within the store's lock. Thread-bound; borrows all.
class Erasure {
 public:
  Erasure(StoreParts& parts, std::string customer_id) : parts_(parts), id_(std::move(customer_id)) {}

  /// What may not be found afterwards, while it can still be read.
  Result<std::vector<std::string>> Markers();
  /// Everything from "begun" to "remnants".
  Status Run();
  /// Of the database and its WAL.
  Status SearchDatabase(ByteSearch& search);
  /// Writes the proof.
  Result<ErasureProof> Finish(const ByteSearch& search);

 private:
  Status DestroyKeys();
  Status DeleteRows();
  Status RemoveRemnants(const std::vector<std::string>& remnants);
  Result<std::vector<std::string>> Remnants();

  StoreParts& parts_;
  std::string id_;
};

/// What a deletion took away; files are noted for removal.
struct DeletedRows {
  std::uint64_t rows = 0;
  std::uint64_t files = 0;
};
/// Deletes all rows of a customer, within the caller's transaction.
Result<DeletedRows> DeleteCustomerRows(Database& database, const std::string& customer_id);

/// Customers whose erasure was begun and not finished.
Result<std::vector<std::string>> UnfinishedErasures(Database& database);

/// The proof of an erasure that is finished; nothing if there is none.
Result<std::optional<ErasureProof>> ProofOf(Database& database, const std::string& customer_id);

/// Unlinks the files that deleted rows named; returns how many. What fails stays noted.
Result<std::uint64_t> RemoveNotedFiles(StoreParts& parts);

/// Looks through all files of the store but the database, and through its backups. Needs no lock.
Status SearchFiles(ByteSearch& search, const std::string& store_folder, const std::vector<std::string>& backups);

/// Where the store's backups and their keys are, as far as it made them.
Result<std::vector<std::string>> BackupPaths(Database& database);

}  // namespace annulus
