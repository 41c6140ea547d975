#include "tests/support/crash_disk.h"

#include <algorithm>
#include <utility>

#include "base/ensure.h"

namespace annulus::test {
namespace {

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
  std::vector<std::byte>& content = contents_[file];
  content.resize(std::max<std::size_t>(content.size(), offset + bytes.size()));
  std::copy(bytes.begin(), bytes.end(), content.begin() + static_cast<std::ptrdiff_t>(offset));
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

}  // namespace annulus::test
