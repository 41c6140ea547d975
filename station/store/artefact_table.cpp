#include "station/store/artefact_table.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "station/store/sealed_text.h"

namespace annulus {
namespace {

constexpr std::string_view kColumns =
    "SELECT id, scan_id, customer_id, kind, derived, made_ms, bytes, file, sealed FROM artefacts ";

/// The seal of a row binds whose it is and which file it names.
std::string RowContext(const Artefact& artefact, const std::string& file) {
  return SealContext({"artefacts", artefact.id, artefact.scan_id, artefact.customer_id, artefact.kind, file});
}

std::string ContentContext(const Artefact& artefact) { return SealContext({"artefacts", "content", artefact.id}); }

Status CheckKind(const std::string& kind) {
  constexpr std::size_t kMaxKind = 32;
  if (!kind.empty() && kind.size() <= kMaxKind &&
      kind.find_first_not_of("abcdefghijklmnopqrstuvwxyz_-") == std::string::npos) {
    return {};
  }
  return Fail("store an artefact", "'" + kind + "' is no kind", "give a kind of lower-case letters");
}

}  // namespace

ArtefactTable::Row ArtefactTable::RowFrom(const SqlRow& row) {
  Row out;
  out.artefact.id = row.Text(0);
  out.artefact.scan_id = row.Text(1);
  out.artefact.customer_id = row.Text(2);
  out.artefact.kind = row.Text(3);
  out.artefact.derived = row.Number(4) != 0;
  out.artefact.made = StoreTime(row.Number(5));
  out.artefact.bytes = static_cast<std::uint64_t>(row.Number(6));
  out.file = row.Text(7);
  out.sealed = row.Bytes(8);
  return out;
}

Result<Artefact> ArtefactTable::Opened(Row row) {
  const auto key = parts_.vault.Key(row.artefact.customer_id);
  if (!key) return Fail(key);
  const std::string name = "the artefact " + row.artefact.id;
  const auto text = OpenText(*key, row.sealed, RowContext(row.artefact, row.file), name);
  if (!text) return Fail(text);
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object()) return Fail("open " + name, "what is sealed is no JSON", "restore the last backup");
  row.artefact.name = json.value("name", "");
  row.artefact.recipe = json.value("recipe", "");
  return std::move(row.artefact);
}

Result<ArtefactTable::Row> ArtefactTable::Find(const std::string& id) {
  std::optional<Row> found;
  const Status status = parts_.database.ForEach(std::string(kColumns) + "WHERE id = ?1", {id}, [&](const SqlRow& row) {
    found = RowFrom(row);
    return Status();
  });
  if (!status) return Fail(status);
  if (!found) return NoSuchRow("artefact", id);
  return std::move(*found);
}

