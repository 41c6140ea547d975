#include "station/http/http_server.h"

#include <pthread.h>

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <exception>
#include <future>
#include <list>
#include <thread>
#include <unordered_set>
#include <utility>

#include "base/log.h"
#include "station/http/http_connection.h"
#include "station/http/listen_sockets.h"
#include "station/http/tls_context.h"
#include "station/http/worker_lane.h"

namespace annulus {
namespace {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;
using ErrorCode = boost::system::error_code;

/// When the program has no descriptor left: tried again after this.
constexpr std::chrono::milliseconds kAcceptPause{100};
/// For answers that are under way at the end.
constexpr std::chrono::milliseconds kLastAnswers{1000};

class Server final : public HttpServer, public HttpConnectionHost {
 public:
  Server(HttpServerOptions options, HttpHandler& handler)
      : options_(std::move(options)),
        handler_(handler),
        budget_(options_.limits),
        requests_("http-work", static_cast<std::size_t>(std::max(options_.worker_threads, 1))),
        urgent_("http-stop", 1),
        live_("http-live", 1) {}
  ~Server() override;

  Status Listen();

  // HttpServer.
  [[nodiscard]] std::uint16_t port() const override { return port_; }
  Status SetIdentity(const std::string& certificate_pem, const std::string& private_key_pem) override;

  // HttpConnectionHost.
  [[nodiscard]] const HttpLimits& limits() const override { return options_.limits; }
  [[nodiscard]] HttpHandler& handler() override { return handler_; }
  [[nodiscard]] PeerBudget& budget() override { return budget_; }
  [[nodiscard]] bool IsUrgent(const std::string& path) const override {
    return std::find(options_.urgent_paths.begin(), options_.urgent_paths.end(), path) != options_.urgent_paths.end();
  }
  bool Run(HttpLane lane, std::function<void()> work) override;
  void Refused(const std::string& address, const std::string& key, const std::string& reason) override;
  bool TakeRoom(std::size_t bytes) override;
  void GiveRoom(std::size_t bytes) override { room_taken_ -= bytes; }

 private:
  struct Listener {
    Tcp::acceptor acceptor;
    asio::steady_timer pause;
    bool ipv6 = false;
  };

  void Accept(Listener& listener);
  void Take(Listener& listener, Tcp::socket socket);
  void RunIo();
  void OnEnded(HttpConnection& connection);
  template <class Work>
  void OnIoThread(const Work& work);

  const HttpServerOptions options_;
  HttpHandler& handler_;
  std::uint16_t port_ = 0;
  asio::io_context io_{1};
  asio::executor_work_guard<asio::io_context::executor_type> stay_{io_.get_executor()};

  // By the io thread only, once it runs.
  PeerBudget budget_;
  std::shared_ptr<ssl_ctx_st> tls_;
  std::list<Listener> listeners_;
  std::unordered_map<HttpConnection*, std::pair<std::shared_ptr<HttpConnection>, std::string>> connections_;
  std::size_t room_taken_ = 0;
  std::promise<void>* all_ended_ = nullptr;

