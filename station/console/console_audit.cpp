#include "station/console/console_audit.h"

#include <algorithm>
#include <utility>

#include "base/log.h"
#include "station/store/store.h"

namespace annulus {
namespace {

constexpr double kBurst = 200.0;
constexpr double kPerSecond = 5.0;
constexpr std::size_t kLongestId = 64;

bool LooksLikeId(const std::string& text) {
  return text.size() <= kLongestId && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
                  c == '.';
         });
}

}  // namespace

std::string AuditOrigin(const Caller& caller) { return caller.loopback ? "screen" : "remote " + caller.peer; }

void ConsoleAudit::Write(const Caller& caller, const std::string& action, const std::string& subject,
                         const std::string& result) {
  AuditLine line;
  line.user = caller.user;
  line.origin = AuditOrigin(caller);
  line.action = action;
  line.subject = subject;
  line.result = result;
  const Status written = store_.Audit(line);
  if (!written) Log(LogLevel::kError, "audit: " + action + " by '" + caller.user + "': " + written.error().Text());
}

void ConsoleAudit::Done(const Caller& caller, const std::string& action, const std::string& subject,
                        const std::string& result) {
  Write(caller, action, LooksLikeId(subject) ? subject : "", result);
}

void ConsoleAudit::Refused(const Caller& caller, const std::string& what, const std::string& why) {
  const auto left_out = MayWrite();
  if (!left_out) return;
  const std::string more = *left_out == 0 ? "" : " (" + std::to_string(*left_out) + " more were left out before this)";
  Write(caller, "refused", "", what + ": " + why + more);
}

std::optional<std::uint64_t> ConsoleAudit::MayWrite() {
  const std::lock_guard lock(mutex_);
  const std::chrono::nanoseconds now = clock_.Now();
  const double passed = std::chrono::duration<double>(now - filled_).count();
  tokens_ = std::min(kBurst, tokens_ + passed * kPerSecond);
  filled_ = now;
  if (tokens_ < 1.0) {
    ++left_out_;
    return std::nullopt;
  }
  tokens_ -= 1.0;
  return std::exchange(left_out_, 0);
}

}  // namespace annulus
