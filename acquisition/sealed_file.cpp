#include "acquisition/sealed_file.h"

#include <sodium.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "acquisition/mcap_bytes.h"
#include "base/ensure.h"

namespace annulus {
namespace {

// file   = header header frame*
// header = magic version(u32) key id(32, zeros behind it) file id(16) crc(u32)                         64 bytes
// frame  = magic length(u32) sequence(u64) ciphertext(length) tag(16)
constexpr std::string_view kHeaderMagic{
    "\x89"
    "ANSEAL\n",
    8};
constexpr std::string_view kFrameMagic{"\xF7\x5E\xA1\x3D", 4};
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHeaderBytes = 64;
constexpr std::size_t kFrameHeaderBytes = 16;
constexpr std::size_t kTagBytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;
constexpr std::uint32_t kMaxFrameBytes = 64U << 20U;

std::uint32_t CrcOf(std::string_view text) { return McapCrc(0, std::as_bytes(std::span(text.data(), text.size()))); }

const unsigned char* Octets(std::string_view text) { return reinterpret_cast<const unsigned char*>(text.data()); }

/// 24 bytes: file id, then sequence. Never twice with one key, as no two files share an id.
std::array<unsigned char, crypto_aead_xchacha20poly1305_ietf_NPUBBYTES> NonceOf(const SealedFileId& file_id,
                                                                                std::uint64_t sequence) {
  std::array<unsigned char, crypto_aead_xchacha20poly1305_ietf_NPUBBYTES> nonce{};
  static_assert(sizeof nonce == sizeof file_id + sizeof sequence);
  std::copy(file_id.begin(), file_id.end(), nonce.begin());
  std::memcpy(&nonce[file_id.size()], &sequence, sizeof sequence);
  return nonce;
}

/// What the tag covers besides the text: version, length, sequence, file id.
std::string AdditionalData(const SealedFileId& file_id, std::uint64_t sequence, std::uint32_t length) {
  McapBytes data;
  data.Put(kVersion);
  data.Put(length);
  data.Put(sequence);
  data.PutRaw({reinterpret_cast<const char*>(file_id.data()), file_id.size()});
  return data.bytes();
}

std::string HeaderBytes(const Seal& seal) {
  McapBytes header;
  header.PutRaw(kHeaderMagic);
  header.Put(kVersion);
  std::string id = seal.key_id;
  id.resize(KeySource::kMaxId, '\0');
  header.PutRaw(id);
  header.PutRaw({reinterpret_cast<const char*>(seal.file_id.data()), seal.file_id.size()});
  header.Put(CrcOf(header.bytes()));
  return header.bytes();
}

struct ClearHeader {
  std::uint32_t version = 0;
  std::string key_id;
  SealedFileId file_id{};
};

/// One copy of the header, if its CRC is right.
std::optional<ClearHeader> HeaderAt(std::string_view file, std::size_t offset) {
  if (file.size() < offset + kHeaderBytes) return std::nullopt;
  const std::string_view bytes = file.substr(offset, kHeaderBytes);
  McapCursor cursor(bytes);
  const auto magic = cursor.TakeRaw(kHeaderMagic.size());
  const auto version = cursor.Take<std::uint32_t>();
  const auto id = cursor.TakeRaw(KeySource::kMaxId);
  const auto file_id = cursor.TakeRaw(sizeof(SealedFileId));
  const auto crc = cursor.Take<std::uint32_t>();
  if (!magic || !version || !id || !file_id || !crc) return std::nullopt;
  if (*magic != kHeaderMagic || CrcOf(bytes.substr(0, kHeaderBytes - sizeof *crc)) != *crc) return std::nullopt;
  ClearHeader header;
  header.version = *version;
  header.key_id = std::string(id->substr(0, std::min(id->find('\0'), id->size())));
  std::copy(file_id->begin(), file_id->end(), header.file_id.begin());
  return header;
}

Result<ClearHeader> FindHeader(std::string_view file, const std::string& name) {
  const std::string attempted = "open " + name;
  auto header = HeaderAt(file, 0);
  if (!header) header = HeaderAt(file, kHeaderBytes);
  if (!header) {
    return Fail(attempted, "both copies of the header of the sealed file are damaged", "take another copy of the file");
  }
  if (header->version != kVersion) {
    return Fail(attempted, "it is sealed by version " + std::to_string(header->version) + " of the format, not 1",
                "take a newer version of the program");
  }
  return *header;
}

/// One pass over the frames of a file.
class UnsealPass {
 public:
  UnsealPass(std::string_view file, const ClearHeader& header, const SealKey& key)
      : file_(file), header_(header), key_(key), budget_(kBudgetPerByte * file.size()) {}

