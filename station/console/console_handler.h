#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "acquisition/scanner.h"
#include "station/console/console_audit.h"
#include "station/console/live_hub.h"
#include "station/console/request_gate.h"
#include "station/console/route.h"
#include "station/console/static_files.h"
#include "station/http/http_server.h"
#include "station/http/worker_lane.h"

namespace annulus {

/// What the console answers with. All borrowed, but what is a function.
struct ConsoleParts {
  const RouteTable& routes;
  RequestGate& gate;
  Sessions& sessions;
  const StaticFiles& files;
  LiveHub& live;
  ConsoleAudit& audit;
  /// A beat of hold-to-run jogging, from a technician on the booth's own screen.
  std::function<Status(Scanner::JogDirection)> jog;
};

/// Ties together what the server hands on: page files, API routes behind the gate, and live WebSockets. Every answer
/// carries the security headers; every refusal by a rule, and everything that was done, is in the audit. Thread-safe.
class ConsoleHandler final : public HttpHandler {
 public:
  explicit ConsoleHandler(ConsoleParts parts) : parts_(std::move(parts)) {}
  /// Writes what the audit has still to be told.
  ~ConsoleHandler() override { stop_audit_.Stop(WorkerLane::Leftover::kFinish); }

  HttpResponse Handle(const HttpRequest& request) override;
  std::optional<HttpResponse> Open(const HttpRequest& request, const std::shared_ptr<WebSocketPeer>& peer) override;
  void Received(const std::shared_ptr<WebSocketPeer>& peer, std::string_view text) override;
  void Closed(const std::shared_ptr<WebSocketPeer>& peer) override;
  void Refused(const std::string& peer, const std::string& reason) override;

 private:
  HttpResponse Page(const HttpRequest& request) const;
  HttpResponse Api(const HttpRequest& request);
  HttpResponse Carry(const RequestGate::Passed& passed, const HttpRequest& request);
  /// Writes to the audit before the request is answered. For STOP it waits a moment only: neither its answer nor the
  /// next STOP may hang on a disk.
  void Note(const HttpRequest& request, const std::function<void()>& write);
  void AuditDone(const RequestGate::Passed& passed, const std::string& body_subject, int status);
  void NoteRefusal(const RequestGate::Refused& refused, const std::string& method);
  Status TakeMessage(const std::shared_ptr<WebSocketPeer>& peer, std::string_view text);
  Status Jog(const Caller& caller, const std::string& direction);

  ConsoleParts parts_;
  WorkerLane stop_audit_{"audit-stop", 1};
  std::mutex mutex_;
  std::map<std::shared_ptr<WebSocketPeer>, Caller> sockets_;  ///< Those that are open.
};

}  // namespace annulus
