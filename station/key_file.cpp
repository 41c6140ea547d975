#include "station/key_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "station/devices.h"

namespace annulus {
namespace {

constexpr std::size_t kMaxFileBytes = 65'536;

/// Keys in memory; wiped when they go.
class FileKeys final : public KeySource {
 public:
  explicit FileKeys(std::string path) : path_(std::move(path)) {}

  bool Add(const std::string& id, const SealKey& key) {
    newest_ = id;
    return keys_.emplace(id, key).second;
  }
  [[nodiscard]] bool empty() const { return keys_.empty(); }

  [[nodiscard]] Result<SealKey> Key(const std::string& id) const override {
    const auto found = keys_.find(id);
    if (found != keys_.end()) return found->second;
    return Fail("find the key '" + id + "'", path_ + " does not have it",
                "give the key file of the station that sealed it");
  }
  [[nodiscard]] Result<std::string> NewRecordingKeyId() const override { return newest_; }

 private:
  std::string path_;
  std::string newest_;
  std::map<std::string, SealKey> keys_;
};

std::string_view Trim(std::string_view text) {
  constexpr std::string_view kSpaces = " \t\r";
  const std::size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpaces) - begin + 1);
}

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::optional<SealKey> KeyFromHex(std::string_view text) {
  if (text.size() != 2 * SealKey::kBytes) return std::nullopt;
  SealKey key;
  for (std::size_t i = 0; i < SealKey::kBytes; ++i) {
    const int high = HexDigit(text[2 * i]);
    const int low = HexDigit(text[2 * i + 1]);
    if (high < 0 || low < 0) return std::nullopt;
    key.bytes[i] = static_cast<unsigned char>(16 * high + low);
  }
  return key;
}

bool IsId(std::string_view text) {
  return !text.empty() && text.size() <= KeySource::kMaxId &&
         text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.") ==
             std::string_view::npos;
}

/// The text of a file, wiped when it goes.
struct SecretText {
  std::string text;
  ~SecretText() { explicit_bzero(text.data(), text.size()); }
};

Status ReadSecret(const std::string& path, SecretText& secret) {
  const std::string attempted = "read the key file " + path;
  const auto fail = [&] {
    return Fail(attempted, std::generic_category().message(errno), "check the path and the file's permissions");
  };
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return fail();
  struct stat info {};
  ssize_t got = -1;
  if (::fstat(fd, &info) == 0) {
    secret.text.resize(kMaxFileBytes + 1);
    got = ::read(fd, secret.text.data(), secret.text.size());
  }
  const int error = errno;
  ::close(fd);
  errno = error;
  if (got < 0) return fail();
  if (!S_ISREG(info.st_mode) || static_cast<std::size_t>(got) > kMaxFileBytes) {
    return Fail(attempted, "it is no text file of at most 64 KiB", "give a file with lines ID = KEY");
  }
  if ((info.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    return Fail(attempted, "others than its owner may use it", "chmod 600 " + path);
  }
  secret.text.resize(static_cast<std::size_t>(got));
  return {};
}

}  // namespace

Result<std::unique_ptr<KeySource>> ReadKeyFile(const std::string& path) {
  const std::string attempted = "read the key file " + path;
  SecretText secret;
  RETURN_IF_ERROR(ReadSecret(path, secret));
  auto keys = std::make_unique<FileKeys>(path);
  std::string_view rest = secret.text;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = Trim(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.empty() || line.front() == '#') continue;
    const std::size_t equals = line.find('=');
    const std::string_view id = Trim(line.substr(0, equals));
    const auto key = equals == std::string_view::npos ? std::nullopt : KeyFromHex(Trim(line.substr(equals + 1)));
    const std::string where = "line " + std::to_string(number);  // never the line itself: it may be a key
    if (!key || !IsId(id)) return Fail(attempted, where + " is not ID = 64 hex digits", "correct this line");
    if (!keys->Add(std::string(id), *key)) return Fail(attempted, where + " repeats an id", "remove one of the two");
  }
  if (keys->empty()) return Fail(attempted, "it has no keys", "add a line ID = 64 hex digits");
  return keys;
}

Status CheckSealing(const Config& config, const std::string& key_file) {
  if (AllSimulated(config) || !key_file.empty()) return {};
  return Fail("record a person", "--key-file is missing: such recordings are sealed",
              "give a key file; docs/technician.md says how to make one");
}

Result<std::unique_ptr<KeySource>> OpenKeys(const std::string& path) {
  if (path.empty()) return std::unique_ptr<KeySource>();
  return ReadKeyFile(path);
}

}  // namespace annulus
