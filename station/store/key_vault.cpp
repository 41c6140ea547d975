#include "station/store/key_vault.h"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "station/store/sealed_text.h"

namespace annulus {
namespace {

constexpr std::uint64_t kMaxKeyFileBytes = 4096;
constexpr std::string_view kFirstStationKey = "station-1";

class OpenFile {
 public:
  explicit OpenFile(int fd) : fd_(fd) {}
  ~OpenFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

std::string ErrnoText() { return std::generic_category().message(errno); }

/// Zeros over the whole of an open file, on the disk when it returns.
Status Overwrite(int fd, const std::string& path) {
  struct stat info {};
  if (::fstat(fd, &info) != 0) return Fail("overwrite " + path, ErrnoText(), "check the disk");
  const std::string zeros(static_cast<std::size_t>(info.st_size), '\0');
  for (std::size_t at = 0; at < zeros.size();) {
    const ssize_t written = ::pwrite(fd, zeros.data() + at, zeros.size() - at, static_cast<off_t>(at));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return Fail("overwrite " + path, ErrnoText(), "check the disk");
    at += static_cast<std::size_t>(written);
  }
  if (::fsync(fd) != 0) return Fail("overwrite " + path, ErrnoText(), "check the disk");
  return {};
}

std::string WrapContext(const std::string& id) { return SealContext({"customer key", id}); }

/// A customer's id is a file's name here: letters, digits and '-'.
bool IsPlainId(std::string_view id) {
  return !id.empty() && id.size() <= KeySource::kMaxId &&
         id.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-") ==
             std::string_view::npos;
}

}  // namespace

Status MakeStationKeyFile(const std::string& path) {
  const std::string attempted = "make the key file " + path;
  const OpenFile file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (file.get() < 0) return Fail(attempted, ErrnoText(), "check the path and the folder's permissions");
  const SealKey key = RandomSealKey();
  std::string line = std::string(kFirstStationKey) + " = " + HexOf(std::as_bytes(std::span(key.bytes))) + "\n";
  const ssize_t written = ::write(file.get(), line.data(), line.size());
  const bool whole = std::cmp_equal(written, line.size()) && ::fsync(file.get()) == 0;
  Wipe(line);
  if (!whole) {
    const std::string seen = ErrnoText();
    ::unlink(path.c_str());
    return Fail(attempted, seen, "check the disk");
  }
  return PosixStorage().SyncFolder(path);
}

Status DestroySecretFile(Storage& storage, const std::string& path) {
  if (!storage.Exists(path)) return {};
  {
    const OpenFile file(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW));
    if (file.get() >= 0) RETURN_IF_ERROR(Overwrite(file.get(), path));
  }
  RETURN_IF_ERROR(storage.Remove(path));
  return storage.SyncFolder(path);
}

Status ReplaceSecretFile(Storage& storage, const std::string& path, const std::string& text) {
  const OpenFile old(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW));
  RETURN_IF_ERROR(WriteFileAtomically(storage, path, text));
  if (old.get() >= 0) return Overwrite(old.get(), path);
  return {};
}

std::string WrappedKey::Line() const { return id + " = " + station_key_id + " " + HexOf(sealed) + "\n"; }

std::optional<WrappedKey> WrappedKey::Parse(std::string_view line) {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
  const std::size_t equals = line.find(" = ");
  if (equals == std::string_view::npos) return std::nullopt;
  const std::string_view rest = line.substr(equals + 3);
  const std::size_t space = rest.find(' ');
  if (space == std::string_view::npos) return std::nullopt;
  WrappedKey wrapped;
  wrapped.id = std::string(line.substr(0, equals));
  wrapped.station_key_id = std::string(rest.substr(0, space));
  wrapped.sealed = BytesOfHex(rest.substr(space + 1));
  if (!IsPlainId(wrapped.id) || wrapped.station_key_id.empty() || wrapped.sealed.empty()) return std::nullopt;
  return wrapped;
}

KeyVault::KeyVault(std::string folder, std::unique_ptr<KeySource> station, Storage& storage)
    : folder_(std::move(folder)), station_(std::move(station)), storage_(storage) {}

KeyVault::~KeyVault() = default;

Result<SealKey> KeyVault::MakeKey(const std::string& id) {
  const auto station_id = station_->NewRecordingKeyId();
  if (!station_id) return Fail(station_id);
  const auto station = station_->Key(*station_id);
  if (!station) return Fail(station);
  const SealKey key = RandomSealKey();
  const WrappedKey wrapped{id, *station_id, SealBytes(*station, std::as_bytes(std::span(key.bytes)), WrapContext(id))};
  RETURN_IF_ERROR(WriteFileAtomically(storage_, PathOf(id), wrapped.Line()));
  opened_.insert_or_assign(id, key);
  return key;
}

