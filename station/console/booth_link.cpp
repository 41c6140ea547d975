#include "station/console/booth_link.h"

#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <condition_variable>
#include <deque>
#include <future>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>
#include <variant>

#include "acquisition/scan_machine.h"
#include "base/clock.h"
#include "base/log.h"
#include "sim/unix_socket.h"
#include "station/booth_client.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr milliseconds kAnswerWithin{3000};        ///< Of an order, from the caller's point of view.
constexpr milliseconds kConnectWithin{1000};       ///< To somebody who listens.
constexpr milliseconds kTryAgain{500};             ///< While nobody does.
constexpr milliseconds kLook{10};                  ///< Longest that an order waits for the thread to look up.
constexpr milliseconds kOneAfterAnother{1000};     ///< For boothd to notice that our last session has ended.
constexpr std::chrono::seconds kTechnicianFor{3};  ///< After the technician's last order, the operator's session again.
constexpr std::chrono::seconds kAskForControl{1};  ///< Between attempts while another program has it.

tl::unexpected<Error> Away(const std::string& why) {
  return Fail("ask the booth", why, "see whether boothd runs; nothing was sent to it");
}

/// Cancel on a connection that has said nothing else: boothd takes it from everybody.
Status CancelOn(const std::string& path, nanoseconds deadline) {
  const auto fd = sim::ConnectUnixSocket(path, deadline);
  if (!fd) return Fail(fd);
  const auto frame = BoothFrame(EncodeRequest({1, CancelOrder{}}));
  if (!frame || ::send(fd->get(), frame->data(), frame->size(), MSG_NOSIGNAL) != static_cast<ssize_t>(frame->size())) {
    return Away("the cancel could not be sent");
  }
  BoothFrameReader frames{kMaxBoothMessage};
  std::array<char, 4096> bytes;
  while (true) {
    const auto text = frames.Next();
    if (!text) return Fail(text);
    if (*text) {
      const auto message = DecodeMessage(**text);
      if (!message) return Fail(message);
      if (const auto* reply = std::get_if<ReplyMessage>(&*message)) return reply->result;
      if (const auto* bye = std::get_if<ByeMessage>(&*message)) return Away(bye->reason);
      continue;
    }
    const auto left = std::chrono::ceil<milliseconds>(deadline - SystemClock().Now()).count();
    pollfd ready{fd->get(), POLLIN, 0};
    if (left <= 0 || ::poll(&ready, 1, static_cast<int>(left)) <= 0) return Away("it did not answer a cancel");
    const ssize_t got = ::recv(fd->get(), bytes.data(), bytes.size(), 0);
    if (got <= 0) return Away("it hung up on a cancel");
    frames.Append({bytes.data(), static_cast<std::size_t>(got)});
  }
}

