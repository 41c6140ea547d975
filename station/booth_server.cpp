#include "station/booth_server.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/log.h"
#include "station/booth_json.h"
#include "station/booth_peer.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

template <class... Handlers>
struct Overloaded : Handlers... {
  using Handlers::operator()...;
};
template <class... Handlers>
Overloaded(Handlers...) -> Overloaded<Handlers...>;  // clang 14 does not find it by itself

/// The status without what changes all the time.
std::string Discrete(StatusMessage message) {
  message.scanner.done = message.scanner.z_mm = 0.0;
  message.scanner.longest_tick = nanoseconds(0);
  return EncodeMessage(message);
}

LevelMessage Preview(const ScanLevel& level, std::uint32_t sensor_step) {
  LevelMessage preview{level.index, level.sweep, level.time, 0.0, sensor_step, {}};
  for (const RangeReading& reading : level.readings) preview.z_mm += reading.z_mm;
  preview.z_mm /= static_cast<double>(std::max<std::size_t>(1, level.readings.size()));
  for (std::size_t sensor = 0; sensor < level.readings.size(); sensor += sensor_step) {
    preview.range_mm.push_back(level.readings[sensor].range_mm);
  }
  return preview;
}

const char* NameOf(const BoothOrder& order) {
  return std::visit(
      Overloaded{[](const HelloOrder&) { return "hello"; }, [](const HomeOrder&) { return "home"; },
                 [](const ArmOrder&) { return "arm"; }, [](const StartOrder&) { return "start"; },
                 [](const CancelOrder&) { return "cancel"; }, [](const AcknowledgeOrder&) { return "acknowledge"; },
                 [](const JogOrder&) { return "jog"; }, [](const SubscribeOrder&) { return "subscribe"; },
                 [](const StatusOrder&) { return "status"; }, [](const UnknownOrder&) { return "?"; }},
      order);
}

tl::unexpected<Error> Refused(const BoothOrder& order, std::string seen, std::string advice) {
  return Fail(std::string("carry out '") + NameOf(order) + "'", std::move(seen), std::move(advice));
}

}  // namespace

class BoothServer::Impl {
 public:
  Impl(BoothSocket socket, sim::OwnedFd wake, BoothPort& port, LevelMailbox& levels)
      : socket_(std::move(socket)), wake_(std::move(wake)), port_(port), levels_(levels) {}

  void Serve(const std::stop_token& stop) {
    const std::stop_callback waker(stop, [this] {
      const std::uint64_t one = 1;
      [[maybe_unused]] const auto written = ::write(wake_.get(), &one, sizeof(one));
    });
    while (!stop.stop_requested()) {
      Wait();
      Connect();
      for (const auto& peer : peers_) TakeRequests(*peer);
      PassPreviews();
      Reap();
      if (Now() >= next_look_) LookAtBooth();
    }
    for (const auto& peer : peers_) peer->End("boothd ends");
    Reap();
  }

 private:
  [[nodiscard]] nanoseconds Now() const { return clock_.Now(); }
  void Wait();
  void Connect();
  void TakeRequests(BoothPeer& peer);
  void Answer(BoothPeer& peer, const BoothRequest& request);
  Status Welcome(BoothPeer& peer, std::uint64_t id, const HelloOrder& hello);
  /// Whether this session may give this order at all.
  Status Allowed(const BoothPeer& peer, const BoothOrder& order) const;
  Status CarryOut(BoothPeer& peer, const BoothOrder& order);
  Status Subscribe(BoothPeer& peer, const SubscribeOrder& order);
  void PassPreviews();
  void Reap();
  /// Sends the status if it is time to, and a result if there is a new one.
  void LookAtBooth();
  [[nodiscard]] StatusMessage StatusNow() const;
  [[nodiscard]] std::size_t Sessions() const {
    return static_cast<std::size_t>(
        std::count_if(peers_.begin(), peers_.end(), [](const auto& peer) { return peer->hello.has_value(); }));
  }
  [[nodiscard]] bool Controlled() const {
    return std::any_of(peers_.begin(), peers_.end(), [](const auto& peer) { return peer->controls; });
  }
  void SendToSessions(const std::string& text) {
    for (const auto& peer : peers_) {
      if (peer->hello) peer->SendText(text);
    }
  }

  SystemClock clock_;
  BoothSocket socket_;
  sim::OwnedFd wake_;
  BoothPort& port_;
  LevelMailbox& levels_;
  std::vector<std::unique_ptr<BoothPeer>> peers_;
  bool somebody_waits_ = false;
  nanoseconds accept_after_{0};
  nanoseconds next_look_{0};
  nanoseconds last_sent_{0};
  std::string last_status_;    ///< As sent.
  std::string last_discrete_;  ///< Of it.
  std::string last_result_;
};

