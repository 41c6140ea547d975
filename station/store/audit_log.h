#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "base/storage.h"
#include "station/store/database.h"
#include "station/store/key_vault.h"
#include "station/store/store_types.h"

namespace annulus {

/// SHA-256 over the hash of the line before (64 zeros before the first) and the line's own fields, each as
/// LENGTH ':' TEXT, in the order number, time_ms, monotonic_ns, user, origin, action, subject, result: 64 hex digits.
[[nodiscard]] std::string AuditHash(const std::string& before, const AuditLine& line);

/// The audit: lines that each carry the hash of all before. Triggers of the database refuse changes; what goes around
/// them is found by Verify. Lines cut off at the end are missed by the head, which is sealed with the station's key;
/// who has that key too is found out by an anchor that was printed or carried away (ANCHORS file: date, number and hash
/// of the last line before the first of that day, UTC). Thread-bound; borrows all.
class AuditLog {
 public:
  AuditLog(Database& database, const KeyVault& vault, std::string anchors_path, Storage& storage)
      : database_(database), vault_(vault), anchors_path_(std::move(anchors_path)), storage_(storage) {}

  /// Appends within the caller's transaction; number and hash are given here. Texts longer than 1,000 bytes are cut.
  Status Append(AuditLine line);
  /// Once a line is on the disk: writes the anchor of its day if there is none. True if it did.
  Result<bool> KeepAnchor();
  /// In their order; from 0: the last ones.
  Result<std::vector<AuditLine>> Lines(std::uint64_t from_number, std::size_t limit);
  /// The last hash; the Error names the first line that does not fit.
  Result<std::string> Verify();

 private:
  struct Head {
    std::uint64_t number = 0;
    std::string hash;
  };
  Result<Head> LastLine();
  Status VerifyHead(const Head& last);
  Status VerifyAnchors();

  Database& database_;
  const KeyVault& vault_;
  std::string anchors_path_;
  Storage& storage_;
  std::string anchored_day_;  ///< Newest day that is known to have its anchor.
};

}  // namespace annulus
