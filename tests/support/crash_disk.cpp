#include "tests/support/crash_disk.h"

#include <algorithm>
#include <utility>

#include "base/ensure.h"

namespace annulus::test {
namespace {

/// Bytes [begin, end) of a file.
struct Range {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
};

/// Copies `bytes` into `content` at `offset`; a gap becomes zeros.
void Put(std::vector<std::byte>& content, std::uint64_t offset, std::span<const std::byte> bytes) {
  content.resize(std::max<std::size_t>(content.size(), offset + bytes.size()));
  std::copy(bytes.begin(), bytes.end(), content.begin() + static_cast<std::ptrdiff_t>(offset));
}

std::span<const std::byte> Part(const std::vector<std::byte>& content, const Range& range) {
  return std::span(content).subspan(range.begin, range.end - range.begin);
}

/// A file while the journal is gone through.
struct Replayed {
  std::vector<std::byte> cached;     ///< What programs saw.
  std::vector<std::byte> durable;    ///< What the last completed sync left on the disk.
  std::vector<Range> dirty;          ///< Written since, in order, adjacent ones joined.
  std::vector<std::uint64_t> sizes;  ///< Of the file after each write since.

  void Write(std::uint64_t offset, std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    Put(cached, offset, bytes);
    const Range range{offset, offset + bytes.size()};
    if (!dirty.empty() && dirty.back().end == range.begin) {
      dirty.back().end = range.end;
    } else {
      dirty.push_back(range);
    }
    sizes.push_back(cached.size());
  }
  void Sync() {
    durable.resize(cached.size());
    for (const Range& range : dirty) Put(durable, range.begin, Part(cached, range));
    dirty.clear();
    sizes.clear();
  }
  void FailSync() {
    durable.resize(cached.size());  // the size is the journal's; the bytes are gone
    dirty.clear();
    sizes.clear();
  }
};

/// What becomes of one sector that was written but not synced.
enum class Fate { kThere, kLost, kFrontHalf, kBackHalf, kGarbage, kStale };

/// Draws fates, by one of several kinds of cut so that the states are of many shapes.
class Fates {
 public:
  Fates(Dice& dice, std::size_t sectors)
      : dice_(dice),
        kind_(static_cast<Kind>(dice.Below(kKinds))),
        special_(dice.Below(std::max<std::size_t>(sectors, 1))) {}

  Fate Of(std::size_t sector) {
    switch (kind_) {
      case Kind::kAllThere:
        return Fate::kThere;
      case Kind::kAllLost:
        return Fate::kLost;
      case Kind::kInOrder:
        return sector < special_ ? Fate::kThere : (sector == special_ ? AnyFate() : Fate::kLost);
      case Kind::kBackwards:
        return sector > special_ ? Fate::kThere : (sector == special_ ? AnyFate() : Fate::kLost);
      case Kind::kOneBad:
        return sector == special_ ? AnyFate() : Fate::kThere;
      case Kind::kSome:
        return dice_.Below(2) == 0 ? Fate::kThere : Fate::kLost;
      case Kind::kAnything:
        break;
    }
    return AnyFate();
  }

 private:
  enum class Kind { kAllThere, kAllLost, kInOrder, kBackwards, kOneBad, kSome, kAnything };
  static constexpr std::uint64_t kKinds = 7;

  Fate AnyFate() {
    constexpr std::uint64_t kFates = 6;
    return static_cast<Fate>(dice_.Below(kFates));
  }

  Dice& dice_;
  Kind kind_;
  std::size_t special_;
};

/// One sector's share of a dirty range.
struct Piece {
  Range range;
  Fate fate = Fate::kThere;
};

std::vector<Piece> PiecesOf(const std::vector<Range>& dirty, Dice& dice) {
  std::vector<Piece> pieces;
  for (const Range& range : dirty) {
    for (std::uint64_t begin = range.begin; begin < range.end;) {
      const std::uint64_t sector_end = (begin / CrashDisk::kSectorBytes + 1) * CrashDisk::kSectorBytes;
      const std::uint64_t end = std::min(range.end, sector_end);
      pieces.push_back({{begin, end}, Fate::kThere});
      begin = end;
    }
  }
  Fates fates(dice, pieces.size());
  for (std::size_t i = 0; i < pieces.size(); ++i) pieces[i].fate = fates.Of(i);
  return pieces;
}

/// How a file lies on the disk after the cut.
class Remains {
 public:
  Remains(const Replayed& file, const std::vector<std::byte>& stale, const PowerCut& cut, Dice& dice)
      : file_(file), stale_(stale), cut_(cut), dice_(dice) {}

