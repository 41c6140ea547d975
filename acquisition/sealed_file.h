#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// A key of XChaCha20-Poly1305; wiped when it goes.
struct SealKey {
  static constexpr std::size_t kBytes = 32;
  std::array<unsigned char, kBytes> bytes{};

  SealKey() = default;
  SealKey(const SealKey&) = default;
  SealKey& operator=(const SealKey&) = default;
  ~SealKey();
};

/// Where the keys of sealed recordings come from. Reentrant.
class KeySource {
 public:
  /// Longest id of a key, bytes.
  static constexpr std::size_t kMaxId = 32;

  virtual ~KeySource() = default;
  /// The key of this id; an Error if it is not known (destroyed with its customer, or of another station).
  [[nodiscard]] virtual Result<SealKey> Key(const std::string& id) const = 0;
  /// The id of the key for new recordings: 1 … kMaxId bytes.
  [[nodiscard]] virtual Result<std::string> NewRecordingKeyId() const = 0;
};

/// Tells sealed files apart: random, never used twice with one key.
using SealedFileId = std::array<unsigned char, 16>;
[[nodiscard]] SealedFileId RandomSealedFileId();

/// What a sealed file is sealed with.
struct Seal {
  std::string key_id;
  SealKey key;
  SealedFileId file_id{};
};

/// A file whose every Append becomes one frame that is encrypted and authenticated by itself (docs/formats.md), so that
/// damage costs that frame only; a frame cannot be changed, moved, repeated or taken from another file unnoticed. The
/// clear header, with the key's id, goes out with the first frame, in the same write.
class SealedFile final : public AppendFile {
 public:
  /// Takes a new, empty file.
  SealedFile(std::unique_ptr<AppendFile> file, Seal seal);
  Status Append(std::span<const std::byte> bytes) override;
  Status Sync() override { return file_->Sync(); }
  Status Reserve(std::uint64_t bytes) override { return file_->Reserve(bytes); }
  Status Close() override { return file_->Close(); }

 private:
  std::unique_ptr<AppendFile> file_;
  Seal seal_;
  std::uint64_t sequence_ = 0;
};

/// What was under the seal.
struct Unsealed {
  std::vector<std::byte> bytes;  ///< The frames that were found, one after the other.
  std::string key_id;
  SealedFileId file_id{};
  bool first_frame = false;          ///< The first frame is among them.
  std::uint64_t frames = 0;          ///< Found.
  std::uint64_t frames_lost = 0;     ///< Known from gaps in their numbers.
  std::uint64_t skipped_bytes = 0;   ///< Of the file, between frames or behind the last: no genuine frame.
  std::vector<std::uint64_t> sizes;  ///< Of each frame found, bytes.
  std::vector<std::string> notes;    ///< One line per damage, with its place; at most kMaxNotes.
  static constexpr std::size_t kMaxNotes = 100;
};

/// True if `bytes` begin as every sealed file does; one damaged byte is put up with.
[[nodiscard]] bool LooksSealed(std::span<const std::byte> bytes);

/// The id of the key that a sealed file asks for.
Result<std::string> SealedKeyId(std::span<const std::byte> bytes, const std::string& name);

/// Opens a sealed file in memory; damaged frames are left out. Fails if it is none, if both copies of the header are
/// damaged, if the key is not known, or if it opens not one frame. `name` is what messages call it.
Result<Unsealed> Unseal(std::span<const std::byte> bytes, const KeySource& keys, const std::string& name);

/// The same for a recording: if its first frame is lost, the bytes with which every recording begins stand for it.
/// Fails with a message of its own if `keys` is null.
Result<Unsealed> UnsealRecording(std::span<const std::byte> bytes, const std::string& name, const KeySource* keys);

}  // namespace annulus
