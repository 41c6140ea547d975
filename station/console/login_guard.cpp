#include "station/console/login_guard.h"

#include <algorithm>

namespace annulus {
namespace {

constexpr std::size_t kMostKeys = 4096;

std::string UserKey(const std::string& user, bool loopback) { return (loopback ? "user here " : "user afar ") + user; }

}  // namespace

std::optional<std::chrono::seconds> LoginGuard::Begin(const std::string& user, const std::string& peer, bool loopback) {
  const std::lock_guard lock(mutex_);
  MakeRoom();
  const auto by_address = Count("address " + peer, limits_.free_tries_of_address);
  if (by_address) return by_address;
  return Count(UserKey(user, loopback), limits_.free_tries);
}

std::optional<std::chrono::seconds> LoginGuard::Count(const std::string& key, int free_tries) {
  const std::chrono::nanoseconds now = clock_.Now();
  Tries& tries = tries_[key];
  if (now < tries.not_before) {
    return std::chrono::ceil<std::chrono::seconds>(tries.not_before - now);
  }
  // Whoever had to wait is remembered for longer: else guessing would go on at five tries for every first wait.
  const bool has_waited = tries.not_before > std::chrono::nanoseconds(0);
  const auto memory = has_waited ? limits_.longest_wait : limits_.window;
  if (now - std::max(tries.last, tries.not_before) >= memory) tries = {};
  ++tries.count;
  tries.last = now;
  if (tries.count >= free_tries) {
    const int doublings = std::min(tries.count - free_tries, 20);
    const auto wait = std::min(limits_.first_wait * (std::int64_t{1} << doublings), limits_.longest_wait);
    tries.not_before = now + wait;
  }
  return std::nullopt;
}

void LoginGuard::Succeeded(const std::string& user, bool loopback) {
  const std::lock_guard lock(mutex_);
  tries_.erase(UserKey(user, loopback));
}

void LoginGuard::MakeRoom() {
  if (tries_.size() < kMostKeys) return;
  const auto oldest = std::min_element(tries_.begin(), tries_.end(), [](const auto& a, const auto& b) {
    return std::max(a.second.last, a.second.not_before) < std::max(b.second.last, b.second.not_before);
  });
  tries_.erase(oldest);
}

}  // namespace annulus
