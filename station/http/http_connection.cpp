#include "station/http/http_connection.h"

#include <openssl/err.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <exception>
#include <optional>
#include <string_view>
#include <utility>

#include "base/log.h"
#include "station/http/http_answer.h"
#include "station/http/request_reader.h"
#include "station/http/socket_peer.h"

namespace annulus {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using Tcp = asio::ip::tcp;
using ErrorCode = boost::system::error_code;
using std::chrono::milliseconds;

constexpr std::size_t kReadBytes = 16 << 10;
/// Of an answer, for which the client has HttpLimits::write.
constexpr std::size_t kPieceBytes = 256 << 10;
/// Of a body, that go along with its head.
constexpr std::size_t kTogetherBytes = 12 << 10;
constexpr int kSendBufferBytes = 256 << 10;
constexpr milliseconds kLingerTime{1000};
/// For the other side's goodbye.
constexpr milliseconds kGoodbyeTime{2000};
/// Texts of one WebSocket that wait for the handler; beyond that it is not read.
constexpr int kMaxBacklog = 16;
/// Of a ping, in requests (PeerBudget).
constexpr double kControlFrameCost = 0.25;

/// A socket, with TLS or without. Beast's AsyncStream.
class EitherStream {
 public:
  using executor_type = Tcp::socket::executor_type;

  EitherStream(Tcp::socket socket, ssl_ctx_st* context) {
    if (context == nullptr) {
      plain_.emplace(std::move(socket));
      return;
    }
    SSL_CTX_up_ref(context);
    asio::ssl::context borrowed(context);
    tls_.emplace(std::move(socket), borrowed);
  }

  executor_type get_executor() { return Socket().get_executor(); }
  Tcp::socket& Socket() { return tls_ ? tls_->next_layer() : *plain_; }
  [[nodiscard]] bool tls() const { return tls_.has_value(); }
  asio::ssl::stream<Tcp::socket>& Tls() { return *tls_; }

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    if (tls_) {
      tls_->async_read_some(buffers, std::forward<Handler>(handler));
    } else {
      plain_->async_read_some(buffers, std::forward<Handler>(handler));
    }
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    if (tls_) {
      tls_->async_write_some(buffers, std::forward<Handler>(handler));
    } else {
      plain_->async_write_some(buffers, std::forward<Handler>(handler));
    }
  }

 private:
  std::optional<Tcp::socket> plain_;
  std::optional<asio::ssl::stream<Tcp::socket>> tls_;
};

// What Beast's WebSocket asks of a stream of one's own.
void beast_close_socket(EitherStream& stream) {
  ErrorCode ignored;
  stream.Socket().close(ignored);
}

template <class Handler>
void async_teardown(beast::role_type /*role*/, EitherStream& stream, Handler&& handler) {
  if (stream.tls()) {
    stream.Tls().async_shutdown(std::forward<Handler>(handler));
    return;
  }
  ErrorCode error;
  stream.Socket().shutdown(Tcp::socket::shutdown_both, error);
  asio::post(stream.get_executor(), beast::bind_front_handler(std::forward<Handler>(handler), error));
}

PeerBudget::Time Now() { return std::chrono::steady_clock::now().time_since_epoch(); }

/// The handler's answer; what throws is ours to own up to.
template <class Work>
auto Guarded(const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::exception& error) {
    Log(LogLevel::kError, std::string("console: a request's handler failed: ") + error.what());
  } catch (...) {
    Log(LogLevel::kError, "console: a request's handler failed");
  }
  return ProblemAnswer({500, "the console itself failed"});
}

/// The same for calls without an answer.
template <class Work>
void Quietly(const Work& work) {
  (void)Guarded([&] {
    work();
    return HttpResponse{};
  });
}

class Connection final : public HttpConnection, public std::enable_shared_from_this<Connection> {
 public:
  Connection(asio::io_context& io, Tcp::socket socket, ssl_ctx_st* tls, HttpPeer peer, HttpConnectionHost& host,
             std::function<void(HttpConnection&)> ended)
      : io_(io),
        timer_(io),
        stream_(std::in_place, std::move(socket), tls),
        peer_(std::move(peer)),
        host_(host),
        limits_(host.limits()),
        ended_(std::move(ended)),
        reader_(limits_) {}

  void Start() override;
  void Stop() override;
  void Abort() override { End(); }

