#include "station/store/scan_table.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "acquisition/mcap_bytes.h"
#include "station/store/sealed_text.h"

namespace annulus {
namespace {

/// Frames of a recording that comes without a seal: damage costs one of them.
constexpr std::size_t kFrameBytes = 65'536;

constexpr std::string_view kColumns =
    "SELECT id, customer_id, consent_id, profile, verdict, recording, taken_ms, sealed FROM scans ";

/// The seal of a scan's row binds what the row says of persons and files.
std::string ContextOf(const ScanRow& scan) {
  return SealContext({"scans", scan.id, scan.customer_id, scan.consent_id, scan.recording});
}

ScanRow RowFrom(const SqlRow& row) {
  ScanRow scan;
  scan.id = row.Text(0);
  scan.customer_id = row.Text(1);
  scan.consent_id = row.Text(2);
  scan.profile = row.Text(3);
  scan.verdict = row.Text(4);
  scan.recording = row.Text(5);
  scan.taken = StoreTime(row.Number(6));
  return scan;
}

/// Hands what is written on to a file on its way into the store.
class StagedWriter final : public AppendFile {
 public:
  explicit StagedWriter(StagedFile& staged) : staged_(staged) {}
  Status Append(std::span<const std::byte> bytes) override { return staged_.Append(bytes); }
  Status Sync() override { return {}; }  // StagedFile::Place does
  Status Reserve(std::uint64_t) override { return {}; }
  Status Close() override { return {}; }