Result<ArtefactTable::Put> ArtefactTable::Write(Artefact artefact, std::span<const std::byte> bytes) {
  RETURN_IF_ERROR(CheckKind(artefact.kind));
  RETURN_IF_ERROR(CheckText("artefact's name", artefact.name));
  RETURN_IF_ERROR(CheckText("artefact's recipe", artefact.recipe));
  artefact.customer_id.clear();
  RETURN_IF_ERROR(parts_.database.ForEach("SELECT customer_id FROM scans WHERE id = ?1", {artefact.scan_id},
                                          [&](const SqlRow& row) {
                                            artefact.customer_id = row.Text(0);
                                            return Status();
                                          }));
  if (artefact.customer_id.empty()) return NoSuchRow("scan", artefact.scan_id);
  const auto key = parts_.vault.Key(artefact.customer_id);
  if (!key) return Fail(key);
  const auto tag = KeyedTag(*key, BytesOf(artefact.name), SealContext({"artefacts", "name"}));
  std::optional<Row> old;
  RETURN_IF_ERROR(parts_.database.ForEach(std::string(kColumns) + "WHERE scan_id = ?1 AND kind = ?2 AND name_tag = ?3",
                                          {artefact.scan_id, artefact.kind, tag}, [&](const SqlRow& row) {
                                            old = RowFrom(row);
                                            return Status();
                                          }));
  RowId id;
  if (!old) {
    const auto next = NextRowId(parts_.database, 'A');
    if (!next) return Fail(next);
    id = *next;
  }
  artefact.id = old ? old->artefact.id : id.id;
  artefact.made = parts_.Now();
  artefact.bytes = bytes.size();
  auto staged = parts_.files.Stage();
  if (!staged) return Fail(staged);
  RETURN_IF_ERROR((*staged)->Append(SealBytes(*key, bytes, ContentContext(artefact))));
  const auto file = (*staged)->Place();
  if (!file) return Fail(file);
  const std::string json = nlohmann::json{{"name", artefact.name}, {"recipe", artefact.recipe}}.dump();
  const auto sealed = SealText(*key, json, RowContext(artefact, *file));
  const std::int64_t derived = artefact.derived ? 1 : 0;
  const auto size = static_cast<std::int64_t>(artefact.bytes);
  if (old) {
    RETURN_IF_ERROR(parts_.database.Run("INSERT OR IGNORE INTO removals VALUES (?1)", {old->file}));
    RETURN_IF_ERROR(parts_.database.Run(
        "UPDATE artefacts SET derived = ?2, made_ms = ?3, bytes = ?4, file = ?5, sealed = ?6 WHERE id = ?1",
        {artefact.id, derived, artefact.made.count(), size, *file, sealed}));
  } else {
    RETURN_IF_ERROR(parts_.database.Run("INSERT INTO artefacts VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
                                        {id.number, artefact.id, artefact.scan_id, artefact.customer_id, artefact.kind,
                                         tag, derived, artefact.made.count(), size, *file, sealed}));
  }
  return Put{std::move(artefact), std::move(*staged)};
}

Result<std::vector<std::byte>> ArtefactTable::Read(const std::string& id) {
  auto row = Find(id);
  if (!row) return Fail(row);
  const std::string file = row->file;
  const auto artefact = Opened(std::move(*row));  // the row's own seal says that this is its file
  if (!artefact) return Fail(artefact);
  const auto bytes = parts_.files.Read(file);
  if (!bytes)
    return Fail("read the artefact " + id, bytes.error().seen, "annulus rebuild makes it again if it is derived");
  const auto key = parts_.vault.Key(artefact->customer_id);
  if (!key) return Fail(key);
  return OpenBytes(*key, *bytes, ContentContext(*artefact), "the artefact " + id);
}

Result<Artefact> ArtefactTable::Get(const std::string& id) {
  auto row = Find(id);
  if (!row) return Fail(row);
  return Opened(std::move(*row));
}

Result<std::vector<Artefact>> ArtefactTable::Of(const std::string& scan_id) {
  std::vector<Artefact> artefacts;
  const Status status = parts_.database.ForEach(std::string(kColumns) + "WHERE scan_id = ?1 ORDER BY number", {scan_id},
                                                [&](const SqlRow& row) {
                                                  auto artefact = Opened(RowFrom(row));
                                                  if (!artefact) return Status(Fail(artefact));
                                                  artefacts.push_back(std::move(*artefact));
                                                  return Status();
                                                });
  if (!status) return Fail(status);
  return artefacts;
}

Status ArtefactTable::Remove(const std::string& id) {
  RETURN_IF_ERROR(parts_.database.Run("INSERT OR IGNORE INTO removals SELECT file FROM artefacts WHERE id = ?1", {id}));
  RETURN_IF_ERROR(parts_.database.Run("DELETE FROM artefacts WHERE id = ?1", {id}));
  if (parts_.database.changes() == 0) return NoSuchRow("artefact", id);
  return {};
}

Status ArtefactTable::DropDerived(const std::string& scan_id) {
  if (!scan_id.empty()) {
    const auto scan = parts_.database.Number("SELECT 1 FROM scans WHERE id = ?1", {scan_id});
    if (!scan) return Fail(scan);
    if (!*scan) return NoSuchRow("scan", scan_id);
  }
  RETURN_IF_ERROR(parts_.database.Run(
      "INSERT OR IGNORE INTO removals SELECT file FROM artefacts WHERE derived = 1 AND (?1 = '' OR scan_id = ?1)",
      {scan_id}));
  return parts_.database.Run("DELETE FROM artefacts WHERE derived = 1 AND (?1 = '' OR scan_id = ?1)", {scan_id});
}

}  // namespace annulus