 private:
  enum class Phase { kHandshake, kHead, kBody, kHandler, kAnswer, kLinger, kWebSocket, kEnded };
  enum class Interrupt { kNone, kTooSlow, kStopped };
  using Socket = beast::websocket::stream<EitherStream>;

  // Any phase.
  void SetDeadline(milliseconds span);
  void ClearDeadline();
  void OnDeadline();
  void InterruptRead(Interrupt why);
  void End();
  Tcp::socket& Lowest() { return web_socket_ ? web_socket_->next_layer().Socket() : stream_->Socket(); }
  template <class Member>
  auto Bind(Member member);

  // A request.
  void OnHandshake(const ErrorCode& error);
  void ExplainTls();
  void BeginRequest();
  void Read();
  void OnRead(const ErrorCode& error, std::size_t bytes);
  void OnInterrupted();
  void Proceed();
  void TakeHead();
  void BeginBody();
  void Dispatch();
  void Refuse(const HttpProblem& problem, double cost);

  // Its answer.
  void Answer(HttpResponse response);
  void Write(std::string_view bytes);
  void OnWritten(const ErrorCode& error);
  void BeginLinger();
  void ShutAndDrain();
  void Drain();
  void GiveRoom();

  // WebSocket.
  void OpenWebSocket();
  void AcceptWebSocket();
  void OnControlFrame();
  void ReadMessage();
  void OnMessage(const ErrorCode& error);
  void Deliver(std::string text);
  void Flush();
  void OnMessageSent(const ErrorCode& error, const SocketPeer::Message& message);
  void SayGoodbye(const SocketPeer::Goodbye& goodbye);

  asio::io_context& io_;
  asio::steady_timer timer_;
  std::uint64_t deadline_ = 0;  ///< Counts deadlines: one that was replaced is known by its number.
  std::optional<EitherStream> stream_;
  const HttpPeer peer_;
  HttpConnectionHost& host_;
  const HttpLimits& limits_;
  std::function<void(HttpConnection&)> ended_;
  Phase phase_ = Phase::kHandshake;
  Interrupt interrupt_ = Interrupt::kNone;
  bool stopping_ = false;
  bool spoke_ = false;  ///< It has sent at least one head.

  std::array<char, kReadBytes> block_{};
  RequestReader reader_;
  bool keep_alive_ = false;  ///< What the request asks for.
  bool head_only_ = false;
  std::size_t room_ = 0;  ///< Taken of the host.

  std::string answer_head_;
  std::string answer_body_;
  std::size_t written_ = 0;  ///< Of the body.
  AfterAnswer after_ = AfterAnswer::kClose;

  std::optional<Socket> web_socket_;
  std::shared_ptr<SocketPeer> socket_peer_;
  beast::flat_buffer message_;
  beast::http::request<beast::http::empty_body> handshake_;
  bool accepted_ = false;
  bool sending_ = false;
  bool reading_ = false;
  bool said_goodbye_ = false;
  int backlog_ = 0;
};

/// A completion handler that keeps the connection.
template <class Member>
auto Connection::Bind(Member member) {
  return beast::bind_front_handler(member, shared_from_this());
}

void Connection::Start() {
  SetDeadline(limits_.handshake);
  if (!stream_->tls()) {
    BeginRequest();
    return;
  }
  stream_->Tls().async_handshake(asio::ssl::stream_base::server, Bind(&Connection::OnHandshake));
}

void Connection::SetDeadline(milliseconds span) {
  const std::uint64_t number = ++deadline_;
  timer_.expires_after(span);
  timer_.async_wait([self = shared_from_this(), number](const ErrorCode& error) {
    if (!error && number == self->deadline_) self->OnDeadline();
  });
}

void Connection::ClearDeadline() {
  ++deadline_;
  timer_.cancel();
}

void Connection::OnDeadline() {
  switch (phase_) {
    case Phase::kHandshake:
      (void)host_.budget().Spend(peer_.key, PeerBudget::kBadRequestCost, Now());
      host_.Refused(peer_.address, peer_.key, "TLS handshake too slow");
      End();
      break;
    case Phase::kHead:
    case Phase::kBody:
      InterruptRead(Interrupt::kTooSlow);
      break;
    case Phase::kAnswer:
      host_.Refused(peer_.address, peer_.key, "an answer was not taken in time");
      End();
      break;
    case Phase::kLinger:
    case Phase::kWebSocket:
      End();
      break;
    case Phase::kHandler:
    case Phase::kEnded:
      break;
  }
}