  Unsealed Run() {
    out_.key_id = header_.key_id;
    out_.file_id = header_.file_id;
    if (!HeaderAt(file_, 0) || !HeaderAt(file_, kHeaderBytes)) Note(0, "a copy of the sealed file's header is damaged");
    std::size_t at = 2 * kHeaderBytes;
    while (at < file_.size()) {
      if (const auto length = Open(at)) {
        at += *length;
        continue;
      }
      std::size_t found = Search(at + 1);
      std::optional<std::size_t> length;
      while (found < file_.size() && !(length = Open(found))) found = Search(found + 1);
      Note(at, found == file_.size() ? "the file ends within a sealed frame, or damaged"
                                     : "a sealed frame is damaged; skipped " + std::to_string(found - at) + " bytes");
      out_.skipped_bytes += found - at;
      at = found + length.value_or(0);
    }
    return std::move(out_);
  }

 private:
  /// A search may try so many bytes per byte of the file: many false starts do not make it quadratic.
  static constexpr std::uint64_t kBudgetPerByte = 16;

  void Note(std::size_t at, const std::string& what) {
    if (out_.notes.size() < Unsealed::kMaxNotes) {
      out_.notes.push_back("at byte " + std::to_string(at) + " of the sealed file: " + what);
    }
  }

  /// The frame at `at`: its text is appended and its length returned; nothing if it is not whole and genuine.
  std::optional<std::size_t> Open(std::size_t at) {
    McapCursor cursor(file_.substr(at));
    const auto magic = cursor.TakeRaw(kFrameMagic.size());
    const auto length = cursor.Take<std::uint32_t>();
    const auto sequence = cursor.Take<std::uint64_t>();
    if (!magic || *magic != kFrameMagic || !length || !sequence || *length > kMaxFrameBytes) return std::nullopt;
    const auto sealed = cursor.TakeRaw(*length + kTagBytes);
    if (!sealed || *sequence < next_ || sealed->size() > budget_) return std::nullopt;
    budget_ -= sealed->size();
    const std::string data = AdditionalData(header_.file_id, *sequence, *length);
    const auto nonce = NonceOf(header_.file_id, *sequence);
    const std::size_t before = out_.bytes.size();
    out_.bytes.resize(before + *length);
    unsigned long long opened = 0;
    if (crypto_aead_xchacha20poly1305_ietf_decrypt(reinterpret_cast<unsigned char*>(out_.bytes.data()) + before,
                                                   &opened, nullptr, Octets(*sealed), sealed->size(), Octets(data),
                                                   data.size(), nonce.data(), key_.bytes.data()) != 0) {
      out_.bytes.resize(before);
      return std::nullopt;
    }
    if (*sequence == 0) out_.first_frame = true;
    ++out_.frames;
    out_.frames_lost += *sequence - next_;
    out_.sizes.push_back(*length);
    next_ = *sequence + 1;
    return kFrameHeaderBytes + sealed->size();
  }

  /// The next place after `begin` at which a genuine frame may start; the file's end if there is none.
  [[nodiscard]] std::size_t Search(std::size_t begin) const {
    const std::size_t found = file_.find(kFrameMagic, begin);
    return found == std::string_view::npos ? file_.size() : found;
  }

