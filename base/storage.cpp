#include "base/storage.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace annulus {
namespace {

/// What a user can do about an errno of the file system.
std::string AdviceFor(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "free space on this disk or choose another";
    case EFBIG:
      return "raise the file-size limit or choose another disk";
    case EROFS:
      return "this disk is read-only: choose another";
    case EACCES:
    case EPERM:
      return "check the permissions of the file and its folder";
    case ENOENT:
      return "check the path";
    case ENOTDIR:
    case EISDIR:
      return "give the path of a file";
    case EEXIST:
      return "choose another name or remove it first";
    default:
      return "check the disk and the path";
  }
}

tl::unexpected<Error> FailErrno(const std::string& attempted, int error) {
  return Fail(attempted, std::generic_category().message(error), AdviceFor(error));
}

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  [[nodiscard]] int get() const { return fd_; }
  int Release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

class PosixAppendFile final : public AppendFile {
 public:
  PosixAppendFile(int fd, std::string path) : fd_(fd), path_(std::move(path)) {}

  Status Append(std::span<const std::byte> bytes) override {
    while (!bytes.empty()) {
      const ssize_t written = ::write(fd_.get(), bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return FailErrno("write " + path_, errno);
      if (written == 0) return FailErrno("write " + path_, ENOSPC);
      bytes = bytes.subspan(static_cast<std::size_t>(written));
      written_ += static_cast<std::uint64_t>(written);
    }
    return {};
  }

  Status Sync() override {
    if (bad_) return Fail("sync " + path_, "an earlier sync of this file failed", "write it again to a sound disk");
    if (::fdatasync(fd_.get()) == 0 || errno == EINVAL) return {};  // EINVAL: a pipe or /dev/stdout
    bad_ = true;
    return FailErrno("sync " + path_, errno);
  }

  Status Reserve(std::uint64_t bytes) override {
    const auto start = static_cast<off_t>(written_);
    if (::fallocate(fd_.get(), FALLOC_FL_KEEP_SIZE, start, static_cast<off_t>(bytes)) == 0) return {};
    if (errno == EOPNOTSUPP || errno == ENOSYS) return {};  // the file system cannot: writing will tell
    return FailErrno("reserve " + std::to_string(bytes) + " bytes for " + path_, errno);
  }

  Status Close() override {
    if (::close(fd_.Release()) == 0) return {};
    return FailErrno("close " + path_, errno);
  }

 private:
  FileDescriptor fd_;
  std::string path_;
  std::uint64_t written_ = 0;
  bool bad_ = false;
};

Status SyncFolderOf(const std::string& path) {
  std::string folder = std::filesystem::path(path).parent_path().string();
  if (folder.empty()) folder = ".";
  const FileDescriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (fd.get() < 0) return FailErrno("open folder " + folder, errno);
  if (::fsync(fd.get()) != 0 && errno != EINVAL) return FailErrno("sync folder " + folder, errno);
  return {};
}

}  // namespace

Result<std::unique_ptr<AppendFile>> PosixStorage::Create(const std::string& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (fd < 0) return FailErrno("create " + path, errno);
  (void)::flock(fd, LOCK_EX | LOCK_NB);  // only so that InUse can tell; some file systems have no locks
  return std::make_unique<PosixAppendFile>(fd, path);
}

Result<std::vector<std::byte>> PosixStorage::ReadAll(const std::string& path, std::uint64_t max_bytes) {
  const std::string attempted = "read " + path;
  const FileDescriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0) return FailErrno(attempted, errno);
  struct stat info {};
  if (::fstat(fd.get(), &info) != 0) return FailErrno(attempted, errno);
  if (S_ISDIR(info.st_mode)) return FailErrno(attempted, EISDIR);
  std::vector<std::byte> bytes;
  if (S_ISREG(info.st_mode)) bytes.reserve(std::min(static_cast<std::uint64_t>(info.st_size), max_bytes) + 1);
  std::vector<std::byte> block(std::size_t{1} << 18);
  while (true) {
    const ssize_t got = ::read(fd.get(), block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return FailErrno(attempted, errno);
    if (got == 0) return bytes;
    if (bytes.size() + static_cast<std::size_t>(got) > max_bytes) {
      return Fail(attempted, "it is larger than " + std::to_string(max_bytes) + " bytes", "give a smaller file");
    }
    bytes.insert(bytes.end(), block.begin(), block.begin() + got);
  }
}