/// Ends the read that is under way, so that nothing else uses the stream when the answer goes out. OnRead goes on.
void Connection::InterruptRead(Interrupt why) {
  if (interrupt_ != Interrupt::kNone) {
    End();  // the read would not be ended
    return;
  }
  interrupt_ = why;
  ErrorCode ignored;
  Lowest().cancel(ignored);
  SetDeadline(kLingerTime);
}

void Connection::Stop() {
  stopping_ = true;
  switch (phase_) {
    case Phase::kHandshake:
      End();
      break;
    case Phase::kHead:
    case Phase::kBody:
      if (interrupt_ == Interrupt::kNone) InterruptRead(Interrupt::kStopped);
      break;
    case Phase::kWebSocket:
      SayGoodbye({1001, "the console ends"});
      break;
    default:
      break;
  }
}

void Connection::End() {
  if (phase_ == Phase::kEnded) return;
  phase_ = Phase::kEnded;
  const auto self = shared_from_this();
  ClearDeadline();
  ErrorCode ignored;
  Lowest().close(ignored);
  GiveRoom();
  if (socket_peer_ && socket_peer_->MarkEnded() == SocketPeer::State::kOpen) {
    host_.Run(HttpLane::kLive, [self, peer = socket_peer_] { Quietly([&] { self->host_.handler().Closed(peer); }); });
  }
  if (!spoke_) (void)host_.budget().Spend(peer_.key, PeerBudget::kRequestCost, Now());
  ended_(*this);
}

// A request.

void Connection::OnHandshake(const ErrorCode& error) {
  if (phase_ == Phase::kEnded) return;
  if (!error) {
    BeginRequest();
    return;
  }
  spoke_ = true;
  (void)host_.budget().Spend(peer_.key, PeerBudget::kBadRequestCost, Now());
  host_.Refused(peer_.address, peer_.key, "TLS handshake failed");
  const bool plain_http = error.category() == asio::error::get_ssl_category() &&
                          ERR_GET_REASON(static_cast<unsigned long>(error.value())) == SSL_R_HTTP_REQUEST;
  if (plain_http) {
    ExplainTls();
  } else {
    End();
  }
}

/// Somebody has typed "http://": told in plain text, below TLS. It fits the empty buffer of a new socket.
void Connection::ExplainTls() {
  static constexpr std::string_view kAnswer =
      "HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain\r\nContent-Length: 59\r\nConnection: close\r\n\r\n"
      "The console speaks HTTPS: begin its address with https://.\n";
  ErrorCode error;
  Lowest().non_blocking(true, error);
  Lowest().write_some(asio::buffer(kAnswer), error);
  phase_ = Phase::kLinger;
  SetDeadline(kLingerTime);
  ShutAndDrain();
}

void Connection::BeginRequest() {
  phase_ = Phase::kHead;
  head_only_ = false;
  reader_.Begin();
  if (stopping_) {
    BeginLinger();
    return;
  }
  if (reader_.empty()) {
    SetDeadline(limits_.idle);
    Read();
  } else {
    // Pipelined (RFC 9112 §9.3.2): one after the other.
    SetDeadline(limits_.header);
    Proceed();
  }
}

void Connection::Read() { stream_->async_read_some(asio::buffer(block_), Bind(&Connection::OnRead)); }

void Connection::OnRead(const ErrorCode& error, std::size_t bytes) {
  if (phase_ == Phase::kEnded) return;
  if (interrupt_ != Interrupt::kNone) {
    OnInterrupted();
    return;
  }
  if (error) {
    // Gone. In between requests that is how connections end.
    BeginLinger();
    return;
  }
  if (phase_ == Phase::kHead && reader_.empty()) SetDeadline(limits_.header);
  reader_.Append({block_.data(), bytes});
  Proceed();
}

void Connection::OnInterrupted() {
  const bool begun = phase_ == Phase::kBody || !reader_.empty();
  if (interrupt_ == Interrupt::kTooSlow && begun) {
    Refuse({408, "the request did not come in time"}, PeerBudget::kBadRequestCost);
  } else {
    BeginLinger();
  }
}

void Connection::Proceed() {
  switch (reader_.Next()) {
    case RequestReader::Event::kMore:
      Read();
      break;
    case RequestReader::Event::kHead:
      TakeHead();
      break;
    case RequestReader::Event::kDone:
      Dispatch();
      break;
    case RequestReader::Event::kRefused:
      Refuse(reader_.problem(), PeerBudget::kBadRequestCost);
      break;
  }
}