void BoothServer::Impl::Wait() {
  // A connection that could not be taken (no descriptor is left) is looked at again later, not all the time.
  const bool pause = Now() < accept_after_;
  std::vector<pollfd> watched{
      {wake_.get(), POLLIN, 0}, {levels_.signal(), POLLIN, 0}, {pause ? -1 : socket_.fd(), POLLIN, 0}};
  for (const auto& peer : peers_) {
    watched.push_back({peer->fd(), static_cast<short>(peer->waits_to_write() ? POLLIN | POLLOUT : POLLIN), 0});
  }
  const bool alone = peers_.empty() && !pause;
  const auto left = std::chrono::ceil<milliseconds>((pause ? accept_after_ : next_look_) - Now());
  const int timeout = alone ? -1 : static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 1000));
  // An interruption or a lack of memory is nothing that a look at everything could not cope with.
  if (::poll(watched.data(), watched.size(), timeout) < 0) return;
  somebody_waits_ = watched[2].revents != 0;
  for (std::size_t k = 0; k < peers_.size(); ++k) {
    const auto events = watched[k + 3].revents;
    if ((events & POLLOUT) != 0) peers_[k]->Flush();
    if ((events & (POLLIN | POLLHUP | POLLERR)) != 0) peers_[k]->Receive();
  }
}

void BoothServer::Impl::Connect() {
  if (!std::exchange(somebody_waits_, false)) return;
  // One a round: whoever connects in a loop does not keep the others waiting.
  auto connection = socket_.Accept();
  if (connection.fd.get() < 0) {
    accept_after_ = Now() + booth_limit::kLook;
    return;
  }
  auto peer = std::make_unique<BoothPeer>(std::move(connection), Now());
  if (peers_.size() == booth_limit::kConnections) {
    peer->End("there are too many connections");
    return;
  }
  Log(LogLevel::kInfo, "booth socket: process " + std::to_string(peer->credentials().pid) + " of user " +
                           std::to_string(peer->credentials().uid) + " connected");
  peers_.push_back(std::move(peer));
}

void BoothServer::Impl::TakeRequests(BoothPeer& peer) {
  while (const auto text = peer.NextRequest()) {
    const bool affordable = peer.budget.Take(Now());
    const auto request = DecodeRequest(*text);
    if (!request) {
      peer.Send(ReplyMessage{request.error().id, tl::unexpected(request.error().error)});
    } else if (affordable || std::holds_alternative<CancelOrder>(request->order)) {
      Answer(peer, *request);
    } else {
      peer.Send(ReplyMessage{request->id, Refused(request->order, "too many requests", "send fewer")});
    }
    if (peer.budget.refused() > booth_limit::kRefusals) peer.End("too many requests");
  }
}

void BoothServer::Impl::Answer(BoothPeer& peer, const BoothRequest& request) {
  if (const auto* hello = std::get_if<HelloOrder>(&request.order)) {
    const Status welcome = Welcome(peer, request.id, *hello);
    if (!welcome) peer.Send(ReplyMessage{request.id, welcome});
    return;
  }
  Status result = Allowed(peer, request.order);
  if (result) result = CarryOut(peer, request.order);
  peer.Send(ReplyMessage{request.id, result});
  next_look_ = Now();
}

Status BoothServer::Impl::Welcome(BoothPeer& peer, std::uint64_t id, const HelloOrder& hello) {
  if (peer.hello) return Refused(hello, "this session has said hello", "open another connection");
  const auto viewers = Sessions() - (Controlled() ? 1 : 0);
  if (hello.control && Controlled()) {
    return Refused(hello, "another session controls the booth", "end that one, or look on without control");
  }
  if (!hello.control && viewers == booth_limit::kViewers) {
    return Refused(hello, std::to_string(viewers) + " sessions look on already", "close one of them");
  }
  if (Sessions() == 0) {
    // A result from before anybody looked is in the status, and no news.
    const ScannerStatus status = port_.status();
    last_result_ = status.scan ? EncodeMessage(ResultMessage{*status.scan}) : "";
  }
  peer.hello = hello;
  peer.controls = hello.control;
  peer.Send(WelcomeMessage{id, hello.control, port_.description()});
  peer.SendText(EncodeMessage(StatusNow()));
  next_look_ = Now();
  Log(LogLevel::kInfo, "booth socket: hello of '" + hello.client + "'" + (hello.control ? ", which controls" : ""));
  return {};
}

Status BoothServer::Impl::Allowed(const BoothPeer& peer, const BoothOrder& order) const {
  if (std::holds_alternative<CancelOrder>(order)) return {};
  if (!peer.hello) return Refused(order, "this session has not said hello", "send hello first");
  if (std::holds_alternative<StatusOrder>(order) || std::holds_alternative<SubscribeOrder>(order)) return {};
  if (!peer.controls) return Refused(order, "this session only looks on", "say hello with control");
  if (std::holds_alternative<JogOrder>(order) && peer.hello->role != BoothRole::kTechnician) {
    return Refused(order, "this session is an operator's", "log in as a technician");
  }
  return {};
}

