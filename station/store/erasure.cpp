#include "station/store/erasure.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "station/store/backup.h"
#include "station/store/customer_table.h"
#include "station/store/sealed_text.h"

namespace annulus {
namespace {

/// Shorter texts occur in ciphertext by chance (8 bytes: once in 18 exabytes); they are looked for as the JSON that is
/// sealed would have them.
constexpr std::size_t kLeastMarker = 8;
/// Of a deleted value, enough to know it by (its nonce is random).
constexpr std::size_t kRemnantBytes = 32;

void AddText(const std::string& key, const std::string& text, std::vector<std::string>& markers) {
  if (text.empty()) return;
  if (text.size() >= kLeastMarker) markers.push_back(text);
  const std::string json = nlohmann::json(text).dump();
  markers.push_back("\"" + key + "\":" + json);
}

void AddSecret(std::span<const std::byte> secret, std::vector<std::string>& markers) {
  markers.emplace_back(reinterpret_cast<const char*>(secret.data()), secret.size());
  markers.push_back(HexOf(secret));
}

/// Tables with rows of a customer, those that refer to others first.
struct PersonalTable {
  const char* name;
  const char* column;  ///< Customer's id.
};
constexpr std::array<PersonalTable, 4> kPersonal{
    {{"artefacts", "customer_id"}, {"scans", "customer_id"}, {"consents", "customer_id"}, {"customers", "id"}}};

}  // namespace

Result<std::vector<std::string>> Erasure::Markers() {
  std::vector<std::string> markers;
  const auto customer = CustomerTable(parts_).Get(id_);
  if (customer) {  // else its key is gone already: nobody can read what to look for
    AddText("name", customer->name, markers);
    AddText("contact", customer->contact, markers);
    AddText("note", customer->note, markers);
  }
  if (const auto key = parts_.vault.Key(id_)) AddSecret(std::as_bytes(std::span(key->bytes)), markers);
  if (const auto wrapped = parts_.vault.Wrapped(id_)) AddSecret(wrapped->sealed, markers);
  return markers;
}

Status Erasure::Run() {
  const auto remnants = Remnants();
  if (!remnants) return Fail(remnants);
  {
    Transaction transaction(parts_.database);
    RETURN_IF_ERROR(transaction.Begin());
    RETURN_IF_ERROR(parts_.database.Run("INSERT OR IGNORE INTO erasures(customer_id, begun_ms) VALUES (?1, ?2)",
                                        {id_, parts_.Now().count()}));
    RETURN_IF_ERROR(transaction.Commit());
  }
  RETURN_IF_ERROR(DestroyKeys());
  RETURN_IF_ERROR(DeleteRows());
  const auto removed = RemoveNotedFiles(parts_);
  if (!removed) return Fail(removed);
  return RemoveRemnants(*remnants);
}

Status Erasure::DestroyKeys() {
  RETURN_IF_ERROR(parts_.vault.Destroy(id_));
  std::vector<std::string> key_files;
  RETURN_IF_ERROR(parts_.database.ForEach("SELECT keys_path FROM backups", {}, [&](const SqlRow& row) {
    key_files.push_back(row.Text(0));
    return Status();
  }));
  for (const std::string& path : key_files) RETURN_IF_ERROR(RemoveKeyOfBackup(parts_.storage, path, id_));
  return {};
}

Status Erasure::DeleteRows() {
  Transaction transaction(parts_.database);
  RETURN_IF_ERROR(transaction.Begin());
  const auto deleted = DeleteCustomerRows(parts_.database, id_);
  if (!deleted) return Fail(deleted);
  RETURN_IF_ERROR(parts_.database.Run(
      "UPDATE erasures SET files = files + ?2, rows = rows + ?3, key_destroyed = max(key_destroyed, ?4) "
      "WHERE customer_id = ?1",
      {id_, static_cast<std::int64_t>(deleted->files), static_cast<std::int64_t>(deleted->rows),
       static_cast<std::int64_t>(parts_.vault.Has(id_) ? 0 : 1)}));
  return transaction.Commit();
}

Result<std::vector<std::string>> Erasure::Remnants() {
  std::vector<std::string> remnants;
  for (const char* sql :
       {"SELECT sealed FROM artefacts WHERE customer_id = ?1", "SELECT sealed FROM scans WHERE customer_id = ?1",
        "SELECT sealed FROM customers WHERE id = ?1"}) {
    const Status status = parts_.database.ForEach(sql, {id_}, [&](const SqlRow& row) {
      const auto bytes = row.Bytes(0);
      remnants.emplace_back(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), kRemnantBytes));
      return Status();
    });
    if (!status) return Fail(status);
  }
  return remnants;
}

Status Erasure::RemoveRemnants(const std::vector<std::string>& remnants) {
  RETURN_IF_ERROR(parts_.database.TruncateWal());
  ByteSearch search(remnants);
  RETURN_IF_ERROR(SearchDatabase(search));
  if (search.hits() == 0) return {};
  RETURN_IF_ERROR(parts_.database.Vacuum());
  return parts_.database.TruncateWal();
}

Status Erasure::SearchDatabase(ByteSearch& search) {
  return parts_.database.VisitBytes(search.overlap(), [&](std::span<const std::byte> block) { search.Look(block); });
}