void Connection::TakeHead() {
  spoke_ = true;
  HttpHead& head = reader_.head();
  keep_alive_ = head.keep_alive;
  head_only_ = head.head_only;
  head.request.peer = peer_.address;
  head.request.loopback = peer_.loopback;
  head.request.tls = stream_->tls();
  const std::string account = host_.IsUrgent(head.request.path) ? peer_.key + " urgent" : peer_.key;
  if (!host_.budget().Spend(account, PeerBudget::kRequestCost, Now())) {
    Refuse({429, "too many requests of this address"}, 0.0);
  } else if (head.web_socket) {
    OpenWebSocket();
  } else if (head.framing == HttpFraming::kNone) {
    Dispatch();
  } else {
    BeginBody();
  }
}

void Connection::BeginBody() {
  phase_ = Phase::kBody;
  SetDeadline(limits_.body);
  const std::size_t bytes = reader_.BodyBytes();
  if (bytes > limits_.body_bytes) {
    if (!host_.TakeRoom(bytes)) {
      Refuse({503, "too many large bodies at once"}, 0.0);
      return;
    }
    room_ = bytes;
  }
  if (!reader_.head().expects_continue || !reader_.empty()) {
    Proceed();
    return;
  }
  static constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
  asio::async_write(*stream_, asio::buffer(kContinue),
                    [self = shared_from_this()](const ErrorCode& error, std::size_t) {
                      if (self->phase_ == Phase::kEnded) return;
                      if (error) {
                        self->End();
                      } else if (self->interrupt_ != Interrupt::kNone) {
                        self->OnInterrupted();
                      } else {
                        self->Read();
                      }
                    });
}

void Connection::Dispatch() {
  phase_ = Phase::kHandler;
  ClearDeadline();
  const HttpLane lane = host_.IsUrgent(reader_.head().request.path) ? HttpLane::kUrgent : HttpLane::kRequests;
  auto request = std::make_shared<HttpRequest>(std::move(reader_.head().request));
  const bool taken = host_.Run(lane, [self = shared_from_this(), request] {
    HttpResponse response = Guarded([&] { return self->host_.handler().Handle(*request); });
    request->body = {};
    asio::post(self->io_, [self, response = std::move(response)]() mutable { self->Answer(std::move(response)); });
  });
  if (!taken) End();
}

void Connection::Refuse(const HttpProblem& problem, double cost) {
  spoke_ = true;
  const PeerBudget::Time now = Now();
  if (cost > 0.0) (void)host_.budget().Spend(peer_.key, cost, now);
  host_.Refused(peer_.address, peer_.key, problem.reason);
  HttpResponse response = ProblemAnswer(problem);
  if (problem.status == 429) {
    response.headers.emplace_back("Retry-After", std::to_string(host_.budget().RetryAfterSeconds(peer_.key, now)));
  }
  if (problem.status == 503) response.headers.emplace_back("Retry-After", "5");
  keep_alive_ = false;
  Answer(std::move(response));
}

// Its answer.

void Connection::Answer(HttpResponse response) {
  if (phase_ == Phase::kEnded) return;
  phase_ = Phase::kAnswer;
  GiveRoom();
  after_ = keep_alive_ && !stopping_ ? AfterAnswer::kKeepAlive : AfterAnswer::kClose;
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  try {
    answer_head_ = AnswerHead(response, after_, now);
  } catch (const std::exception& error) {
    Log(LogLevel::kError, std::string("console: a request's answer is malformed: ") + error.what());
    response = ProblemAnswer({500, "the console itself failed"});
    answer_head_ = AnswerHead(response, after_, now);
  }
  answer_body_ = head_only_ || IsBodiless(response.status) ? std::string() : std::move(response.body);
  // A small body goes along with its head: one TLS record, one packet.
  written_ = std::min(answer_body_.size(), kTogetherBytes);
  answer_head_.append(answer_body_, 0, written_);
  Write(answer_head_);
}

/// One buffer at a time: of several, Beast's TLS stream writes only a first that is empty, and nothing would go on.
void Connection::Write(std::string_view bytes) {
  SetDeadline(limits_.write);
  asio::async_write(*stream_, asio::buffer(bytes.data(), bytes.size()),
                    [self = shared_from_this()](const ErrorCode& error, std::size_t) { self->OnWritten(error); });
}