Status BoothServer::Impl::CarryOut(BoothPeer& peer, const BoothOrder& order) {
  return std::visit(
      Overloaded{[&](const HelloOrder&) { return Status{}; }, [&](const HomeOrder&) { return port_.Home(); },
                 [&](const ArmOrder& arm) { return port_.Arm(arm); },
                 [&](const StartOrder& start) { return port_.Start(start.version); },
                 [&](const CancelOrder&) { return port_.Cancel(); },
                 [&](const AcknowledgeOrder&) {
                   return port_.Acknowledge(peer.hello->role == BoothRole::kTechnician ? CauseRole::kService
                                                                                       : CauseRole::kOperator);
                 },
                 [&](const JogOrder& jog) {
                   peer.has_jogged = true;
                   return port_.Jog(jog.direction);
                 },
                 [&](const SubscribeOrder& subscribe) { return Subscribe(peer, subscribe); },
                 [&](const StatusOrder&) {
                   peer.SendText(EncodeMessage(StatusNow()));
                   return Status{};
                 },
                 [&](const UnknownOrder& unknown) -> Status {
                   return Fail("carry out '" + Clipped(unknown.type, 64) + "'", "no such order here",
                               "see docs/wire_protocol.md");
                 }},
      order);
}

Status BoothServer::Impl::Subscribe(BoothPeer& peer, const SubscribeOrder& order) {
  peer.previews = order;
  levels_.Want();
  return {};
}

void BoothServer::Impl::PassPreviews() {
  levels_.ClearSignal();
  ScanLevel level;
  while (levels_.Take(level)) {
    for (const auto& peer : peers_) {
      const SubscribeOrder& wanted = peer->previews;
      if (wanted.levels == 0 || level.index % wanted.levels != 0) continue;
      peer->Send(Preview(level, wanted.sensors));
    }
  }
}

void BoothServer::Impl::Reap() {
  const nanoseconds now = Now();
  for (const auto& peer : peers_) {
    if (!peer->hello && !peer->ended() && now - peer->since > booth_limit::kHelloWithin) peer->End("no hello came");
  }
  for (const auto& peer : peers_) {
    if (!peer->ended() || !peer->controls) continue;
    // Hold to run: whoever held is gone. A scan goes on, with nobody in the way of the next one who takes control.
    if (peer->has_jogged && port_.status().state == ScanState::kJog) static_cast<void>(port_.Cancel());
    peer->controls = false;
  }
  const auto gone =
      std::stable_partition(peers_.begin(), peers_.end(), [now](const auto& p) { return !p->finished(now); });
  for (auto peer = gone; peer != peers_.end(); ++peer) {
    Log(LogLevel::kInfo, "booth socket: process " + std::to_string((*peer)->credentials().pid) + " is gone");
    next_look_ = now;
  }
  peers_.erase(gone, peers_.end());
  const bool wanted =
      std::any_of(peers_.begin(), peers_.end(), [](const auto& peer) { return peer->previews.levels > 0; });
  if (!wanted) levels_.Refuse();
}

StatusMessage BoothServer::Impl::StatusNow() const {
  return {port_.status(), Controlled(), static_cast<std::uint32_t>(Sessions())};
}

void BoothServer::Impl::LookAtBooth() {
  const nanoseconds now = Now();
  next_look_ = now + booth_limit::kLook;
  if (Sessions() == 0) return;
  const StatusMessage status = StatusNow();
  std::string text = EncodeMessage(status);
  std::string discrete = Discrete(status);
  const nanoseconds since = now - last_sent_;
  const bool news = discrete != last_discrete_ || (text != last_status_ && since >= booth_limit::kStatusAtMost);
  if (news || since >= booth_limit::kStatusEvery) {
    SendToSessions(text);
    last_sent_ = now;
    last_status_ = std::move(text);
    last_discrete_ = std::move(discrete);
  }
  const std::string result = status.scanner.scan ? EncodeMessage(ResultMessage{*status.scanner.scan}) : "";
  if (result != last_result_ && !result.empty()) SendToSessions(result);
  last_result_ = result;
}

BoothServer::BoothServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BoothServer::~BoothServer() = default;

Result<std::unique_ptr<BoothServer>> BoothServer::Make(BoothSocket socket, BoothPort& port, LevelMailbox& levels) {
  sim::OwnedFd wake(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (wake.get() < 0) return Fail("serve the booth", std::strerror(errno), "free file descriptors");
  return std::unique_ptr<BoothServer>(
      new BoothServer(std::make_unique<Impl>(std::move(socket), std::move(wake), port, levels)));
}

void BoothServer::Serve(const std::stop_token& stop) { impl_->Serve(stop); }

}  // namespace annulus