  WorkerLane requests_;
  WorkerLane urgent_;
  WorkerLane live_;
  std::jthread io_thread_;
};

PeerBudget::Time Now() { return std::chrono::steady_clock::now().time_since_epoch(); }

Status Server::Listen() {
  const bool plain = options_.certificate_pem.empty() && options_.private_key_pem.empty();
  if (!plain) {
    auto context = MakeTlsContext(options_.certificate_pem, options_.private_key_pem);
    if (!context) return Fail(context);
    tls_ = std::move(*context);
  }
  auto sockets = OpenListenSockets(options_.addresses, options_.port);
  if (!sockets) return Fail(sockets);
  port_ = PortOf(sockets->front());
  for (ListenSocket& socket : *sockets) {
    Listener& listener = listeners_.emplace_back(Listener{Tcp::acceptor(io_), asio::steady_timer(io_), socket.ipv6});
    ErrorCode error;
    listener.acceptor.assign(socket.ipv6 ? Tcp::v6() : Tcp::v4(), socket.fd.get(), error);
    if (error) return Fail("listen on " + socket.address, error.message(), "start the console again");
    socket.fd.Release();
    Accept(listener);
  }
  io_thread_ = std::jthread([this] { RunIo(); });
  (void)::pthread_setname_np(io_thread_.native_handle(), "http-io");
  return {};
}

void Server::RunIo() {
  while (true) {
    try {
      io_.run();
      return;
    } catch (const std::exception& error) {
      // No memory for one connection must not end the others.
      Log(LogLevel::kError, std::string("console: a connection failed: ") + error.what());
    }
  }
}

void Server::Accept(Listener& listener) {
  listener.acceptor.async_accept([this, &listener](const ErrorCode& error, Tcp::socket socket) {
    if (!listener.acceptor.is_open()) return;
    if (!error) {
      Take(listener, std::move(socket));
      Accept(listener);
      return;
    }
    if (error == asio::error::connection_aborted) {
      Accept(listener);
      return;
    }
    // Mostly: too many open files.
    listener.pause.expires_after(kAcceptPause);
    listener.pause.async_wait([this, &listener](const ErrorCode& cancelled) {
      if (!cancelled && listener.acceptor.is_open()) Accept(listener);
    });
  });
}

void Server::Take(Listener& listener, Tcp::socket socket) {
  ErrorCode error;
  const Tcp::endpoint remote = socket.remote_endpoint(error);
  if (error) return;  // gone already
  HttpPeer peer{remote.address().to_string(), {}, remote.address().is_loopback()};
  peer.key = budget_.KeyOf(peer.address, Now());
  const std::string problem = budget_.AddConnection(peer.key, peer.loopback, Now());
  if (!problem.empty()) {
    Refused(peer.address, peer.key, problem);
    return;
  }
  const std::string key = peer.key;
  auto connection = MakeHttpConnection(io_, sim::OwnedFd(socket.release(error)), listener.ipv6, tls_, std::move(peer),
                                       *this, [this](HttpConnection& ended) { OnEnded(ended); });
  if (connection == nullptr) {
    budget_.RemoveConnection(key);
    return;
  }
  connections_.emplace(connection.get(), std::pair(connection, key));
  connection->Start();
}

void Server::OnEnded(HttpConnection& connection) {
  const auto found = connections_.find(&connection);
  if (found == connections_.end()) return;
  budget_.RemoveConnection(found->second.second);
  connections_.erase(found);
  if (connections_.empty() && all_ended_ != nullptr) std::exchange(all_ended_, nullptr)->set_value();
}

bool Server::Run(HttpLane lane, std::function<void()> work) {
  switch (lane) {
    case HttpLane::kUrgent:
      return urgent_.Run(std::move(work));
    case HttpLane::kLive:
      return live_.Run(std::move(work));
    case HttpLane::kRequests:
      break;
  }
  return requests_.Run(std::move(work));
}

void Server::Refused(const std::string& address, const std::string& key, const std::string& reason) {
  if (!budget_.MayReport(key, Now())) return;
  requests_.Run([this, address, reason] {
    try {
      handler_.Refused(address, reason);
    } catch (const std::exception& error) {
      Log(LogLevel::kError, std::string("console: the audit of a refusal failed: ") + error.what());
    }
  });
}

bool Server::TakeRoom(std::size_t bytes) {
  if (bytes > options_.limits.large_bodies_bytes - room_taken_) return false;
  room_taken_ += bytes;
  return true;
}

Status Server::SetIdentity(const std::string& certificate_pem, const std::string& private_key_pem) {
  auto context = MakeTlsContext(certificate_pem, private_key_pem);
  if (!context) return Fail(context);
  OnIoThread([&] { tls_ = *context; });
  return {};
}

/// Runs `work` there and waits for its end.
template <class Work>
void Server::OnIoThread(const Work& work) {
  const auto done = std::make_shared<std::promise<void>>();
  asio::post(io_, [&work, done] {
    work();
    done->set_value();
  });
  done->get_future().wait();
}

Server::~Server() {
  if (!io_thread_.joinable()) return;
  std::promise<void> all_ended;
  std::future<void> ended = all_ended.get_future();
  OnIoThread([&] {
    for (Listener& listener : listeners_) {
      ErrorCode ignored;
      listener.acceptor.close(ignored);
      listener.pause.cancel();
    }
    all_ended_ = &all_ended;
    // Those that end at once leave the map.
    std::vector<std::shared_ptr<HttpConnection>> connections;
    for (const auto& [pointer, entry] : connections_) connections.push_back(entry.first);
    if (connections.empty()) std::exchange(all_ended_, nullptr)->set_value();
    for (const auto& connection : connections) connection->Stop();
  });
  (void)ended.wait_for(kLastAnswers);
  OnIoThread([&] {
    all_ended_ = nullptr;
    std::vector<std::shared_ptr<HttpConnection>> connections;
    for (const auto& [pointer, entry] : connections_) connections.push_back(entry.first);
    for (const auto& connection : connections) connection->Abort();
  });
  requests_.Stop(WorkerLane::Leftover::kDrop);
  urgent_.Stop(WorkerLane::Leftover::kFinish);
  // The last calls of all WebSockets.
  live_.Stop(WorkerLane::Leftover::kFinish);
  stay_.reset();
  io_.stop();
  io_thread_.join();
}

}  // namespace

Result<std::unique_ptr<HttpServer>> HttpServer::Make(HttpServerOptions options, HttpHandler& handler) {
  auto server = std::make_unique<Server>(std::move(options), handler);
  RETURN_IF_ERROR(server->Listen());
  return server;
}

}  // namespace annulus
