#include "station/console/console_handler.h"

#include <chrono>
#include <exception>
#include <future>
#include <nlohmann/json.hpp>
#include <typeinfo>
#include <utility>

#include "base/ensure.h"
#include "base/log.h"
#include "station/console/json_body.h"
#include "station/console/route_errors.h"
#include "station/console/security_headers.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

HttpResponse ErrorAnswer(const ApiError& error) {
  Json json{{"error", ErrorJson(error.error)}};
  if (!error.field.empty()) json["field"] = error.field;
  HttpResponse response = JsonAnswer(json, error.status);
  if (error.status == 405) response.headers.emplace_back("Allow", "GET, POST");
  return response;
}

/// What may be logged of an exception: our own say where the program is wrong; the words of others may quote data.
std::string KindOf(const std::exception& failure) {
  const auto* ours = dynamic_cast<const LogicError*>(&failure);
  return ours != nullptr ? ours->what() : typeid(failure).name();
}

constexpr std::chrono::milliseconds kAuditOfStop{100};

/// The value that Route::audit_parameter names, of the body.
std::string SubjectIn(const nlohmann::json& body, const std::string& parameter) {
  const auto found = body.find(parameter);
  return found != body.end() && found->is_string() ? found->get<std::string>() : std::string();
}

}  // namespace

HttpResponse ConsoleHandler::Handle(const HttpRequest& request) {
  const bool api = request.path.starts_with("/api/");
  HttpResponse response;
  try {
    if (auto foreign = parts_.gate.CheckHost(request)) {
      const Caller nobody{"", StationRole::kNone, "", request.loopback, request.peer};
      Note(request, [this, refused = RequestGate::Refused{*foreign, nobody, nullptr, true}, method = request.method] {
        NoteRefusal(refused, method);
      });
      response = ErrorAnswer(*foreign);
    } else {
      response = api ? Api(request) : Page(request);
    }
  } catch (const std::exception& failure) {
    Log(LogLevel::kError, "console: a request ended in an exception: " + KindOf(failure));
    response =
        ErrorAnswer({500, {"carry out the request", "the program is wrong", "tell the makers what you did"}, ""});
  }
  AddSecurityHeaders(response, api ? AnswerKind::kApi : AnswerKind::kFile, request.loopback);
  return response;
}

HttpResponse ConsoleHandler::Page(const HttpRequest& request) const {
  if (request.method == "GET" || request.method == "HEAD") return parts_.files.Answer(request);
  return ErrorAnswer({405, {"let the request in", "a page can only be read", "use GET"}, ""});
}

HttpResponse ConsoleHandler::Api(const HttpRequest& request) {
  auto passed = parts_.gate.Check(parts_.routes, request);
  if (!passed) {
    Note(request, [this, refused = passed.error(), method = request.method] { NoteRefusal(refused, method); });
    return ErrorAnswer(passed.error().error);
  }
  return Carry(*passed, request);
}

HttpResponse ConsoleHandler::Carry(const RequestGate::Passed& passed, const HttpRequest& request) {
  const bool has_json = passed.route->method == "POST" && !TakesBytes(*passed.route);
  auto body = ParseJsonObject(has_json ? std::string_view(request.body) : std::string_view());
  if (!body) return ErrorAnswer(body.error());
  ApiResult result = passed.route->handle({request, passed.caller, passed.path, *body});
  if (!passed.route->audit_action.empty()) {
    const int status = result ? result->status : result.error().status;
    Note(request, [this, passed, status, subject = SubjectIn(*body, passed.route->audit_parameter)] {
      AuditDone(passed, subject, status);
    });
  }
  return result ? std::move(*result) : ErrorAnswer(result.error());
}

void ConsoleHandler::Note(const HttpRequest& request, const std::function<void()>& write) {
  if (request.path != kStopPath) return write();
  const auto written = std::make_shared<std::promise<void>>();
  stop_audit_.Run([write, written] {
    try {
      write();
    } catch (const std::exception& failure) {
      Log(LogLevel::kError, "console: the audit of a STOP ended in an exception: " + KindOf(failure));
    }
    written->set_value();
  });
  static_cast<void>(written->get_future().wait_for(kAuditOfStop));
}

void ConsoleHandler::AuditDone(const RequestGate::Passed& passed, const std::string& body_subject, int status) {
  const auto in_path = passed.path.find(passed.route->audit_parameter);
  const std::string& subject = in_path == passed.path.end() ? body_subject : in_path->second;
  parts_.audit.Done(passed.caller, passed.route->audit_action, subject,
                    status < 400 ? "ok" : "failed with " + std::to_string(status));
}

