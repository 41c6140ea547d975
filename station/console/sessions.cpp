#include "station/console/sessions.h"

#include <sodium.h>

#include <algorithm>
#include <utility>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr std::size_t kCookieBytes = 16;

std::string Hex(const unsigned char* bytes, std::size_t size) {
  std::string hex(2 * size + 1, '\0');
  sodium_bin2hex(hex.data(), hex.size(), bytes, size);
  hex.pop_back();
  return hex;
}

/// BLAKE2b of `label` and `text` with a key, 256 bits.
std::array<unsigned char, 32> KeyedHash(const std::array<unsigned char, 32>& key, std::string_view label,
                                        std::string_view text) {
  const std::string input = std::string(label) + ':' + std::string(text);
  std::array<unsigned char, 32> hash{};
  crypto_generichash(hash.data(), hash.size(), reinterpret_cast<const unsigned char*>(input.data()), input.size(),
                     key.data(), key.size());
  return hash;
}

}  // namespace

Sessions::Sessions(const Clock& clock, SessionLimits limits) : clock_(clock), limits_(limits) {
  ENSURE(sodium_init() >= 0, "libsodium finds no random numbers");
  randombytes_buf(key_.data(), key_.size());
}

std::string Sessions::NewCookie() {
  ENSURE(sodium_init() >= 0, "libsodium finds no random numbers");
  std::array<unsigned char, kCookieBytes> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  return Hex(bytes.data(), bytes.size());
}

bool Sessions::IsCookie(std::string_view cookie) {
  return cookie.size() == 2 * kCookieBytes && cookie.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::string Sessions::CsrfToken(std::string_view cookie) const {
  const Hash hash = KeyedHash(key_, "csrf", cookie);
  return Hex(hash.data(), hash.size());
}

bool Sessions::IsCsrfToken(std::string_view cookie, std::string_view token) const {
  const std::string right = CsrfToken(cookie);
  return IsCookie(cookie) && token.size() == right.size() &&
         sodium_memcmp(token.data(), right.data(), right.size()) == 0;
}

Sessions::Hash Sessions::HashOf(std::string_view cookie) const { return KeyedHash(key_, "session", cookie); }

Sessions::Opened Sessions::Open(const std::string& user, StationRole role, bool loopback) {
  Opened opened;
  opened.cookie = NewCookie();
  const Hash hash = HashOf(opened.cookie);
  const Hash name = KeyedHash(key_, "name", opened.cookie);
  opened.session = {Hex(name.data(), kCookieBytes), user, role, loopback, clock_.Now(), clock_.Now()};
  const std::lock_guard lock(mutex_);
  if (sessions_.size() >= limits_.most) {
    sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(), [](const auto& a, const auto& b) {
      return a.second.last_used < b.second.last_used;
    }));
  }
  sessions_[hash] = opened.session;
  return opened;
}

std::optional<Session> Sessions::Find(std::string_view cookie, bool loopback, SessionUse use) {
  if (!IsCookie(cookie)) return std::nullopt;
  const Hash hash = HashOf(cookie);
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(hash);
  if (found == sessions_.end() || found->second.loopback != loopback) return std::nullopt;
  const std::chrono::nanoseconds now = clock_.Now();
  if (HasEnded(found->second, now)) return std::nullopt;  // CloseExpired tells its browsers
  if (use == SessionUse::kUse) found->second.last_used = now;
  return found->second;
}

bool Sessions::HasEnded(const Session& session, std::chrono::nanoseconds now) const {
  const auto idle = session.loopback ? limits_.idle_loopback : limits_.idle_remote;
  return now - session.last_used >= idle || now - session.opened >= limits_.absolute;
}

std::chrono::seconds Sessions::Left(const Session& session) const {
  const auto idle = session.loopback ? limits_.idle_loopback : limits_.idle_remote;
  const auto end = std::min(session.last_used + idle, session.opened + limits_.absolute);
  const auto left = std::chrono::floor<std::chrono::seconds>(end - clock_.Now());
  return std::max(left, std::chrono::seconds(0));
}

void Sessions::Close(const std::string& session_id) {
  const std::lock_guard lock(mutex_);
  std::erase_if(sessions_, [&](const auto& one) { return one.second.id == session_id; });
}

std::vector<std::string> Sessions::CloseOf(const std::string& user, const std::string& except) {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> ended;
  std::erase_if(sessions_, [&](const auto& one) {
    const bool ends = one.second.user == user && one.second.id != except;
    if (ends) ended.push_back(one.second.id);
    return ends;
  });
  return ended;
}

std::vector<std::string> Sessions::CloseExpired() {
  const std::chrono::nanoseconds now = clock_.Now();
  const std::lock_guard lock(mutex_);
  std::vector<std::string> ended;
  std::erase_if(sessions_, [&](const auto& one) {
    const bool ends = HasEnded(one.second, now);
    if (ends) ended.push_back(one.second.id);
    return ends;
  });
  return ended;
}

bool Sessions::Use(const std::string& session_id) {
  const std::chrono::nanoseconds now = clock_.Now();
  const std::lock_guard lock(mutex_);
  Session* session = ById(session_id);
  if (session == nullptr || HasEnded(*session, now)) return false;
  session->last_used = now;
  return true;
}

Session* Sessions::ById(const std::string& id) {
  const auto found =
      std::find_if(sessions_.begin(), sessions_.end(), [&](const auto& one) { return one.second.id == id; });
  return found == sessions_.end() ? nullptr : &found->second;
}

std::optional<std::string> Sessions::TakeControl(const std::string& session_id) {
  const std::chrono::nanoseconds now = clock_.Now();
  const std::lock_guard lock(mutex_);
  const Session* holder = ById(controlling_);
  const bool held = holder != nullptr && !HasEnded(*holder, now) && now - control_used_ < limits_.control_idle;
  if (held && holder->id != session_id) {
    const Session* asking = ById(session_id);
    const bool screen_first = asking != nullptr && asking->loopback && !holder->loopback;
    if (!screen_first) return holder->user;
  }
  controlling_ = session_id;
  control_used_ = now;
  return std::nullopt;
}

}  // namespace annulus
