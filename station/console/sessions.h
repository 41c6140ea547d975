#pragma once

#include <array>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.h"
#include "station/store/store_types.h"

namespace annulus {

/// How long a session lasts, and how many there may be.
struct SessionLimits {
  std::chrono::seconds idle_loopback{5 * 60};
  std::chrono::seconds idle_remote{15 * 60};
  std::chrono::seconds absolute{8 * 60 * 60};
  std::chrono::seconds control_idle{60};  ///< A session that has not used the booth for so long gives control up.
  std::size_t most = 256;                 ///< Beyond: the one that is idle longest ends.
};

/// Somebody who is logged in.
struct Session {
  std::string id;  ///< To name it by (WebSockets, job owners, the audit); is no secret and cannot be made a cookie.
  std::string user;
  StationRole role = StationRole::kNone;
  bool loopback = false;  ///< Logged in on the booth's own screen; the cookie is worth nothing from elsewhere.
  std::chrono::nanoseconds opened{0};  ///< Clock::Now().
  std::chrono::nanoseconds last_used{0};
};

/// Whether a request counts as use of the session: the page's own asking in the background does not.
enum class SessionUse { kUse, kLook };

/// The sessions of this process; they end with it. The cookie is 128 random bits, of which only a hash is kept. The
/// CSRF token is a keyed hash of the cookie, so that there is one before anybody has logged in, and none is kept.
/// Thread-safe.
class Sessions {
 public:
  explicit Sessions(const Clock& clock, SessionLimits limits = {});

  /// A cookie's value: 32 hex digits, random. Of nobody until OpenSession gives it to a user.
  [[nodiscard]] static std::string NewCookie();
  /// Whether a text could be a cookie of ours.
  [[nodiscard]] static bool IsCookie(std::string_view cookie);
  /// The CSRF token that belongs to a cookie, of a session or of nobody.
  [[nodiscard]] std::string CsrfToken(std::string_view cookie) const;
  /// Compared in constant time.
  [[nodiscard]] bool IsCsrfToken(std::string_view cookie, std::string_view token) const;

  /// A new session with a new cookie.
  struct Opened {
    std::string cookie;
    Session session;
  };
  [[nodiscard]] Opened Open(const std::string& user, StationRole role, bool loopback);
  /// The session of a cookie, unless it has ended.
  [[nodiscard]] std::optional<Session> Find(std::string_view cookie, bool loopback, SessionUse use);
  /// Counts as use of the session, and says whether it has not ended (for what comes over a WebSocket).
  bool Use(const std::string& session_id);
  /// Seconds until it ends without use.
  [[nodiscard]] std::chrono::seconds Left(const Session& session) const;

  void Close(const std::string& session_id);
  /// All of a user (password, role or account changed); `except` stays. Returns the ids of those that ended.
  std::vector<std::string> CloseOf(const std::string& user, const std::string& except = "");
  /// Ends and returns the ids of those whose time is over.
  [[nodiscard]] std::vector<std::string> CloseExpired();

  /// Asks for control of the booth, which one session has at a time: whoever gives the first order, until its session
  /// ends or has not used the booth for SessionLimits::control_idle; the booth's own screen takes it from a remote one.
  /// Nothing if `session_id` has it now, else the user who has it.
  [[nodiscard]] std::optional<std::string> TakeControl(const std::string& session_id);

 private:
  using Hash = std::array<unsigned char, 32>;
  [[nodiscard]] Hash HashOf(std::string_view cookie) const;
  [[nodiscard]] bool HasEnded(const Session& session, std::chrono::nanoseconds now) const;
  [[nodiscard]] Session* ById(const std::string& id);

  const Clock& clock_;
  SessionLimits limits_;
  Hash key_{};  ///< Of the hashes; random, of this process.
  mutable std::mutex mutex_;
  std::map<Hash, Session> sessions_;
  std::string controlling_;  ///< Session id.
  std::chrono::nanoseconds control_used_{0};
};

}  // namespace annulus