void ConsoleHandler::NoteRefusal(const RequestGate::Refused& refused, const std::string& method) {
  if (!refused.by_rule) return;
  const std::string what = refused.route == nullptr ? method : method + " " + refused.route->pattern;
  parts_.audit.Refused(refused.caller, what, std::to_string(refused.error.status) + ", " + refused.error.error.seen);
}

std::optional<HttpResponse> ConsoleHandler::Open(const HttpRequest& request,
                                                 const std::shared_ptr<WebSocketPeer>& peer) {
  auto caller = parts_.gate.CheckSocket(request);
  if (!caller) {
    NoteRefusal(caller.error(), "WebSocket");
    HttpResponse response = ErrorAnswer(caller.error().error);
    AddSecurityHeaders(response, AnswerKind::kApi, request.loopback);
    return response;
  }
  {
    const std::lock_guard lock(mutex_);
    sockets_[peer] = *caller;
  }
  parts_.live.Join(peer, *caller);
  return std::nullopt;
}

void ConsoleHandler::Received(const std::shared_ptr<WebSocketPeer>& peer, std::string_view text) {
  Status taken;
  try {
    taken = TakeMessage(peer, text);
  } catch (const std::exception& failure) {
    Log(LogLevel::kError, "console: a message ended in an exception: " + KindOf(failure));
    taken = Fail("take the message", "the program is wrong", "tell the makers what you did");
  }
  if (taken) return;
  const Json answer{{"type", "error"}, {"error", ErrorJson(taken.error())}};
  peer->SendText(std::make_shared<const std::string>(answer.dump(-1, ' ', false, Json::error_handler_t::replace)));
}

Status ConsoleHandler::TakeMessage(const std::shared_ptr<WebSocketPeer>& peer, std::string_view text) {
  const auto message = ParseJsonObject(text);
  if (!message) return tl::unexpected(message.error().error);
  const auto type = TextField(*message, "type", 32);
  if (!type) return tl::unexpected(type.error().error);
  if (*type == "ping") {
    static const auto kPong = std::make_shared<const std::string>(R"({"type":"pong"})");
    peer->SendText(kPong);
    return {};
  }
  if (*type == "subscribe") {
    const auto step = NumberField(*message, "sensor_step", 1, 6);
    if (!step) return tl::unexpected(step.error().error);
    const int whole = static_cast<int>(*step);
    if (whole != *step || 6 % whole != 0) {
      return Fail("read 'sensor_step' of the message", "it divides 6 not", "give 1, 2, 3 or 6");
    }
    parts_.live.Subscribe(peer, whole);
    return {};
  }
  if (*type != "jog") return Fail("take the message", "its type is unknown", "send jog, subscribe or ping");
  const auto direction = TextField(*message, "direction", 8);
  if (!direction) return tl::unexpected(direction.error().error);
  Caller caller;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = sockets_.find(peer); found != sockets_.end()) caller = found->second;
  }
  return Jog(caller, *direction);
}

Status ConsoleHandler::Jog(const Caller& caller, const std::string& direction) {
  const std::string attempted = "move the carriage by hand";
  if (direction != "up" && direction != "down") return Fail(attempted, "the direction is not up or down", "give one");
  if (caller.role != StationRole::kTechnician || !caller.loopback || !parts_.sessions.Use(caller.session_id)) {
    parts_.audit.Refused(caller, "jog", "no technician's session on the booth's own screen");
    return Fail(attempted, "only a technician may, on the booth's own screen", "log in there");
  }
  if (const auto holder = parts_.sessions.TakeControl(caller.session_id)) {
    return Fail(attempted, "another session of user '" + *holder + "' works with the booth", "let it log out");
  }
  return parts_.jog(direction == "up" ? Scanner::JogDirection::kUp : Scanner::JogDirection::kDown);
}

void ConsoleHandler::Closed(const std::shared_ptr<WebSocketPeer>& peer) {
  parts_.live.Leave(peer);
  const std::lock_guard lock(mutex_);
  sockets_.erase(peer);
}

void ConsoleHandler::Refused(const std::string& peer, const std::string& reason) {
  const bool loopback = peer == "127.0.0.1" || peer == "::1";
  parts_.audit.Refused({"", StationRole::kNone, "", loopback, peer}, "connection", reason);
}

}  // namespace annulus