 private:
  StagedFile& staged_;
};

/// The frames in which a recording is sealed again: as before, or the bytes that all recordings begin with, then
/// pieces.
std::vector<std::uint64_t> FrameSizes(const Unsealed& recording) {
  if (!recording.sizes.empty() && recording.first_frame) return recording.sizes;
  std::vector<std::uint64_t> sizes;
  std::uint64_t rest = recording.bytes.size();
  for (std::uint64_t size = kMcapMagic.size(); rest > 0; size = kFrameBytes) {
    sizes.push_back(std::min(size, rest));
    rest -= sizes.back();
  }
  return sizes;
}

}  // namespace

Result<ScanRow> ScanTable::Opened(ScanRow row, const std::vector<std::byte>& sealed) {
  row.recording_missing = !row.recording.empty() && !parts_.files.Has(row.recording);
  const auto key = parts_.vault.Key(row.customer_id);
  if (!key) return Fail(key);
  auto summary = OpenText(*key, sealed, ContextOf(row), "the scan " + row.id);
  if (!summary) return Fail(summary);
  row.summary_json = std::move(*summary);
  return row;
}

Result<std::string> ScanTable::Take(StagedFile& staged, const std::vector<std::byte>& bytes, const std::string& file,
                                    const KeySource* keys, const std::string& customer_id) {
  Unsealed recording;
  if (LooksSealed(bytes)) {
    auto unsealed = UnsealRecording(bytes, file, keys);
    if (!unsealed) return Fail(unsealed);
    recording = std::move(*unsealed);
  } else {
    recording.bytes = bytes;
  }
  const auto key = parts_.vault.Key(customer_id);
  if (!key) return Fail(key);
  SealedFile sealed(std::make_unique<StagedWriter>(staged), {customer_id, *key, RandomSealedFileId()});
  std::span<const std::byte> rest = recording.bytes;
  for (const std::uint64_t size : FrameSizes(recording)) {
    RETURN_IF_ERROR(sealed.Append(rest.first(size)));
    rest = rest.subspan(size);
  }
  return staged.Place();
}

Result<ScanTable::Added> ScanTable::Add(ScanRow scan, const std::string& file, const KeySource* keys) {
  RETURN_IF_ERROR(CheckText("scan's profile", scan.profile));
  RETURN_IF_ERROR(CheckText("scan's summary", scan.summary_json));
  const auto key = parts_.vault.Key(scan.customer_id);
  if (!key) return Fail(key);
  Added added;
  std::vector<std::byte> tag;
  scan.recording.clear();
  if (!file.empty()) {
    const auto bytes = parts_.storage.ReadAll(file, kMaxInputBytes);
    if (!bytes) return Fail(bytes);
    if (bytes->empty()) return Fail("take " + file + " into the store", "it is empty", "scan again");
    tag = KeyedTag(*key, *bytes, SealContext({"scans", "source"}));
    std::optional<std::string> known;
    RETURN_IF_ERROR(parts_.database.ForEach("SELECT id FROM scans WHERE customer_id = ?1 AND source_tag = ?2",
                                            {scan.customer_id, tag}, [&](const SqlRow& row) {
                                              known = row.Text(0);
                                              return Status();
                                            }));
    if (known) {  // the program died between the row and the removal of `file`
      auto row = Get(*known);
      if (!row) return Fail(row);
      added.row = std::move(*row);
      return added;
    }
    auto staged = parts_.files.Stage();
    if (!staged) return Fail(staged);
    const auto hash = Take(**staged, *bytes, file, keys, scan.customer_id);
    if (!hash) return Fail(hash);
    scan.recording = *hash;
    added.file = std::move(*staged);
  }
  const auto next = NextRowId(parts_.database, 'S');
  if (!next) return Fail(next);
  scan.id = next->id;
  scan.recording_missing = false;
  if (scan.taken == StoreTime(0)) scan.taken = parts_.Now();
  const auto sealed = SealText(*key, scan.summary_json, ContextOf(scan));
  RETURN_IF_ERROR(parts_.database.Run(
      "INSERT INTO scans VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)",
      {next->number, scan.id, scan.customer_id, scan.consent_id, scan.profile, scan.verdict, OrNull(scan.recording),
       tag.empty() ? SqlValue() : SqlValue(tag), scan.taken.count(), sealed}));
  added.row = std::move(scan);
  return added;
}

Status ScanTable::Judge(const std::string& id, const std::string& verdict, const std::string& summary_json) {
  RETURN_IF_ERROR(CheckText("scan's summary", summary_json));
  const auto scan = Get(id);
  if (!scan) return Fail(scan);
  const auto key = parts_.vault.Key(scan->customer_id);
  if (!key) return Fail(key);
  return parts_.database.Run("UPDATE scans SET verdict = ?2, sealed = ?3 WHERE id = ?1",
                             {id, verdict, SealText(*key, summary_json, ContextOf(*scan))});
}

Result<ScanRow> ScanTable::Get(const std::string& id) {
  std::optional<ScanRow> scan;
  std::vector<std::byte> sealed;
  RETURN_IF_ERROR(parts_.database.ForEach(std::string(kColumns) + "WHERE id = ?1", {id}, [&](const SqlRow& row) {
    scan = RowFrom(row);
    sealed = row.Bytes(7);
    return Status();
  }));
  if (!scan) return NoSuchRow("scan", id);
  return Opened(std::move(*scan), sealed);
}

Result<std::vector<ScanRow>> ScanTable::Of(const std::string& customer_id) {
  std::vector<ScanRow> scans;
  const Status status = parts_.database.ForEach(std::string(kColumns) + "WHERE customer_id = ?1 ORDER BY number",
                                                {customer_id}, [&](const SqlRow& row) {
                                                  auto scan = Opened(RowFrom(row), row.Bytes(7));
                                                  if (!scan) return Status(Fail(scan));
                                                  scans.push_back(std::move(*scan));
                                                  return Status();
                                                });
  if (!status) return Fail(status);
  return scans;
}

Result<std::vector<ScanRow>> ScanTable::Latest(std::size_t limit) {
  std::vector<ScanRow> scans;
  const Status status = parts_.database.ForEach(std::string(kColumns) + "ORDER BY number DESC LIMIT ?1",
                                                {static_cast<std::int64_t>(limit)}, [&](const SqlRow& row) {
                                                  ScanRow plain = RowFrom(row);
                                                  plain.recording_missing =
                                                      !plain.recording.empty() && !parts_.files.Has(plain.recording);
                                                  auto scan = Opened(plain, row.Bytes(7));
                                                  scans.push_back(scan ? std::move(*scan) : std::move(plain));
                                                  return Status();
                                                });
  if (!status) return Fail(status);
  return scans;
}

Result<std::vector<std::byte>> ScanTable::ReadRecording(const std::string& id) {
  const auto scan = Get(id);
  if (!scan) return Fail(scan);
  const std::string name = "the recording of " + id;
  if (scan->recording.empty()) return Fail("read " + name, "nothing was recorded", "scan again");
  const auto bytes = parts_.files.Read(scan->recording);
  if (!bytes) return Fail("read " + name, bytes.error().seen, bytes.error().advice);
  const auto key_id = SealedKeyId(*bytes, name);
  if (!key_id) return Fail(key_id);
  if (*key_id != scan->customer_id) return Fail("read " + name, "it is another customer's", "restore the last backup");
  auto unsealed = UnsealRecording(*bytes, name, &parts_.vault);
  if (!unsealed) return Fail(unsealed);
  return std::move(unsealed->bytes);
}

}  // namespace annulus
