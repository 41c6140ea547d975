#include "station/console/live_hub.h"

#include <algorithm>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using Peer = std::shared_ptr<WebSocketPeer>;

/// Policy violation: nearest to "your session is over" among the codes of RFC 6455 §7.4.1.
constexpr std::uint16_t kCloseSessionEnded = 1008;

std::shared_ptr<const std::string> Encoded(const Json& message) {
  return std::make_shared<const std::string>(message.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// The level with every `step`-th sensor only; as it is if it has not so many or is none.
Json Thinned(const Json& level, int step) {
  const int has = level.value("sensor_step", 1);
  const auto readings = level.find("radius_mm");
  if (step <= has || step % has != 0 || readings == level.end() || !readings->is_array()) return level;
  Json thin = level;
  Json& kept = thin["radius_mm"] = Json::array();
  for (std::size_t i = 0; i < readings->size(); i += static_cast<std::size_t>(step / has))
    kept.push_back((*readings)[i]);
  thin["sensor_step"] = step;
  return thin;
}

class Hub final : public LiveHub {
 public:
  void Join(const Peer& peer, const Caller& caller) override {
    const std::lock_guard lock(mutex_);
    members_[peer] = {caller, 1};
  }

  void Leave(const Peer& peer) override {
    const std::lock_guard lock(mutex_);
    members_.erase(peer);
  }

  void Subscribe(const Peer& peer, int sensor_step) override {
    const std::lock_guard lock(mutex_);
    if (const auto found = members_.find(peer); found != members_.end()) found->second.sensor_step = sensor_step;
  }

  void Send(const Json& message, RouteRoles roles, bool droppable) override {
    const auto members = Members([&](const Member& one) { return roles.Allows(one.caller.role); });
    const bool level = message.value("type", "") == "level";
    std::map<int, std::shared_ptr<const std::string>> texts;  // by sensor_step
    for (const auto& [peer, member] : members) {
      if (droppable && peer->queued_bytes() > HttpLimits().socket_queue_bytes / 4) continue;
      auto& text = texts[level ? member.sensor_step : 1];
      if (text == nullptr) text = Encoded(level ? Thinned(message, member.sensor_step) : message);
      peer->SendText(text);
    }
  }

  void SendTo(const std::string& user, const Json& message) override {
    if (!user.empty()) SendIf(message, [&](const Member& one) { return one.caller.user == user; });
  }

  void SendToSession(const std::string& session_id, const Json& message) override {
    if (!session_id.empty()) SendIf(message, [&](const Member& one) { return one.caller.session_id == session_id; });
  }

  void End(const std::string& session_id) override {
    if (session_id.empty()) return;
    const auto members = Members([&](const Member& one) { return one.caller.session_id == session_id; });
    for (const auto& [peer, member] : members) {
      Leave(peer);  // whatever becomes of the goodbye, nothing more is sent to it
      peer->Close(kCloseSessionEnded, "session ended");
    }
  }

 private:
  struct Member {
    Caller caller;
    int sensor_step = 1;
  };

  /// A copy, so that nothing is sent under the lock: a peer that is dropped comes back to Leave.
  std::vector<std::pair<Peer, Member>> Members(const std::function<bool(const Member&)>& wanted) {
    const std::lock_guard lock(mutex_);
    std::vector<std::pair<Peer, Member>> found;
    for (const auto& one : members_) {
      if (wanted(one.second)) found.emplace_back(one);
    }
    return found;
  }

  void SendIf(const Json& message, const std::function<bool(const Member&)>& wanted) {
    const auto members = Members(wanted);
    if (members.empty()) return;
    const auto text = Encoded(message);
    for (const auto& [peer, member] : members) peer->SendText(text);
  }

  std::mutex mutex_;
  std::map<Peer, Member> members_;
};

}  // namespace

void LiveHub::Subscribe(const std::shared_ptr<WebSocketPeer>& /*peer*/, int /*sensor_step*/) {}

void LiveHub::SendToSession(const std::string& /*session_id*/, const Json& /*message*/) {}

void EndSession(LiveHub& live, const std::string& session_id, const std::string& reason) {
  live.SendToSession(session_id, {{"type", "session_ended"}, {"reason", reason}});
  live.End(session_id);
}

std::unique_ptr<LiveHub> LiveHub::Make() { return std::make_unique<Hub>(); }

}  // namespace annulus
