#include "station/http/peer_budget.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace annulus {
namespace {

constexpr auto kReportEvery = std::chrono::seconds(1);
/// The account of all peers that have none of their own; no address looks like it.
const std::string kEverybodyElse = "*";

}  // namespace

std::string PeerKey(const std::string& address) {
  in6_addr parsed{};
  if (::inet_pton(AF_INET6, address.c_str(), &parsed) != 1 || IN6_IS_ADDR_LOOPBACK(&parsed)) return address;
  std::memset(parsed.s6_addr + 8, 0, 8);
  std::array<char, INET6_ADDRSTRLEN> text{};
  ::inet_ntop(AF_INET6, &parsed, text.data(), text.size());
  return std::string(text.data()) + "/64";
}

PeerBudget::PeerBudget(const HttpLimits& limits)
    : rate_(limits.requests_per_second),
      burst_(limits.burst),
      max_connections_(limits.connections),
      max_per_peer_(limits.connections_per_peer) {}

void PeerBudget::DropIdle(Time now) {
  std::erase_if(accounts_, [&](const auto& entry) {
    const Account& account = entry.second;
    const double since_s = std::chrono::duration<double>(now - account.refilled).count();
    return account.connections == 0 && account.tokens + since_s * rate_ >= burst_ && since_s > 1.0;
  });
}

std::string PeerBudget::KeyOf(const std::string& address, Time now) {
  std::string key = PeerKey(address);
  if (accounts_.contains(key)) return key;
  if (accounts_.size() >= kMaxPeers) DropIdle(now);
  return accounts_.size() >= kMaxPeers ? kEverybodyElse : key;
}

PeerBudget::Account& PeerBudget::Get(const std::string& key, Time now) {
  Account& account = accounts_.try_emplace(key, Account{burst_, now, 0, Time::min()}).first->second;
  const double since_s = std::chrono::duration<double>(now - account.refilled).count();
  account.tokens = std::min(burst_, account.tokens + since_s * rate_);
  account.refilled = now;
  return account;
}

bool PeerBudget::Spend(const std::string& key, double cost, Time now) {
  Account& account = Get(key, now);
  const bool enough = account.tokens >= cost;
  account.tokens = std::max(account.tokens - cost, -burst_);
  return enough;
}

int PeerBudget::RetryAfterSeconds(const std::string& key, Time now) {
  const double missing = kRequestCost - Get(key, now).tokens;
  return std::max(1, static_cast<int>(std::ceil(missing / rate_)));
}

std::string PeerBudget::AddConnection(const std::string& key, bool loopback, Time now) {
  const std::size_t kept = loopback ? 0 : std::min(max_per_peer_, max_connections_ - 1);
  if (connections_ >= max_connections_ - kept) return "too many connections";
  Account& account = Get(key, now);
  if (account.connections >= max_per_peer_) return "too many connections of this address";
  if (account.tokens < -burst_ / 2.0) return "too many requests";
  ++account.connections;
  ++connections_;
  return {};
}

void PeerBudget::RemoveConnection(const std::string& key) {
  const auto found = accounts_.find(key);
  if (found != accounts_.end() && found->second.connections > 0) --found->second.connections;
  if (connections_ > 0) --connections_;
}

bool PeerBudget::MayReport(const std::string& key, Time now) {
  Account& account = Get(key, now);
  if (account.reported != Time::min() && now - account.reported < kReportEvery) return false;
  account.reported = now;
  return true;
}

}  // namespace annulus