Result<SealKey> KeyVault::Unwrap(const WrappedKey& wrapped) const {
  const auto station = station_->Key(wrapped.station_key_id);
  if (!station) return Fail(station);
  auto plain = OpenBytes(*station, wrapped.sealed, WrapContext(wrapped.id), "the key of " + wrapped.id);
  if (!plain) return Fail(plain);
  if (plain->size() != SealKey::kBytes) {
    return Fail("open the key of " + wrapped.id, "it has another length", "restore the last backup");
  }
  SealKey key;
  std::copy_n(reinterpret_cast<const unsigned char*>(plain->data()), key.bytes.size(), key.bytes.begin());
  sodium_memzero(plain->data(), plain->size());
  return key;
}

Result<WrappedKey> KeyVault::Wrapped(const std::string& id) const {
  const std::string attempted = "read the key of " + id;
  if (!IsPlainId(id) || !storage_.Exists(PathOf(id))) {
    return Fail(attempted, "it is not there", "the customer was erased, or the keys' backup was not restored");
  }
  const auto bytes = storage_.ReadAll(PathOf(id), kMaxKeyFileBytes);
  if (!bytes) return Fail(bytes);
  auto wrapped = WrappedKey::Parse({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
  if (!wrapped || wrapped->id != id) return Fail(attempted, "its file is damaged", "restore the last backup");
  return std::move(*wrapped);
}

Result<SealKey> KeyVault::Key(const std::string& id) const {
  if (const auto found = opened_.find(id); found != opened_.end()) return found->second;
  const auto wrapped = Wrapped(id);
  if (!wrapped) return Fail(wrapped);
  auto key = Unwrap(*wrapped);
  if (key) opened_.insert_or_assign(id, *key);
  return key;
}

Result<std::string> KeyVault::NewRecordingKeyId() const {
  return Fail("choose a customer's key", "it is not known whose recording it will be", "record with the station's key");
}

bool KeyVault::Has(const std::string& id) const { return IsPlainId(id) && storage_.Exists(PathOf(id)); }

Status KeyVault::Destroy(const std::string& id) {
  opened_.erase(id);
  return DestroySecretFile(storage_, PathOf(id));
}

Result<std::vector<std::string>> KeyVault::Ids() const {
  auto names = storage_.List(folder_);
  if (!names) return Fail(names);
  std::erase_if(*names, [](const std::string& name) { return !IsPlainId(name); });  // what a crash left half written
  return names;
}

Status KeyVault::RemoveAbandoned() {
  const auto names = storage_.List(folder_);
  if (!names) return Fail(names);
  for (const std::string& name : *names) {
    if (!IsPlainId(name)) RETURN_IF_ERROR(DestroySecretFile(storage_, folder_ + "/" + name));
  }
  return {};
}

Status KeyVault::Adopt(const WrappedKey& wrapped) {
  const auto key = Unwrap(wrapped);
  if (!key) return Fail(key);
  return WriteFileAtomically(storage_, PathOf(wrapped.id), wrapped.Line());
}

void KeyVault::Forget() { opened_.clear(); }

Result<std::vector<std::byte>> KeyVault::SealForStation(std::string_view plain, std::string_view context) const {
  const auto id = station_->NewRecordingKeyId();
  if (!id) return Fail(id);
  const auto key = station_->Key(*id);
  if (!key) return Fail(key);
  std::vector<std::byte> sealed{static_cast<std::byte>(id->size())};
  const auto name = BytesOf(*id);
  sealed.insert(sealed.end(), name.begin(), name.end());
  const auto rest = SealText(*key, plain, context);
  sealed.insert(sealed.end(), rest.begin(), rest.end());
  return sealed;
}

Result<std::string> KeyVault::OpenForStation(std::span<const std::byte> sealed, std::string_view context,
                                             const std::string& name) const {
  const std::size_t length = sealed.empty() ? 0 : std::to_integer<std::size_t>(sealed[0]);
  if (sealed.size() < 1 + length) return Fail("open " + name, "it is damaged", "restore the last backup");
  const std::string id(reinterpret_cast<const char*>(sealed.data()) + 1, length);
  const auto key = station_->Key(id);
  if (!key) return Fail(key);
  return OpenText(*key, sealed.subspan(1 + length), context, name);
}

}  // namespace annulus