Result<ErasureProof> Erasure::Finish(const ByteSearch& search) {
  Transaction transaction(parts_.database);
  RETURN_IF_ERROR(transaction.Begin());
  RETURN_IF_ERROR(parts_.database.Run(
      "UPDATE erasures SET finished_ms = ?2, bytes_searched = ?3, marker_hits = ?4 WHERE customer_id = ?1",
      {id_, parts_.Now().count(), static_cast<std::int64_t>(search.bytes()),
       static_cast<std::int64_t>(search.hits())}));
  RETURN_IF_ERROR(transaction.Commit());
  const auto proof = ProofOf(parts_.database, id_);
  if (!proof) return Fail(proof);
  if (!*proof) return NoSuchRow("erasure of", id_);
  return **proof;
}

Result<DeletedRows> DeleteCustomerRows(Database& database, const std::string& customer_id) {
  DeletedRows deleted;
  for (const char* sql : {"INSERT OR IGNORE INTO removals SELECT file FROM artefacts WHERE customer_id = ?1",
                          "INSERT OR IGNORE INTO removals SELECT recording FROM scans WHERE customer_id = ?1 AND "
                          "recording IS NOT NULL"}) {
    RETURN_IF_ERROR(database.Run(sql, {customer_id}));
    deleted.files += database.changes();
  }
  for (const PersonalTable& table : kPersonal) {
    RETURN_IF_ERROR(
        database.Run(std::string("DELETE FROM ") + table.name + " WHERE " + table.column + " = ?1", {customer_id}));
    deleted.rows += database.changes();
  }
  return deleted;
}

Result<std::vector<std::string>> UnfinishedErasures(Database& database) {
  std::vector<std::string> ids;
  const Status status =
      database.ForEach("SELECT customer_id FROM erasures WHERE finished_ms IS NULL", {}, [&](const SqlRow& row) {
        ids.push_back(row.Text(0));
        return Status();
      });
  if (!status) return Fail(status);
  return ids;
}

Result<std::optional<ErasureProof>> ProofOf(Database& database, const std::string& customer_id) {
  std::optional<ErasureProof> proof;
  const Status status = database.ForEach(
      "SELECT finished_ms, files, rows, key_destroyed, bytes_searched, marker_hits FROM erasures "
      "WHERE customer_id = ?1 AND finished_ms IS NOT NULL",
      {customer_id}, [&](const SqlRow& row) {
        proof.emplace();
        proof->customer_id = customer_id;
        proof->time = StoreTime(row.Number(0));
        proof->files = static_cast<std::uint64_t>(row.Number(1));
        proof->rows = static_cast<std::uint64_t>(row.Number(2));
        proof->key_destroyed = row.Number(3) != 0;
        proof->bytes_searched = static_cast<std::uint64_t>(row.Number(4));
        proof->marker_hits = static_cast<std::uint64_t>(row.Number(5));
        return Status();
      });
  if (!status) return Fail(status);
  return proof;
}

Result<std::uint64_t> RemoveNotedFiles(StoreParts& parts) {
  std::vector<std::string> noted;
  const Status status = parts.database.ForEach("SELECT file FROM removals", {}, [&](const SqlRow& row) {
    noted.push_back(row.Text(0));
    return Status();
  });
  if (!status) return Fail(status);
  if (noted.empty()) return std::uint64_t{0};
  for (const std::string& file : noted) RETURN_IF_ERROR(parts.files.Remove(file));
  Transaction transaction(parts.database);
  RETURN_IF_ERROR(transaction.Begin());
  for (const std::string& file : noted) {
    RETURN_IF_ERROR(parts.database.Run("DELETE FROM removals WHERE file = ?1", {file}));
  }
  RETURN_IF_ERROR(transaction.Commit());
  return noted.size();
}

Status SearchFiles(ByteSearch& search, const std::string& store_folder, const std::vector<std::string>& backups) {
  namespace fs = std::filesystem;
  std::vector<std::string> places = backups;
  places.push_back(store_folder);
  const std::string database = fs::path(DatabasePath(store_folder)).filename().string();
  for (const std::string& place : places) {
    std::error_code error;
    if (fs::is_regular_file(place, error)) RETURN_IF_ERROR(search.LookAtFile(place));
    if (!fs::is_directory(place, error)) continue;
    for (auto entry = fs::recursive_directory_iterator(place, error); !error && entry != fs::end(entry);
         entry.increment(error)) {
      // Opening and closing the live database would drop SQLite's locks (database.h); it was searched through SQLite.
      const std::string name = entry->path().filename().string();
      const bool live = entry->path().parent_path() == fs::path(store_folder) &&
                        (name == database || name == database + "-wal" || name == database + "-shm");
      if (live || !entry->is_regular_file(error)) continue;
      RETURN_IF_ERROR(search.LookAtFile(entry->path().string()));
    }
    if (error) return Fail("search " + place, error.message(), "check the disk and its permissions");
  }
  return {};
}

Result<std::vector<std::string>> BackupPaths(Database& database) {
  std::vector<std::string> paths;
  const Status status = database.ForEach("SELECT path, keys_path FROM backups", {}, [&](const SqlRow& row) {
    paths.push_back(row.Text(0));
    paths.push_back(row.Text(1));
    return Status();
  });
  if (!status) return Fail(status);
  return paths;
}

}  // namespace annulus
