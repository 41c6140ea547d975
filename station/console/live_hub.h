#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "station/console/route.h"
#include "station/http/http_server.h"

namespace annulus {

/// Sends what happens to the browsers that look on (docs/console_api.md, "Live"). Thread-safe; never waits for a
/// client.
class LiveHub {
 public:
  static std::unique_ptr<LiveHub> Make();
  virtual ~LiveHub() = default;

  virtual void Join(const std::shared_ptr<WebSocketPeer>& peer, const Caller& caller) = 0;
  virtual void Leave(const std::shared_ptr<WebSocketPeer>& peer) = 0;
  /// From now on this peer gets every `sensor_step`-th sensor of a level: 1, 2, 3 or 6.
  virtual void Subscribe(const std::shared_ptr<WebSocketPeer>& peer, int sensor_step);
  /// To everybody whose role is among `roles`. Encoded once. A client with more than a quarter of its queue unread is
  /// left out of what is marked droppable (levels): the next one is as good. A message of type "level" is thinned to
  /// each client's sensor_step.
  virtual void Send(const nlohmann::ordered_json& message, RouteRoles roles, bool droppable = false) = 0;
  /// To the sessions of one user only (job progress).
  virtual void SendTo(const std::string& user, const nlohmann::ordered_json& message) = 0;
  /// To the browsers of one session only (screen_wiped).
  virtual void SendToSession(const std::string& session_id, const nlohmann::ordered_json& message);
  /// Ends the sockets of a session.
  virtual void End(const std::string& session_id) = 0;
};

/// Tells the browsers of a session `session_ended` with this reason ("logged out", "not used for too long"), and ends
/// their sockets.
void EndSession(LiveHub& live, const std::string& session_id, const std::string& reason);

}  // namespace annulus