  std::vector<std::byte> Make() {
    bytes_ = file_.durable;
    const std::uint64_t size = DrawSize();
    bytes_.resize(std::max(bytes_.size(), file_.cached.size()));
    for (const Piece& piece : PiecesOf(file_.dirty, dice_)) Apply(piece);
    bytes_.resize(size);
    return std::move(bytes_);
  }

 private:
  std::uint64_t DrawSize() {
    const std::uint64_t durable = file_.durable.size();
    if (file_.sizes.empty()) return durable;
    switch (dice_.Below(4)) {
      case 0:
        return durable;
      case 1:
        return std::max(durable, file_.sizes[dice_.Below(file_.sizes.size())]);
      default:
        return std::max(durable, file_.sizes.back());
    }
  }

  void Apply(const Piece& piece) {
    const std::uint64_t middle = piece.range.begin + (piece.range.end - piece.range.begin) / 2;
    switch (piece.fate) {
      case Fate::kThere:
        return CopyNew(piece.range);
      case Fate::kLost:
        return;
      case Fate::kFrontHalf:
        return CopyNew({piece.range.begin, middle});
      case Fate::kBackHalf:
        return CopyNew({middle, piece.range.end});
      case Fate::kGarbage:
        return Spoil(piece.range);
      case Fate::kStale:
        for (std::uint64_t at = piece.range.begin; at < std::min<std::uint64_t>(piece.range.end, stale_.size()); ++at) {
          bytes_[at] = stale_[at];
        }
        return;
    }
  }

  void CopyNew(const Range& range) { Put(bytes_, range.begin, Part(file_.cached, range)); }

  void Spoil(Range range) {
    if (cut_.garbage == Garbage::kWholeSector) range.begin -= range.begin % CrashDisk::kSectorBytes;
    for (std::uint64_t at = range.begin; at < range.end; ++at) bytes_[at] = static_cast<std::byte>(dice_.Next() >> 56U);
  }

  const Replayed& file_;
  const std::vector<std::byte>& stale_;
  const PowerCut& cut_;
  Dice& dice_;
  std::vector<std::byte> bytes_;
};

/// True if a sync was over when the power went.
bool IsOver(const CrashDisk::Entry& sync, const PowerCut& cut) {
  return sync.caller == SyncCaller::kWaits || sync.time + cut.sync_takes <= cut.time;
}

using Names = std::map<std::string, std::size_t>;

void ApplyToNames(Names& names, const CrashDisk::Entry& entry) {
  using Op = CrashDisk::Op;
  if (entry.op == Op::kCreate) names[entry.name] = entry.file;
  if (entry.op == Op::kRemove) names.erase(entry.name);
  if (entry.op != Op::kRename) return;
  names[entry.new_name] = entry.file;
  names.erase(entry.name);
}

/// The names that are there after the cut: the synced ones, and the later changes up to any one of them.
Names NamesAfter(std::span<const CrashDisk::Entry> made, Dice& dice) {
  using Op = CrashDisk::Op;
  Names names;
  std::vector<const CrashDisk::Entry*> pending;
  for (const CrashDisk::Entry& entry : made) {
    if (entry.op == Op::kSyncFolder) {
      for (const CrashDisk::Entry* change : pending) ApplyToNames(names, *change);
      pending.clear();
    } else if (entry.op == Op::kCreate || entry.op == Op::kRename || entry.op == Op::kRemove) {
      pending.push_back(&entry);
    }
  }
  const std::uint64_t through = dice.Below(pending.size() + 1);
  for (std::size_t i = 0; i < through; ++i) ApplyToNames(names, *pending[i]);
  return names;
}

tl::unexpected<Error> FailWith(const std::string& attempted, DiskFault fault) {
  switch (fault) {
    case DiskFault::kNoSpace:
      return Fail(attempted, "No space left on device", "free space on this disk or choose another");
    case DiskFault::kReadOnly:
      return Fail(attempted, "Read-only file system", "this disk is read-only: choose another");
    default:
      return Fail(attempted, "Input/output error", "check the disk and the path");
  }
}

}  // namespace

class CrashDisk::File final : public AppendFile {
 public:
  File(CrashDisk& disk, std::size_t file, std::string path) : disk_(disk), file_(file), path_(std::move(path)) {}