Status PosixStorage::Rename(const std::string& from, const std::string& to) {
  struct stat info {};
  if (::stat(to.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode)) {
    return Fail("replace " + to, "it is a device or a pipe", "choose the name of a file");
  }
  if (::rename(from.c_str(), to.c_str()) != 0) return FailErrno("rename " + from + " to " + to, errno);
  return SyncFolderOf(to);
}

Status PosixStorage::Remove(const std::string& path) {
  if (::unlink(path.c_str()) != 0) return FailErrno("remove " + path, errno);
  return {};
}

bool PosixStorage::Exists(const std::string& path) const {
  struct stat info {};
  return ::stat(path.c_str(), &info) == 0;
}

std::string PosixStorage::Resolve(const std::string& path) const {
  std::error_code error;
  if (!std::filesystem::is_symlink(path, error)) return path;
  const std::filesystem::path target = std::filesystem::weakly_canonical(path, error);
  return error ? path : target.string();
}

Result<std::unique_ptr<AppendFile>> PosixStorage::OpenDevice(const std::string& path) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0 || S_ISREG(info.st_mode) || S_ISDIR(info.st_mode)) {
    return std::unique_ptr<AppendFile>();
  }
  // Not waiting for a pipe's reader, but for room once there is one.
  const int fd = ::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (fd < 0) return FailErrno("open " + path, errno);
  ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) & ~O_NONBLOCK);
  return std::make_unique<PosixAppendFile>(fd, path);
}

Status PosixStorage::CreateFolder(const std::string& path) {
  std::error_code error;
  std::vector<std::string> missing;
  for (std::filesystem::path at(path); !at.empty() && !std::filesystem::exists(at, error); at = at.parent_path()) {
    missing.push_back(at.string());
  }
  std::filesystem::create_directories(path, error);
  if (error) return FailErrno("create folder " + path, error.value());
  // A recording is as durable as the names of all folders that it lies in.
  for (auto made = missing.rbegin(); made != missing.rend(); ++made) RETURN_IF_ERROR(SyncFolderOf(*made));
  return {};
}

Result<std::uint64_t> PosixStorage::FreeBytes(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error) return FailErrno("ask how much room is left for " + path, error.value());
  return space.available;
}

Status PosixStorage::SyncFolder(const std::string& path) { return SyncFolderOf(path); }

Result<std::vector<std::string>> PosixStorage::List(const std::string& folder) {
  std::error_code error;
  std::filesystem::directory_iterator entry(folder.empty() ? "." : folder, error);
  std::vector<std::string> names;
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    std::error_code unreadable;
    if (entry->is_regular_file(unreadable)) names.push_back(entry->path().filename().string());
  }
  if (error) return FailErrno("list folder " + folder, error.value());
  std::sort(names.begin(), names.end());
  return names;
}

bool PosixStorage::InUse(const std::string& path) const {
  const FileDescriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  return fd.get() >= 0 && ::flock(fd.get(), LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

std::string TemporaryName(const std::string& path) { return path + ".part-" + std::to_string(::getpid()); }

namespace {

Status WriteToDevice(AppendFile& device, std::span<const std::byte> bytes) {
  RETURN_IF_ERROR(device.Append(bytes));
  return device.Close();
}

}  // namespace

Status WriteFileAtomically(Storage& storage, const std::string& name, std::span<const std::byte> bytes) {
  const std::string path = storage.Resolve(name);
  auto device = storage.OpenDevice(path);
  if (!device) return Fail(device);
  if (*device != nullptr) return WriteToDevice(**device, bytes);
  const std::string temporary = TemporaryName(path);
  auto write = [&]() -> Status {
    auto file = storage.Create(temporary);
    if (!file) return Fail(file);
    if (auto status = (*file)->Append(bytes); !status) return status;
    if (auto status = (*file)->Sync(); !status) return status;
    if (auto status = (*file)->Close(); !status) return status;
    return storage.Rename(temporary, path);
  };
  Status status = write();
  if (!status && storage.Exists(temporary)) (void)storage.Remove(temporary);
  if (!status) status.error().attempted = "write " + path;
  return status;
}

Status WriteFileAtomically(Storage& storage, const std::string& path, const std::string& text) {
  return WriteFileAtomically(storage, path, std::as_bytes(std::span(text.data(), text.size())));
}

Result<std::string> ReadTextFile(Storage& storage, const std::string& path) {
  auto bytes = storage.ReadAll(path, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

}  // namespace annulus
