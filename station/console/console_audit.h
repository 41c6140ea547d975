#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "base/clock.h"
#include "station/console/route.h"

namespace annulus {

class Store;

/// Who a request came from, as the audit says it: "screen", "remote 192.0.2.1".
[[nodiscard]] std::string AuditOrigin(const Caller& caller);

/// Writes lines of the audit. What was carried out is always written; refusals are, at most 200 at once and 5 a second
/// in the long run, because every line goes to the disk and anybody can be refused: what was left out is counted in the
/// next line. A store that does not take a line is logged. Thread-safe.
class ConsoleAudit {
 public:
  ConsoleAudit(Store& store, const Clock& clock) : store_(store), clock_(clock) {}

  /// `subject` is an id; what does not look like one is left out.
  void Done(const Caller& caller, const std::string& action, const std::string& subject, const std::string& result);
  /// `what`: "POST /api/booth/start" (a pattern, never a path that somebody typed), `why`: a fixed text.
  void Refused(const Caller& caller, const std::string& what, const std::string& why);

 private:
  /// If one more refusal may be written: how many were left out since the last one.
  std::optional<std::uint64_t> MayWrite();
  void Write(const Caller& caller, const std::string& action, const std::string& subject, const std::string& result);

  Store& store_;
  const Clock& clock_;
  std::mutex mutex_;
  double tokens_ = 200.0;
  std::chrono::nanoseconds filled_{0};
  std::uint64_t left_out_ = 0;
};

}  // namespace annulus
