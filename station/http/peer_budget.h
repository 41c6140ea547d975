#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <unordered_map>

#include "station/http/http_server.h"

namespace annulus {

/// The network that an address is counted by: an IPv4 address is itself, an IPv6 address its first 64 bits (a site may
/// use them all), a loopback address itself.
[[nodiscard]] std::string PeerKey(const std::string& address);

/// What each peer may still ask for: a token bucket (HttpLimits::requests_per_second, burst), its connections, and when
/// the handler was last told of it. Time is passed in, monotonic. Holds at most kMaxPeers accounts; whoever comes then
/// shares one. Thread-bound.
class PeerBudget {
 public:
  using Time = std::chrono::nanoseconds;
  static constexpr std::size_t kMaxPeers = 4096;
  static constexpr double kBadRequestCost = 4.0;
  static constexpr double kRequestCost = 1.0;

  explicit PeerBudget(const HttpLimits& limits);

  /// The account of the peer of this address, made if there is room, else the shared one: the `key` of the other calls
  /// as long as a connection of it is counted.
  [[nodiscard]] std::string KeyOf(const std::string& address, Time now);

  /// Takes `cost` requests. False if they were not there; they are owed then (down to minus the burst), so that who
  /// goes on asking waits longer.
  bool Spend(const std::string& key, double cost, Time now);
  /// Whole seconds, at least 1, until a request of this peer would be answered.
  [[nodiscard]] int RetryAfterSeconds(const std::string& key, Time now);

  /// Why no connection may be added for this peer now; empty if it was added. The last
  /// HttpLimits::connections_per_peer of all are kept for `loopback`, so that the booth's own screen always gets in.
  /// One that owes more than half of a burst is not even shaken hands with.
  [[nodiscard]] std::string AddConnection(const std::string& key, bool loopback, Time now);
  void RemoveConnection(const std::string& key);
  [[nodiscard]] std::size_t connections() const { return connections_; }

  /// Whether the handler may be told of a refusal of this peer: once a second.
  [[nodiscard]] bool MayReport(const std::string& key, Time now);

 private:
  struct Account {
    double tokens = 0.0;
    Time refilled{0};
    std::size_t connections = 0;
    Time reported = Time::min();
  };
  Account& Get(const std::string& key, Time now);
  void DropIdle(Time now);

  double rate_;
  double burst_;
  std::size_t max_connections_;
  std::size_t max_per_peer_;
  std::size_t connections_ = 0;
  std::unordered_map<std::string, Account> accounts_;
};

}  // namespace annulus