  Status Append(std::span<const std::byte> bytes) override { return disk_.AppendTo(file_, path_, bytes); }
  Status Sync() override { return disk_.SyncFile(file_, path_); }
  Status Reserve(std::uint64_t) override { return disk_.Call("reserve for " + path_, Need::kRoom); }
  Status Close() override { return disk_.Call("close " + path_, Need::kNothing); }

 private:
  CrashDisk& disk_;
  std::size_t file_;
  std::string path_;
};

CrashDisk::CrashDisk(const Files& files) {
  for (const auto& [path, bytes] : files) {
    const std::size_t file = contents_.size();
    contents_.push_back(bytes);
    names_[path] = file;
    Keep({.op = Op::kCreate, .file = file, .name = path});
    Keep({.op = Op::kWrite, .file = file, .bytes = bytes});
    Keep({.op = Op::kSync, .file = file});
  }
  Keep({.op = Op::kSyncFolder});
}

void CrashDisk::Keep(Entry entry) {
  entry.time = time_;
  entry.caller = caller_;
  journal_.push_back(std::move(entry));
}

void CrashDisk::FailCall(std::uint64_t n, DiskFault fault) {
  ENSURE(n > 0, "calls are counted from 1");
  fault_ = fault;
  calls_until_fault_ = n;
  fault_hit_ = false;
}

bool CrashDisk::Counts(DiskFault fault, const std::string& attempted) const {
  if (fault == DiskFault::kShortWrite) return attempted.starts_with("write ");
  if (fault == DiskFault::kSyncError) return attempted.starts_with("sync ");
  return true;
}

Status CrashDisk::Call(const std::string& attempted, Need need) {
  ++calls_;
  if (!fault_) return {};
  if (!fault_hit_) {
    if (!Counts(*fault_, attempted) || --calls_until_fault_ > 0) return {};
    fault_hit_ = true;
    return FailWith(attempted, *fault_);
  }
  ++calls_after_fault_;
  const bool no_room = *fault_ == DiskFault::kNoSpace && need == Need::kRoom;
  const bool no_writing = *fault_ == DiskFault::kReadOnly && need != Need::kNothing;
  if (no_room || no_writing) return FailWith(attempted, *fault_);
  return {};
}

Result<std::unique_ptr<AppendFile>> CrashDisk::Create(const std::string& path) {
  RETURN_IF_ERROR(Call("create " + path, Need::kRoom));
  if (names_.contains(path)) return Fail("create " + path, "File exists", "choose another name or remove it first");
  const std::size_t file = contents_.size();
  contents_.emplace_back();
  names_[path] = file;
  Keep({.op = Op::kCreate, .file = file, .name = path});
  return std::make_unique<File>(*this, file, path);
}

Result<std::vector<std::byte>> CrashDisk::ReadAll(const std::string& path, std::uint64_t max_bytes) {
  RETURN_IF_ERROR(Call("read " + path, Need::kNothing));
  const auto file = FileOf(path);
  if (!file) return Fail("read " + path, "No such file or directory", "check the path");
  if (contents_[*file].size() > max_bytes) return Fail("read " + path, "it is too large", "give a smaller file");
  return contents_[*file];
}

Status CrashDisk::RenameOnly(const std::string& from, const std::string& to) {
  RETURN_IF_ERROR(Call("rename " + from, Need::kWriting));
  const auto file = FileOf(from);
  if (!file) return Fail("rename " + from, "No such file or directory", "check the path");
  names_.erase(from);
  names_[to] = *file;
  Keep({.op = Op::kRename, .file = *file, .name = from, .new_name = to});
  return {};
}

Status CrashDisk::Rename(const std::string& from, const std::string& to) {
  RETURN_IF_ERROR(RenameOnly(from, to));
  Keep({.op = Op::kSyncFolder});
  return {};
}

Status CrashDisk::Remove(const std::string& path) {
  RETURN_IF_ERROR(Call("remove " + path, Need::kWriting));
  const auto file = FileOf(path);
  if (!file) return Fail("remove " + path, "No such file or directory", "check the path");
  names_.erase(path);
  Keep({.op = Op::kRemove, .file = *file, .name = path});
  return {};
}

Result<std::uint64_t> CrashDisk::FreeBytes(const std::string& path) {
  RETURN_IF_ERROR(Call("ask how much room is left for " + path, Need::kNothing));
  return fault_hit_ && fault_ == DiskFault::kNoSpace ? 0 : std::uint64_t{1} << 40U;
}

Status CrashDisk::AppendTo(std::size_t file, const std::string& path, std::span<const std::byte> bytes) {
  const Status status = Call("write " + path, Need::kRoom);
  const bool half = !status && (*fault_ == DiskFault::kShortWrite || *fault_ == DiskFault::kNoSpace);
  const std::size_t kept = status ? bytes.size() : (half ? bytes.size() / 2 : 0);
  Keep({.op = Op::kWrite,
        .file = file,
        .offset = contents_[file].size(),
        .bytes = {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(kept)}});
  contents_[file].insert(contents_[file].end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(kept));
  return status;
}

Status CrashDisk::WriteAt(std::size_t file, std::uint64_t offset, std::span<const std::byte> bytes) {
  RETURN_IF_ERROR(Call("write at an offset", Need::kRoom));
  Put(contents_[file], offset, bytes);
  Keep({.op = Op::kWrite, .file = file, .offset = offset, .bytes = {bytes.begin(), bytes.end()}});
  return {};
}

Status CrashDisk::SyncFile(std::size_t file, const std::string& path) {
  const Status status = Call("sync " + path, Need::kWriting);
  Keep({.op = status ? Op::kSync : Op::kSyncFailed, .file = file});
  return status;
}

std::optional<std::size_t> CrashDisk::FileOf(const std::string& path) const {
  const auto found = names_.find(path);
  return found == names_.end() ? std::nullopt : std::optional(found->second);
}

void CrashDisk::Unlink(const std::string& path) {
  const std::size_t file = names_.at(path);
  names_.erase(path);
  Keep({.op = Op::kRemove, .file = file, .name = path});
  Keep({.op = Op::kSyncFolder});
}

Status CrashDisk::SyncFolder(const std::string& path) {
  RETURN_IF_ERROR(Call("sync folder of " + path, Need::kWriting));
  Keep({.op = Op::kSyncFolder});
  return {};
}

Result<std::vector<std::string>> CrashDisk::List(const std::string& folder) {
  RETURN_IF_ERROR(Call("list " + folder, Need::kNothing));
  std::vector<std::string> names;
  for (const auto& [path, file] : names_) {
    const std::string prefix = folder.empty() ? "" : folder + "/";
    if (path.starts_with(prefix)) names.push_back(path.substr(prefix.size()));
  }
  return names;
}

CrashDisk::Files CrashDisk::Live() const {
  Files files;
  for (const auto& [path, file] : names_) files[path] = contents_[file];
  return files;
}

CrashDisk::Files CrashDisk::AfterPowerCut(const PowerCut& cut) const {
  ENSURE(cut.entries <= journal_.size(), "a cut lies within the journal");
  std::vector<Replayed> replayed(contents_.size());
  for (std::size_t i = 0; i < cut.entries; ++i) {
    const Entry& entry = journal_[i];
    Replayed& file = replayed.empty() ? replayed.emplace_back() : replayed[entry.file];
    if (entry.op == Op::kWrite) file.Write(entry.offset, entry.bytes);
    if (entry.op == Op::kSync && IsOver(entry, cut)) file.Sync();
    if (entry.op == Op::kSyncFailed) file.FailSync();
  }
  if (cut.entries < journal_.size() && journal_[cut.entries].op == Op::kWrite) {
    const Entry& torn = journal_[cut.entries];
    const auto taken = std::min<std::uint64_t>(cut.torn_bytes, torn.bytes.size());
    replayed[torn.file].Write(torn.offset, std::span(torn.bytes).first(taken));
  }
  Dice dice(cut.seed);
  Files files;
  for (const auto& [path, file] : NamesAfter(std::span(journal_).first(cut.entries), dice)) {
    files[path] = Remains(replayed[file], stale_, cut, dice).Make();
  }
  return files;
}

}  // namespace annulus::test