  std::string_view file_;
  const ClearHeader& header_;
  const SealKey& key_;
  std::uint64_t budget_;
  std::uint64_t next_ = 0;  ///< Least sequence that may come.
  Unsealed out_;
};

std::string_view TextOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

SealKey::~SealKey() { sodium_memzero(bytes.data(), bytes.size()); }

SealedFileId RandomSealedFileId() {
  ENSURE(sodium_init() >= 0, "libsodium starts");
  SealedFileId id;
  randombytes_buf(id.data(), id.size());
  return id;
}

SealedFile::SealedFile(std::unique_ptr<AppendFile> file, Seal seal) : file_(std::move(file)), seal_(std::move(seal)) {
  ENSURE(file_ != nullptr, "a sealed file is written to a file");
  ENSURE(!seal_.key_id.empty() && seal_.key_id.size() <= KeySource::kMaxId, "a key's id fits the header");
  ENSURE(sodium_init() >= 0, "libsodium starts");
}

Status SealedFile::Append(std::span<const std::byte> bytes) {
  ENSURE(bytes.size() <= kMaxFrameBytes, "a frame has at most 64 MiB");
  const auto length = static_cast<std::uint32_t>(bytes.size());
  McapBytes out;
  if (sequence_ == 0) {
    const std::string header = HeaderBytes(seal_);
    out.PutRaw(header);
    out.PutRaw(header);
  }
  out.PutRaw(kFrameMagic);
  out.Put(length);
  out.Put(sequence_);
  std::string sealed(bytes.size() + kTagBytes, '\0');
  const std::string data = AdditionalData(seal_.file_id, sequence_, length);
  const auto nonce = NonceOf(seal_.file_id, sequence_);
  unsigned long long written = 0;
  crypto_aead_xchacha20poly1305_ietf_encrypt(reinterpret_cast<unsigned char*>(sealed.data()), &written,
                                             Octets(TextOf(bytes)), bytes.size(), Octets(data), data.size(), nullptr,
                                             nonce.data(), seal_.key.bytes.data());
  ++sequence_;  // also if the write fails: a number is never used for two texts
  out.PutRaw(sealed);
  return file_->Append(std::as_bytes(std::span(out.bytes().data(), out.size())));
}

bool LooksSealed(std::span<const std::byte> bytes) {
  const std::string_view file = TextOf(bytes);
  std::size_t right = 0;
  for (std::size_t i = 0; i < std::min(file.size(), kHeaderMagic.size()); ++i) {
    if (file[i] == kHeaderMagic[i]) ++right;
  }
  return right + 1 >= kHeaderMagic.size();
}

Result<std::string> SealedKeyId(std::span<const std::byte> bytes, const std::string& name) {
  const auto header = FindHeader(TextOf(bytes), name);
  if (!header) return Fail(header);
  return header->key_id;
}

Result<Unsealed> Unseal(std::span<const std::byte> bytes, const KeySource& keys, const std::string& name) {
  ENSURE(sodium_init() >= 0, "libsodium starts");
  const std::string attempted = "open " + name;
  if (!LooksSealed(bytes)) return Fail(attempted, "it is not sealed", "give a sealed recording");
  const auto header = FindHeader(TextOf(bytes), name);
  if (!header) return Fail(header);
  const auto key = keys.Key(header->key_id);
  if (!key) return Fail(key);
  Unsealed unsealed = UnsealPass(TextOf(bytes), *header, *key).Run();
  if (unsealed.frames == 0) {
    return Fail(attempted, "the key '" + header->key_id + "' opens nothing of it",
                "give the key that it was sealed with; or it is damaged from its start on");
  }
  return unsealed;
}

Result<Unsealed> UnsealRecording(std::span<const std::byte> bytes, const std::string& name, const KeySource* keys) {
  if (keys == nullptr) {
    const auto id = SealedKeyId(bytes, name);
    if (!id) return Fail(id);
    return Fail("open " + name, "it is sealed with the key '" + *id + "'", "give its key with --key-file");
  }
  auto unsealed = Unseal(bytes, *keys, name);
  if (unsealed && !unsealed->first_frame) {
    const auto magic = std::as_bytes(std::span(kMcapMagic.data(), kMcapMagic.size()));
    unsealed->bytes.insert(unsealed->bytes.begin(), magic.begin(), magic.end());
  }
  return unsealed;
}

}  // namespace annulus