class LinkThread final : public BoothLink {
 public:
  LinkThread(std::string socket, Events events) : socket_(std::move(socket)), events_(std::move(events)) {
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
  ~LinkThread() override {
    thread_.request_stop();
    thread_.join();
    {
      const std::lock_guard lock(mutex_);
      status_.reset();
    }
    FailAll("the console ends");
  }

  Status Ask(const BoothOrder& order) override { return Submit(order, BoothRole::kOperator); }
  Status AskAsTechnician(const BoothOrder& order) override { return Submit(order, BoothRole::kTechnician); }
  Status Cancel() override {
    const Status cancelled = CancelOn(socket_, clock_.Now() + kConnectWithin);
    // A boothd with no connection left to give still has ours.
    return cancelled ? cancelled : Submit(CancelOrder{}, BoothRole::kOperator);
  }
  [[nodiscard]] std::optional<StatusMessage> status() const override {
    const std::lock_guard lock(mutex_);
    return status_;
  }
  [[nodiscard]] std::optional<BoothDescription> booth() const override {
    const std::lock_guard lock(mutex_);
    return booth_;
  }
  [[nodiscard]] std::string why() const override {
    const std::lock_guard lock(mutex_);
    return why_;
  }
  [[nodiscard]] bool start_agreed() const override {
    const std::lock_guard lock(mutex_);
    return pressed_at_ && clock_.Now() - *pressed_at_ < scan_time::kStartAgreed;
  }

 private:
  struct Pending {
    BoothOrder order;
    BoothRole role = BoothRole::kOperator;
    nanoseconds deadline{0};
    std::promise<Status> answer;
  };

  Status Submit(const BoothOrder& order, BoothRole role) {
    Pending pending;
    pending.order = order;
    pending.role = role;
    pending.deadline = clock_.Now() + kAnswerWithin;
    std::future<Status> answer = pending.answer.get_future();
    {
      const std::lock_guard lock(mutex_);
      if (!status_) return Away(why_);
      pending_.push_back(std::move(pending));
    }
    return answer.get();
  }

  void Run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      if (!client_ && !Connect(BoothRole::kOperator, stop)) {
        std::unique_lock lock(mutex_);
        wake_.wait_for(lock, stop, kTryAgain, [] { return false; });
        continue;
      }
      Listen();
      CarryOutOrders(stop);
      ReturnToOperator(stop);
      AskForControl(stop);
    }
  }

  /// A session in this role, with control if it can be had. Tells of the loss if there is nobody.
  bool Connect(BoothRole role, const std::stop_token& stop) {
    const nanoseconds deadline = clock_.Now() + kOneAfterAnother;
    const bool switching = client_.has_value();
    client_.reset();
    HelloOrder hello{role, true, "annulus serve"};
    auto client = BoothClient::Connect(socket_, hello, kConnectWithin);
    // Our last session may still seem to be there; and boothd may only be starting.
    while (!client && switching && clock_.Now() < deadline && !stop.stop_requested()) {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, kLook, [] { return false; });
      lock.unlock();
      client = BoothClient::Connect(socket_, hello, kConnectWithin);
    }
    if (!client) {
      hello.control = false;
      auto viewer = BoothClient::Connect(socket_, hello, kConnectWithin / 4);
      const bool controlled = viewer && viewer->status().controlled;
      if (controlled) client = std::move(viewer);
    }
    if (!client) {  // boothd has only come up between the two: nobody has control
      hello.control = true;
      client = BoothClient::Connect(socket_, hello, kConnectWithin / 4);
    }
    if (client) {
      if (const Status subscribed = client->Ask(SubscribeOrder{1, 1}, kConnectWithin); !subscribed) {
        client = Fail(subscribed);
      }
    }
    if (!client) return Lose(client.error().seen);
    client_.emplace(std::move(*client));
    role_ = role;
    control_asked_ = clock_.Now();
    Welcome(switching);
    return true;
  }

  void Welcome(bool switching) {
    {
      const std::lock_guard lock(mutex_);
      booth_ = client_->booth();
      why_.clear();
    }
    lost_told_ = false;
    if (!switching && events_.connected) events_.connected(client_->booth());
    Take(client_->status());
  }

  /// Always false.
  bool Lose(const std::string& why) {
    client_.reset();
    {
      const std::lock_guard lock(mutex_);
      status_.reset();
      booth_.reset();
      pressed_at_.reset();
      why_ = why;
    }
    FailAll(why);
    if (!lost_told_) {
      lost_told_ = true;
      Log(LogLevel::kWarning, "boothd is away: " + why);
      if (events_.lost) events_.lost(why);
    }
    return false;
  }

  /// One message, or as many as are there.
  void Listen() {
    auto message = client_->Next(kLook);
    while (message && *message) {
      Dispatch(std::move(**message));
      message = client_->Next(nanoseconds(0));
    }
    if (!message) Lose(message.error().seen);
  }

  void Dispatch(BoothMessage&& message) {
    if (const auto* status = std::get_if<StatusMessage>(&message)) {
      Take(*status);
    } else if (const auto* level = std::get_if<LevelMessage>(&message)) {
      if (events_.level) events_.level(*level);
    } else if (const auto* result = std::get_if<ResultMessage>(&message)) {
      if (events_.result) events_.result(*result);
    }
  }

  void Take(const StatusMessage& status) {
    {
      const std::lock_guard lock(mutex_);
      NoteKey(status.scanner);
      status_ = status;
    }
    if (events_.status) events_.status(status);
  }

  /// Keeps when the start key was pressed while this was armed. With the lock held.
  void NoteKey(const ScannerStatus& now) {
    const bool armed_anew = !status_ || status_->scanner.version != now.version;
    if (armed_anew || now.state != ScanState::kArmed) {
      pressed_at_.reset();
    } else if (now.start_presses > status_->scanner.start_presses) {
      pressed_at_ = clock_.Now();
    }
  }

  void CarryOutOrders(const std::stop_token& stop) {
    while (client_) {
      Pending next;
      {
        const std::lock_guard lock(mutex_);
        if (pending_.empty()) return;
        next = std::move(pending_.front());
        pending_.pop_front();
      }
      next.answer.set_value(CarryOut(next, stop));
    }
  }

  Status CarryOut(const Pending& one, const std::stop_token& stop) {
    const bool technician = one.role == BoothRole::kTechnician;
    if (technician) technician_asked_ = clock_.Now();
    if (technician && role_ != BoothRole::kTechnician && !Connect(BoothRole::kTechnician, stop)) return Away(why());
    // We only look on if somebody else had control when we came, perhaps a session of ours that boothd has missed
    // since.
    const bool looks_on = !client_->controls() && !std::holds_alternative<CancelOrder>(one.order);
    if (looks_on && !Connect(role_, stop)) return Away(why());
    const nanoseconds left = one.deadline - clock_.Now();
    if (left <= nanoseconds(0)) return Away("it was busy with other orders for too long");
    return client_->Ask(one.order, left);
  }

  void ReturnToOperator(const std::stop_token& stop) {
    if (!client_ || role_ == BoothRole::kOperator || clock_.Now() - technician_asked_ < kTechnicianFor) return;
    if (client_->status().scanner.state != ScanState::kJog) Connect(BoothRole::kOperator, stop);
  }

  void AskForControl(const std::stop_token& stop) {
    if (!client_ || client_->controls() || client_->status().controlled) return;
    if (clock_.Now() - control_asked_ >= kAskForControl) Connect(role_, stop);
  }

  void FailAll(const std::string& why) {
    std::deque<Pending> left;
    {
      const std::lock_guard lock(mutex_);
      left.swap(pending_);
    }
    for (Pending& one : left) one.answer.set_value(Away(why));
  }

  const std::string socket_;
  const Events events_;
  SystemClock clock_;

  // Of the thread alone.
  std::optional<BoothClient> client_;
  BoothRole role_ = BoothRole::kOperator;
  nanoseconds technician_asked_{0};
  nanoseconds control_asked_{0};
  bool lost_told_ = false;

  mutable std::mutex mutex_;  ///< Of what follows.
  std::condition_variable_any wake_;
  std::deque<Pending> pending_;
  std::optional<StatusMessage> status_;
  std::optional<BoothDescription> booth_;
  std::string why_ = "boothd has not been reached yet";
  std::optional<nanoseconds> pressed_at_;

  std::jthread thread_;  ///< Last: it ends first.
};

}  // namespace

std::unique_ptr<BoothLink> BoothLink::Make(std::string socket, Events events) {
  return std::make_unique<LinkThread>(std::move(socket), std::move(events));
}

}  // namespace annulus
