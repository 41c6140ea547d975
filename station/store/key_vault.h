#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/sealed_file.h"
#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// Makes a station's key file (docs/formats.md) of mode 0600 with one new random key, "station-1". Fails if there is a
/// file already.
Status MakeStationKeyFile(const std::string& path);

/// Writes zeros over a file that holds a secret, removes it, and syncs its folder. (An SSD may keep remnants:
/// docs/store.md.) Nothing to do if it is not there.
Status DestroySecretFile(Storage& storage, const std::string& path);
/// The same, but a new file takes its place: `bytes` is all that is left.
Status ReplaceSecretFile(Storage& storage, const std::string& path, const std::string& text);

/// One customer's key, wrapped (sealed) by the station's: `CUSTOMER = STATION_KEY_ID HEX`, a line of key files.
struct WrappedKey {
  std::string id;  ///< Of the customer.
  std::string station_key_id;
  std::vector<std::byte> sealed;

  [[nodiscard]] std::string Line() const;
  [[nodiscard]] static std::optional<WrappedKey> Parse(std::string_view line);
};

/// The customers' keys: a small file each in a folder, apart from the database, so that copies of the database open
/// nothing. A KeySource for their recordings, by the customer's id. Thread-bound.
class KeyVault final : public KeySource {
 public:
  /// `station` wraps: new keys and secrets with its newest key, old ones open with the one that they name.
  KeyVault(std::string folder, std::unique_ptr<KeySource> station, Storage& storage);
  ~KeyVault() override;

  /// A new key for a customer, on the disk when it returns; one that is there is replaced.
  Result<SealKey> MakeKey(const std::string& id);
  [[nodiscard]] Result<SealKey> Key(const std::string& id) const override;
  /// Fails: which customer a recording is of is not known before it is taken into the store.
  [[nodiscard]] Result<std::string> NewRecordingKeyId() const override;
  [[nodiscard]] bool Has(const std::string& id) const;
  /// Destroys a customer's key; success if there is none.
  Status Destroy(const std::string& id);
  /// Customers that have a key, sorted.
  [[nodiscard]] Result<std::vector<std::string>> Ids() const;
  /// Removes what a process that is gone has left half written.
  Status RemoveAbandoned();
  [[nodiscard]] Result<WrappedKey> Wrapped(const std::string& id) const;
  /// Takes a wrapped key of a backup, if the station's key opens it.
  Status Adopt(const WrappedKey& wrapped);
  /// Drops opened keys from memory.
  void Forget();

  /// Sealed with the station's newest key, whose id goes in front.
  Result<std::vector<std::byte>> SealForStation(std::string_view plain, std::string_view context) const;
  Result<std::string> OpenForStation(std::span<const std::byte> sealed, std::string_view context,
                                     const std::string& name) const;

 private:
  [[nodiscard]] std::string PathOf(const std::string& id) const { return folder_ + "/" + id; }
  [[nodiscard]] Result<SealKey> Unwrap(const WrappedKey& wrapped) const;

  std::string folder_;
  std::unique_ptr<KeySource> station_;
  Storage& storage_;
  mutable std::map<std::string, SealKey> opened_;
};

}  // namespace annulus
