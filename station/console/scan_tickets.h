#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "base/result.h"
#include "station/store/store_types.h"

namespace annulus {

class Store;

/// For whom a scan was armed. Written before boothd is asked to arm, so that a recording is bound to its customer and
/// consent whatever becomes of the page, the session and the console in the meantime (fault row U1).
struct ScanTicket {
  std::string id;  ///< "T-" and 32 hex digits; the recording is called "ID.mcap".
  std::string customer_id;
  std::string consent_id;
  std::string profile;
  std::string user;  ///< Who armed it; the jobs that follow are theirs.
  StoreTime armed{0};

  [[nodiscard]] std::string recording() const { return id + ".mcap"; }
};

/// The tickets of scans that were armed, in a setting of the store; those of the last thousand scans are kept.
/// Thread-safe; only one writes at a time.
class ScanTickets {
 public:
  explicit ScanTickets(Store& store) : store_(store) {}

  /// Gives the ticket its id, and keeps it.
  Result<ScanTicket> Add(ScanTicket ticket);
  /// Takes back one that nothing came of.
  Status Remove(const std::string& id);
  /// Nothing if there is none of this id.
  [[nodiscard]] Result<std::optional<ScanTicket>> Find(const std::string& id) const;

 private:
  Store& store_;
  std::mutex mutex_;
};

}  // namespace annulus
