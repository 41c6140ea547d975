#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "station/config.h"
#include "station/store/store_types.h"

namespace annulus {

class ModelCache;
class Store;

/// Days for which a new customer is kept: what an admin has set, or what the configuration says.
[[nodiscard]] int RetentionDays(Store& store, const StoreConfig& config);

/// Erases who is kept beyond their time, when an admin asks for it or by itself. All borrowed. Thread-safe as the
/// store.
///
/// By itself means at the start of the console and then once a day. A clock that has jumped ahead would erase
/// everybody: if more than kLongestGap has passed since retention was applied last (or the station was off for so
/// long), nobody is erased by itself until an admin has applied it.
class Retention {
 public:
  static constexpr std::chrono::hours kEvery{24};
  static constexpr std::chrono::hours kLongestGap{24 * 31};
  /// Told of every erasure: the customer's id, and "ok" or "failed".
  using Note = std::function<void(const std::string& customer_id, const std::string& result)>;

  Retention(Store& store, ModelCache& models, const Clock& clock) : store_(store), models_(models), clock_(clock) {}

  /// When it was applied last; nothing if it never was.
  [[nodiscard]] Result<std::optional<StoreTime>> LastApplied();
  /// Whether there are customers to be erased whom it does not erase by itself.
  [[nodiscard]] Result<bool> IsHeld();
  /// Erases all whose time is over. Ends at the first that cannot be erased.
  Result<std::vector<ErasureProof>> Apply(const Note& note);
  /// The same by itself, with lines in the audit, unless it is held: then nobody is erased, and the audit says so.
  Result<std::vector<ErasureProof>> ApplyByItself();
  /// True once at first, then once a day: it is time for ApplyByItself. Of one thread.
  bool IsDue();

 private:
  Store& store_;
  ModelCache& models_;
  const Clock& clock_;
  std::optional<std::chrono::nanoseconds> looked_;  ///< Clock::Now().
};

}  // namespace annulus
