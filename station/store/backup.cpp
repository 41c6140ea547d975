#include "station/store/backup.h"

#include <sys/stat.h>

#include <array>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <sstream>
#include <utility>

#include "base/log.h"
#include "station/store/content_files.h"
#include "station/store/key_vault.h"

namespace annulus {
namespace {

constexpr std::string_view kKeysHeader =
    "# Keys of a backup, each wrapped by the station's key. To be kept apart from the backup, and not for longer than\n"
    "# erasures may take: what has no key in any such file can never be opened again.\n";

constexpr std::string_view kPrefix = "annulus-backup-";
/// Ending of a backup's folder until it is whole.
constexpr std::string_view kPart = ".part";

/// Held open as long as the backup is being written: who finds it free finds one that was cut short.
std::string MarkOf(const std::string& part) { return part + "/unfinished"; }

/// "2026-11-29-223015", UTC.
std::string StampOf(StoreTime time) {
  const auto seconds = static_cast<std::time_t>(std::chrono::floor<std::chrono::seconds>(time).count());
  std::tm day{};
  gmtime_r(&seconds, &day);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d-%H%M%S", &day)};
}

}  // namespace

std::string KeysOfBackup(const std::string& backup) { return backup + "-keys"; }

Result<std::vector<std::string>> FilesNamedIn(Database& database) {
  std::vector<std::string> files;
  const Status status =
      database.ForEach("SELECT recording FROM scans WHERE recording IS NOT NULL UNION SELECT file FROM artefacts", {},
                       [&](const SqlRow& row) {
                         files.push_back(row.Text(0));
                         return Status();
                       });
  if (!status) return Fail(status);
  return files;
}

Status CopyContentFiles(Database& database, ContentFiles& from, const std::string& to, Storage& storage) {
  const auto files = FilesNamedIn(database);
  if (!files) return Fail(files);
  const ContentFiles target(to, storage);
  for (const std::string& file : *files) {
    if (!IsContentHash(file))
      return Fail("copy the store's files", "a row names no file", "run 'annulus store verify'");
    const auto bytes = from.Read(file);
    if (!bytes) {  // missing here is missing there: the rest is worth a copy
      Log(LogLevel::kWarning, bytes.error().Text());
      continue;
    }
    const std::string path = target.PathOf(file);
    RETURN_IF_ERROR(storage.CreateFolder(std::filesystem::path(path).parent_path().string()));
    RETURN_IF_ERROR(WriteFileAtomically(storage, path, *bytes));
  }
  return {};
}

Backup::Backup(StoreParts& parts, const std::string& folder)
    : parts_(parts),
      folder_(std::filesystem::absolute(folder.empty() ? BackupsFolder(parts.options.folder) : folder)
                  .lexically_normal()
                  .string()) {}

Status Backup::Begin() {
  RETURN_IF_ERROR(folder_ == std::filesystem::absolute(BackupsFolder(parts_.options.folder)).lexically_normal().string()
                      ? MakePrivateFolder(parts_.storage, folder_)
                      : parts_.storage.CreateFolder(folder_));
  RETURN_IF_ERROR(RemoveAbandoned());
  const StoreTime now = parts_.Now();
  const std::string first = folder_ + "/" + std::string(kPrefix) + StampOf(now);
  path_ = first;
  for (int again = 2; parts_.storage.Exists(path_) || parts_.storage.Exists(KeysOfBackup(path_)); ++again) {
    path_ = first + "-" + std::to_string(again);
  }
  RETURN_IF_ERROR(parts_.storage.CreateFolder(Part()));
  auto mark = parts_.storage.Create(MarkOf(Part()));
  if (!mark) return Fail(mark);
  mark_ = std::move(*mark);
  // Before the keys are there, so that no file of keys is ever without this note.
  RETURN_IF_ERROR(parts_.database.Run("INSERT OR REPLACE INTO backups VALUES (?1, ?2, ?3)",
                                      {path_, KeysOfBackup(path_), now.count()}));
  return {};
}

std::string Backup::Part() const { return path_ + std::string(kPart); }

Backup::~Backup() {
  if (mark_ == nullptr) return;  // it is whole, or was never begun
  mark_.reset();
  std::error_code error;
  std::filesystem::remove_all(Part(), error);
  static_cast<void>(DestroySecretFile(parts_.storage, KeysOfBackup(path_)));  // else the next backup does
}

Status Backup::RemoveAbandoned() {
  namespace fs = std::filesystem;
  std::error_code error;
  std::vector<std::string> abandoned;
  for (auto entry = fs::directory_iterator(folder_, error); !error && entry != fs::end(entry); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const std::string path = folder_ + "/" + name;
    if (!name.starts_with(kPrefix) || !name.ends_with(kPart) || parts_.storage.InUse(MarkOf(path))) continue;
    abandoned.push_back(path);
  }
  for (const std::string& path : abandoned) {
    RETURN_IF_ERROR(DestroySecretFile(parts_.storage, KeysOfBackup(path.substr(0, path.size() - kPart.size()))));
    fs::remove_all(path, error);
  }
  return {};
}

Result<std::string> Backup::KeyLines() {
  std::string lines(kKeysHeader);
  const auto ids = parts_.vault.Ids();
  if (!ids) return Fail(ids);
  for (const std::string& id : *ids) {
    const auto wrapped = parts_.vault.Wrapped(id);
    if (!wrapped) return Fail(wrapped);
    lines += wrapped->Line();
  }
  return lines;
}

Status Backup::WriteKeys() {
  const auto lines = KeyLines();
  if (!lines) return Fail(lines);
  RETURN_IF_ERROR(WriteFileAtomically(parts_.storage, KeysOfBackup(path_), *lines));
  ::chmod(KeysOfBackup(path_).c_str(), S_IRUSR | S_IWUSR);  // some disks (FAT) have no permissions
  return {};
}

Result<std::string> Backup::Copy() {
  const std::string part = Part();
  {
    auto source = Database::Open(DatabasePath(parts_.options.folder), Database::Access::kReadOnly);
    if (!source) return Fail(source);
    RETURN_IF_ERROR((*source)->CopyTo(DatabasePath(part)));
  }
  {
    auto copy = Database::Open(DatabasePath(part), Database::Access::kReadOnly);
    if (!copy) return Fail(copy);
    RETURN_IF_ERROR(CopyContentFiles(**copy, parts_.files, FilesFolder(part), parts_.storage));
  }
  const std::string anchors = AnchorsPath(parts_.options.folder);
  if (parts_.storage.Exists(anchors)) {
    const auto text = ReadTextFile(parts_.storage, anchors);
    if (!text) return Fail(text);
    RETURN_IF_ERROR(WriteFileAtomically(parts_.storage, AnchorsPath(part), *text));
  }
  RETURN_IF_ERROR(parts_.storage.Remove(MarkOf(part)));
  RETURN_IF_ERROR(parts_.storage.SyncFolder(DatabasePath(part)));
  RETURN_IF_ERROR(parts_.storage.Rename(part, path_));
  mark_.reset();
  return path_;
}

Status RemoveKeyOfBackup(Storage& storage, const std::string& keys_path, const std::string& customer_id) {
  if (!storage.Exists(keys_path)) return {};
  const auto text = ReadTextFile(storage, keys_path);
  if (!text) return Fail(text);
  std::istringstream lines(*text);
  std::string kept;
  for (std::string line; std::getline(lines, line);) {
    const auto wrapped = WrappedKey::Parse(line);
    if (!wrapped || wrapped->id != customer_id) kept += line + "\n";
  }
  if (kept == *text) return {};
  RETURN_IF_ERROR(ReplaceSecretFile(storage, keys_path, kept));
  ::chmod(keys_path.c_str(), S_IRUSR | S_IWUSR);
  return {};
}

Status DestroyOldBackupKeys(StoreParts& parts) {
  const StoreTime oldest = parts.Now() - std::chrono::duration_cast<StoreTime>(parts.options.keep_key_backups);
  std::vector<std::string> old;
  RETURN_IF_ERROR(parts.database.ForEach("SELECT keys_path FROM backups WHERE made_ms < ?1", {oldest.count()},
                                         [&](const SqlRow& row) {
                                           old.push_back(row.Text(0));
                                           return Status();
                                         }));
  for (const std::string& path : old) RETURN_IF_ERROR(DestroySecretFile(parts.storage, path));
  return {};
}

}  // namespace annulus