void Connection::OnWritten(const ErrorCode& error) {
  if (phase_ == Phase::kEnded) return;
  if (error) {
    End();
    return;
  }
  if (written_ < answer_body_.size()) {
    const std::string_view piece = std::string_view(answer_body_).substr(written_, kPieceBytes);
    written_ += piece.size();
    Write(piece);
    return;
  }
  answer_body_ = {};
  if (after_ == AfterAnswer::kKeepAlive) {
    BeginRequest();
  } else {
    BeginLinger();
  }
}

void Connection::BeginLinger() {
  phase_ = Phase::kLinger;
  SetDeadline(kLingerTime);
  if (!stream_->tls()) {
    ShutAndDrain();
    return;
  }
  stream_->Tls().async_shutdown([self = shared_from_this()](const ErrorCode&) {
    if (self->phase_ != Phase::kEnded) self->ShutAndDrain();
  });
}

void Connection::ShutAndDrain() {
  ErrorCode error;
  Lowest().shutdown(Tcp::socket::shutdown_send, error);
  if (error) {
    End();
  } else {
    Drain();
  }
}

void Connection::Drain() {
  Lowest().async_read_some(asio::buffer(block_), [self = shared_from_this()](const ErrorCode& error, std::size_t) {
    if (self->phase_ == Phase::kEnded) return;
    if (error) {
      self->End();
    } else {
      self->Drain();
    }
  });
}

void Connection::GiveRoom() { host_.GiveRoom(std::exchange(room_, 0)); }

// WebSocket.

void Connection::OpenWebSocket() {
  if (!reader_.empty()) {
    Refuse({400, "a WebSocket that speaks before it is open"}, PeerBudget::kBadRequestCost);
    return;
  }
  phase_ = Phase::kHandler;
  ClearDeadline();
  const auto request = std::make_shared<HttpRequest>(std::move(reader_.head().request));
  handshake_ = {beast::http::verb::get, "/", 11};
  handshake_.set(beast::http::field::host, std::string(*request->Header("host")));
  handshake_.set(beast::http::field::upgrade, "websocket");
  handshake_.set(beast::http::field::connection, "upgrade");
  handshake_.set(beast::http::field::sec_websocket_version, "13");
  handshake_.set(beast::http::field::sec_websocket_key, std::string(*request->Header("sec-websocket-key")));
  socket_peer_ = std::make_shared<SocketPeer>(limits_.socket_queue_bytes, [weak = weak_from_this(), &io = io_] {
    asio::post(io, [weak] {
      if (const auto self = weak.lock()) self->Flush();
    });
  });
  const bool taken = host_.Run(HttpLane::kLive, [self = shared_from_this(), peer = socket_peer_, request] {
    HttpHandler& handler = self->host_.handler();
    auto refusal = Guarded([&]() -> std::optional<HttpResponse> { return handler.Open(*request, peer); });
    if (refusal) {
      peer->MarkEnded();
      asio::post(self->io_, [self, refusal = std::move(*refusal)]() mutable { self->Answer(std::move(refusal)); });
    } else if (!peer->MarkOpen()) {
      Quietly([&] { handler.Closed(peer); });
    } else {
      asio::post(self->io_, [self] { self->AcceptWebSocket(); });
    }
  });
  if (!taken) End();
}

void Connection::AcceptWebSocket() {
  if (phase_ == Phase::kEnded) return;
  if (stopping_) {
    End();
    return;
  }
  phase_ = Phase::kWebSocket;
  web_socket_.emplace(std::move(*stream_));
  stream_.reset();
  // A ping goes out after half of `idle_timeout` without a word, and the other half is for its answer.
  beast::websocket::stream_base::timeout timeout{};
  timeout.handshake_timeout = limits_.write;
  timeout.idle_timeout = 2 * limits_.socket_ping;
  timeout.keep_alive_pings = true;
  web_socket_->set_option(timeout);
  web_socket_->read_message_max(limits_.socket_message_bytes);
  web_socket_->auto_fragment(false);
  web_socket_->control_callback([this](beast::websocket::frame_type, beast::string_view) { OnControlFrame(); });
  web_socket_->async_accept(handshake_, [self = shared_from_this()](const ErrorCode& error) {
    if (self->phase_ == Phase::kEnded) return;
    if (error) {
      self->End();
      return;
    }
    self->accepted_ = true;
    self->ReadMessage();
    self->Flush();
  });
}

