#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/storage.h"
#include "tests/support/dice.h"

namespace annulus::test {

/// How a call of a CrashDisk goes wrong.
enum class DiskFault {
  kNoSpace,     ///< ENOSPC: that call fails, and from then on whatever needs room. A write keeps half of its bytes.
  kIoError,     ///< EIO: that call fails, later ones work.
  kShortWrite,  ///< That write keeps half of its bytes and fails, later ones work. Counts writes only.
  kSyncError,   ///< EIO of a sync: what was not on the disk never gets there, later syncs succeed, as on Linux.
                ///< Counts syncs only.
  kReadOnly,    ///< EROFS: that call and every later one that writes fail.
};

/// What the caller of a sync does until it is over.
enum class SyncCaller { kWaits, kGoesOn };

/// Where a sector that became garbage is garbage.
enum class Garbage {
  kNewBytes,     ///< Where bytes were being written; the durable ones before them stay (power-safe overwrite).
  kWholeSector,  ///< From its start: a drive that spoils the sector it rewrites.
};

/// A power cut: which calls were over, and what became of the rest.
struct PowerCut {
  std::size_t entries = 0;                 ///< Calls of the journal that were made.
  std::uint64_t torn_bytes = 0;            ///< Bytes of the next call, if it is a write, that were taken.
  std::chrono::nanoseconds time{0};        ///< When; on the clock of set_time().
  std::chrono::nanoseconds sync_takes{0};  ///< A sync that nobody waited for is over this long after its call.
  std::uint64_t seed = 0;                  ///< Draws the fate of every sector.
  Garbage garbage = Garbage::kNewBytes;    ///< Where garbage goes.
};

/// A simulated disk with its file system and page cache. Every call is kept in a journal, from which the remains of a
/// power cut after any call can be made as often as wanted. The model:
///
///     bytes     on the disk for sure after a completed Sync; before, each 512-byte sector by itself is on the disk,
///               not there (what it held before, else zeros), half there, or garbage: in any order
///     size      of a file: as of the last completed Sync, or that of any later write
///     names     a created, renamed or removed name is there for sure after SyncFolder or a completed Rename; before,
///               those calls got through up to any one of them
///     tail      bytes that were durable stay so when the rest of their sector is written again (power-safe overwrite)
///     sync      after a failed one, what it should have brought to the disk is lost, though it can be read until the
///               power goes
///
/// Thread-bound; must outlive its files.
class CrashDisk final : public Storage {
 public:
  static constexpr std::size_t kSectorBytes = 512;
  using Files = std::map<std::string, std::vector<std::byte>>;

  enum class Op { kCreate, kWrite, kSync, kSyncFailed, kRename, kRemove, kSyncFolder };
  /// One call that changed something.
  struct Entry {
    Op op = Op::kCreate;
    std::size_t file = 0;
    std::uint64_t offset = 0;
    std::vector<std::byte> bytes{};
    std::string name{};      ///< Created, removed, or renamed from.
    std::string new_name{};  ///< Renamed to.
    std::chrono::nanoseconds time{0};
    SyncCaller caller = SyncCaller::kWaits;  ///< Of a sync.
  };

  /// A disk with files on it, all durable.
  explicit CrashDisk(const Files& files = {});

  /// What the disk's clock says at the next calls.
  void set_time(std::chrono::nanoseconds time) { time_ = time; }
  /// Whether the callers of syncs from now on wait until they are over, whatever PowerCut::sync_takes says.
  void set_caller(SyncCaller caller) { caller_ = caller; }
  /// What a sector may hold that the file system handed out without clearing it: bytes of a deleted file, by offset.
  void set_stale_bytes(std::vector<std::byte> bytes) { stale_ = std::move(bytes); }
  /// The `n`-th call from now on (1 = the next) that `fault` counts fails so.
  void FailCall(std::uint64_t n, DiskFault fault);
  /// True once that call was made.
  [[nodiscard]] bool fault_hit() const { return fault_hit_; }
  /// Calls of any kind since the fault was hit, itself left out.
  [[nodiscard]] std::uint64_t calls_after_fault() const { return calls_after_fault_; }
  /// Calls of any kind so far.
  [[nodiscard]] std::uint64_t calls() const { return calls_; }

  [[nodiscard]] const std::vector<Entry>& journal() const { return journal_; }
  /// What is on the disk after the cut.
  [[nodiscard]] Files AfterPowerCut(const PowerCut& cut) const;
  /// What programs see now.
  [[nodiscard]] Files Live() const;

  Result<std::unique_ptr<AppendFile>> Create(const std::string& path) override;
  Result<std::vector<std::byte>> ReadAll(const std::string& path, std::uint64_t max_bytes) override;
  Status Rename(const std::string& from, const std::string& to) override;
  Status Remove(const std::string& path) override;
  [[nodiscard]] bool Exists(const std::string& path) const override { return names_.contains(path); }
  Status CreateFolder(const std::string& path) override { return Call("create folder " + path, Need::kRoom); }
  Result<std::uint64_t> FreeBytes(const std::string& path) override;
  Status SyncFolder(const std::string& path) override;
  Result<std::vector<std::string>> List(const std::string& folder) override;

  /// For planted defects: renames without a sync of the folder.
  Status RenameOnly(const std::string& from, const std::string& to);
  /// For planted defects: writes anywhere into a file.
  Status WriteAt(std::size_t file, std::uint64_t offset, std::span<const std::byte> bytes);
  /// The number of the file that has this name now.
  [[nodiscard]] std::optional<std::size_t> FileOf(const std::string& path) const;
  /// For planted defects: a file is gone for good, without a call that could fail.
  void Unlink(const std::string& path);

 private:
  /// What a call needs, for the faults that last.
  enum class Need { kNothing, kWriting, kRoom };
  class File;

  Status Call(const std::string& attempted, Need need);
  [[nodiscard]] bool Counts(DiskFault fault, const std::string& attempted) const;
  Status SyncFile(std::size_t file, const std::string& path);
  Status AppendTo(std::size_t file, const std::string& path, std::span<const std::byte> bytes);
  void Keep(Entry entry);

  std::vector<Entry> journal_;
  std::map<std::string, std::size_t> names_;
  std::vector<std::vector<std::byte>> contents_;  ///< Of the page cache, by file.
  std::vector<std::byte> stale_;
  std::chrono::nanoseconds time_{0};
  SyncCaller caller_ = SyncCaller::kWaits;
  std::optional<DiskFault> fault_;
  std::uint64_t calls_until_fault_ = 0;
  bool fault_hit_ = false;
  std::uint64_t calls_ = 0;
  std::uint64_t calls_after_fault_ = 0;
};

}  // namespace annulus::test
