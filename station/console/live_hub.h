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
  /// To everybody whose role is among `roles`. Encoded once. A client with more than a quarter of its queue unread is
  /// left out of what is marked droppable (levels): the next one is as good.
  virtual void Send(const nlohmann::ordered_json& message, RouteRoles roles, bool droppable = false) = 0;
  /// To the sessions of one user only (job progress).
  virtual void SendTo(const std::string& user, const nlohmann::ordered_json& message) = 0;
  /// Ends the sockets of a session (log out, expiry).
  virtual void End(const std::string& session_id) = 0;
};

}  // namespace annulus