/// Pings are answered by Beast; a flood of them is not. Called within a read: what ends the connection comes after it.
void Connection::OnControlFrame() {
  if (host_.budget().Spend(peer_.key, kControlFrameCost, Now())) return;
  asio::post(io_, [self = shared_from_this()] {
    if (self->phase_ != Phase::kEnded) self->SayGoodbye({1008, "too many frames"});
  });
}

void Connection::ReadMessage() {
  if (reading_ || backlog_ >= kMaxBacklog) return;
  reading_ = true;
  web_socket_->async_read(message_, [self = shared_from_this()](const ErrorCode& error, std::size_t) {
    self->reading_ = false;
    if (self->phase_ != Phase::kEnded) self->OnMessage(error);
  });
}

void Connection::OnMessage(const ErrorCode& error) {
  if (error) {
    End();
    return;
  }
  std::string text = beast::buffers_to_string(message_.data());
  message_.consume(message_.size());
  if (said_goodbye_) {
    ReadMessage();
  } else if (!web_socket_->got_text()) {
    host_.Refused(peer_.address, peer_.key, "bytes over a WebSocket");
    SayGoodbye({1003, "texts only"});
  } else if (!host_.budget().Spend(peer_.key, PeerBudget::kRequestCost, Now())) {
    host_.Refused(peer_.address, peer_.key, "too many texts over a WebSocket");
    SayGoodbye({1008, "too many texts"});
  } else {
    Deliver(std::move(text));
  }
}

void Connection::Deliver(std::string text) {
  ++backlog_;
  host_.Run(HttpLane::kLive, [self = shared_from_this(), peer = socket_peer_, text = std::move(text)] {
    Quietly([&] { self->host_.handler().Received(peer, text); });
    asio::post(self->io_, [self] {
      --self->backlog_;
      if (self->phase_ == Phase::kWebSocket && self->accepted_) self->ReadMessage();
    });
  });
  ReadMessage();
}

/// Sends the next message, one at a time.
void Connection::Flush() {
  if (phase_ == Phase::kEnded || !socket_peer_) return;
  if (socket_peer_->TakeWake()) {
    host_.Refused(peer_.address, peer_.key, "a WebSocket left too much unread");
    End();
    return;
  }
  if (!accepted_ || sending_ || said_goodbye_) return;
  SocketPeer::Next next = socket_peer_->Take();
  if (next.message) {
    sending_ = true;
    web_socket_->text(!next.message->binary);
    const SocketPeer::Message& message = *next.message;
    const auto buffer = asio::buffer(*message.bytes);
    web_socket_->async_write(buffer, [self = shared_from_this(), message](const ErrorCode& error, std::size_t) {
      self->OnMessageSent(error, message);
    });
  } else if (next.goodbye) {
    SayGoodbye(*next.goodbye);
  }
}

void Connection::OnMessageSent(const ErrorCode& error, const SocketPeer::Message& message) {
  sending_ = false;
  if (phase_ == Phase::kEnded) return;
  if (error) {
    End();
    return;
  }
  socket_peer_->Sent(message);
  Flush();
}

void Connection::SayGoodbye(const SocketPeer::Goodbye& goodbye) {
  if (said_goodbye_) return;
  SetDeadline(kGoodbyeTime);
  if (!accepted_) {
    socket_peer_->Close(goodbye.code, goodbye.reason);  // said once the handshake is out
    return;
  }
  said_goodbye_ = true;
  const beast::websocket::close_reason reason(static_cast<beast::websocket::close_code>(goodbye.code), goodbye.reason);
  web_socket_->async_close(reason, [self = shared_from_this()](const ErrorCode&) { self->End(); });
  ReadMessage();
}

}  // namespace

std::shared_ptr<HttpConnection> MakeHttpConnection(asio::io_context& io, sim::OwnedFd socket, bool ipv6,
                                                   std::shared_ptr<ssl_ctx_st> tls, HttpPeer peer,
                                                   HttpConnectionHost& host,
                                                   std::function<void(HttpConnection&)> ended) {
  Tcp::socket tcp(io);
  ErrorCode error;
  tcp.assign(ipv6 ? Tcp::v6() : Tcp::v4(), socket.get(), error);
  if (error) return nullptr;
  socket.Release();
  tcp.set_option(Tcp::no_delay(true), error);
  // Bounded, so that what a client leaves unread is counted and not hidden in the kernel.
  tcp.set_option(asio::socket_base::send_buffer_size(kSendBufferBytes), error);
  return std::make_shared<Connection>(io, std::move(tcp), tls.get(), std::move(peer), host, std::move(ended));
}

}  // namespace annulus
