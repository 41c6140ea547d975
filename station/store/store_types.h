#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace annulus {

/// Time of a row: UTC, ms since 1970.
using StoreTime = std::chrono::milliseconds;

/// Who somebody is to the station. Deny by default: none may log in, stop the booth, and nothing else.
enum class StationRole { kNone, kOperator, kTechnician, kAdmin };
/// "none", "operator", "technician", "admin".
[[nodiscard]] std::string_view StationRoleName(StationRole role);
[[nodiscard]] std::optional<StationRole> ParseStationRole(std::string_view name);

/// A customer. `id` is a pseudonym ("K-000042"), the only part that may be written down outside of the sealed part.
struct Customer {
  std::string id;
  std::string name;
  std::string contact;  ///< E-mail or telephone, may be empty.
  std::string note;     ///< May be empty.
  std::optional<int> height_mm;
  std::optional<std::string> prescription_json;  ///< RX.json (docs/formats.md).
  StoreTime created{0};
  StoreTime keep_until{0};  ///< Deleted then, unless somebody keeps them longer.
};

/// What a customer has agreed to, bound to the scans that it covers.
struct Consent {
  std::string id;  ///< "C-000017".
  std::string customer_id;
  std::vector<std::string> purposes;  ///< "measure", "glasses", "reshape", "research".
  std::string text_version;           ///< Of the wording that was shown.
  std::string language;               ///< "en", "ja".
  std::string taken_by;               ///< User.
  StoreTime given{0};
  std::optional<StoreTime> withdrawn;
};

/// A scan: a recording and what it was for.
struct ScanRow {
  std::string id;  ///< "S-000123".
  std::string customer_id;
  std::string consent_id;
  std::string profile;
  std::string verdict;             ///< "good", "usable", "repeat", or "" before it is judged.
  std::string recording;           ///< Content hash of the sealed file (64 hex digits), or "" if nothing was recorded.
  bool recording_missing = false;  ///< The row names one that is not there (fault row D10).
  StoreTime taken{0};
  std::string summary_json;  ///< Quality, plan; opened.
};

/// Something derived from a scan, that `annulus rebuild` can make again, or that a person has made (a design).
struct Artefact {
  std::string id;  ///< "A-000200".
  std::string scan_id;
  std::string customer_id;
  std::string
      kind;  ///< "model", "landmarks", "measurements", "design", "worn", "look", "reshaped", "picture", "document".
  std::string name;     ///< A file name, or a design's title.
  bool derived = true;  ///< Can be made again.
  std::string recipe;   ///< How (command and options), for `rebuild`.
  StoreTime made{0};
  std::uint64_t bytes = 0;
};

/// Somebody who may log in.
struct User {
  std::string name;  ///< 1 … 64 of letters, digits, '-', '_', '.'.
  StationRole role = StationRole::kNone;
  bool enabled = true;
  bool has_pin = false;   ///< Of operators, on the booth's own screen only.
  bool has_totp = false;  ///< Second factor, asked for when remote.
  StoreTime created{0};
  std::optional<StoreTime> last_login;
};

/// One line of the audit chain.
struct AuditLine {
  std::uint64_t number = 0;  ///< From 1, without gaps.
  StoreTime time{0};
  std::int64_t monotonic_ns = 0;
  std::string user;     ///< "" if nobody was logged in.
  std::string origin;   ///< "screen", "remote 192.0.2.1", "program".
  std::string action;   ///< "login", "arm", "start", "stop", "erase" …
  std::string subject;  ///< An id, never a name or a measurement.
  std::string result;   ///< "ok", or why not.
  std::string hash;     ///< Of this line and the one before, 64 hex digits.
};

/// Proof of an erasure, kept without anything of the customer but the id.
struct ErasureProof {
  std::string customer_id;
  StoreTime time{0};
  std::uint64_t files = 0;  ///< Unlinked.
  std::uint64_t rows = 0;   ///< Deleted.
  bool key_destroyed = false;
  std::uint64_t bytes_searched = 0;  ///< Of database, WAL, recordings and backups.
  std::uint64_t marker_hits = 0;     ///< Of the customer's plain name, contact, wrapped key in them: 0.
};

}  // namespace annulus
