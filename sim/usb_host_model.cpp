#include "sim/usb_host_model.h"

#include <algorithm>
#include <map>
#include <utility>

#include "base/ensure.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kLongAgo{0};

tl::unexpected<UsbFailure> FailWith(UsbStatus status, std::string detail = {}) {
  return tl::unexpected<UsbFailure>(UsbFailure{status, std::move(detail)});
}

}  // namespace

/// One opening of a board. Lives on after an unplug, but then only tells how its transfers ended.
class UsbHostModel::Port final : public UsbPort {
 public:
  Port(UsbHostModel& host, Slot& slot) : host_(host), board_(slot.board), identity_(slot.identity), slot_(&slot) {
    slot.port = this;
    host_.ports_.push_back(this);
  }
  ~Port() override {
    host_.leaked_transfers_ += in_flight();
    if (board_ != nullptr) {
      for (const auto& [token, length] : lengths_) board_->Cancel({token});
      Collect();
      slot_->port = nullptr;
    }
    for (const auto& [token, length] : lengths_) host_.memory_used_ -= length;
    std::erase(host_.ports_, this);
  }
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;

  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }

  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length, nanoseconds timeout) override {
    host_.Advance();
    if (board_ == nullptr) return FailWith(UsbStatus::kNoDevice);
    return board_->ControlIn(request, length, timeout);
  }
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data, nanoseconds timeout) override {
    host_.Advance();
    if (board_ == nullptr) return FailWith(UsbStatus::kNoDevice);
    return board_->ControlOut(request, data, timeout);
  }
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) override {
    host_.Advance();
    if (board_ == nullptr) return FailWith(UsbStatus::kNoDevice);
    if (host_.transfer_memory_ > 0 && host_.memory_used_ + length > host_.transfer_memory_) {
      return FailWith(UsbStatus::kNoMemory, "usbfs_memory_mb is used up");
    }
    auto token = board_->SubmitBulkIn(endpoint, length);
    if (!token) return token;
    lengths_[token->value] = length;
    host_.memory_used_ += length;
    return token;
  }
  void Cancel(UsbToken token) override {
    host_.Advance();
    if (board_ != nullptr) board_->Cancel(token);
  }
  UsbResult<void> ClearHalt(std::uint8_t endpoint) override {
    host_.Advance();
    if (board_ == nullptr) return FailWith(UsbStatus::kNoDevice);
    return board_->ClearHalt(endpoint);
  }
  std::optional<UsbCompletion> WaitCompletion(nanoseconds deadline) override {
    while (true) {
      host_.Advance();
      if (board_ != nullptr && ended_.empty()) {
        // No longer than to the next plug event: it may be this board's.
        if (auto completion = board_->WaitCompletion(std::min(deadline, host_.NextEvent()))) {
          ended_.push_back(std::move(*completion));
        }
        host_.Advance();
      }
      if (!ended_.empty()) break;
      if (host_.clock_.Now() >= deadline) return std::nullopt;
      if (board_ == nullptr) host_.clock_.SleepUntil(std::min(deadline, host_.NextEvent()));
    }
    UsbCompletion completion = std::move(ended_.front());
    ended_.pop_front();
    const auto length = lengths_.find(completion.token.value);
    host_.memory_used_ -= length->second;
    lengths_.erase(length);
    return completion;
  }
  [[nodiscard]] std::size_t in_flight() const override { return lengths_.size(); }

  /// The board is gone: what was in flight has ended, and nothing else happens here any more.
  void Die() {
    Collect();
    board_ = nullptr;
    slot_->port = nullptr;
  }

 private:
  void Collect() {
    while (auto completion = board_->WaitCompletion(kLongAgo)) ended_.push_back(std::move(*completion));
  }

  UsbHostModel& host_;
  RingBoardModel* board_;  ///< Null after an unplug.
  UsbIdentity identity_;
  Slot* slot_;
  std::map<std::uint64_t, std::size_t> lengths_;  ///< Of the transfers not collected, by token.
  std::deque<UsbCompletion> ended_;
};

void UsbHostModel::Add(RingBoardModel& board) {
  Slot slot;
  slot.board = &board;
  slot.identity = board.identity();
  slots_.push_back(std::move(slot));
}

void UsbHostModel::Schedule(const Event& event) {
  ENSURE(event.board < slots_.size(), "the board was added");
  const auto after = std::upper_bound(plan_.begin(), plan_.end(), event,
                                      [](const Event& a, const Event& b) { return a.time < b.time; });
  plan_.insert(after, event);
}

void UsbHostModel::UnplugAt(std::size_t board, nanoseconds time) { Schedule({time, board, false, {}}); }

void UsbHostModel::PlugAt(std::size_t board, nanoseconds time, nanoseconds not_ready) {
  Schedule({time, board, true, not_ready});
}

void UsbHostModel::SetIdentity(std::size_t board, std::string serial, std::string port_path) {
  slots_.at(board).identity.serial = std::move(serial);
  slots_.at(board).identity.port_path = std::move(port_path);
}

std::size_t UsbHostModel::open_ports() const { return ports_.size(); }

nanoseconds UsbHostModel::NextEvent() const { return plan_.empty() ? nanoseconds::max() : plan_.front().time; }

void UsbHostModel::Advance() {
  while (!plan_.empty() && plan_.front().time <= clock_.Now()) {
    const Event event = plan_.front();
    plan_.pop_front();
    Happen(event);
  }
}

void UsbHostModel::Happen(const Event& event) {
  Slot& slot = slots_[event.board];
  if (slot.plugged == event.plug) return;
  slot.plugged = event.plug;
  if (event.plug) {
    slot.board->PlugIn();
    slot.arrived = event.time;
    slot.not_ready = event.not_ready;
  } else {
    slot.board->UnplugAt(event.time);
    if (slot.port != nullptr) slot.port->Die();
  }
  hotplugs_.push_back({event.plug ? UsbHotplug::Kind::kArrived : UsbHotplug::Kind::kLeft, slot.identity, event.time});
}

UsbResult<std::vector<UsbIdentity>> UsbHostModel::List() {
  Advance();
  std::vector<UsbIdentity> listed;
  for (const Slot& slot : slots_) {
    if (slot.plugged) listed.push_back(slot.identity);
  }
  return listed;
}

UsbResult<std::unique_ptr<UsbPort>> UsbHostModel::Open(const UsbIdentity& identity) {
  Advance();
  ++open_attempts_;
  Slot* found = nullptr;
  for (Slot& slot : slots_) {
    const bool here = slot.identity.port_path == identity.port_path;
    const bool wanted = identity.serial.empty() ? here : slot.identity.serial == identity.serial;
    if (slot.plugged && wanted && (found == nullptr || here)) found = &slot;
  }
  if (found == nullptr) {
    const std::string name = identity.serial.empty() ? DeviceName(identity) : identity.serial;
    return FailWith(UsbStatus::kNoDevice, "no ring board " + name + " is plugged in");
  }
  const nanoseconds waited = clock_.Now() - found->arrived;
  if (waited < found->not_ready / 2) return FailWith(UsbStatus::kError, "LIBUSB_ERROR_NOT_FOUND");
  if (waited < found->not_ready) return FailWith(UsbStatus::kNoAccess, "LIBUSB_ERROR_ACCESS");
  if (found->port != nullptr) return FailWith(UsbStatus::kBusy, "LIBUSB_ERROR_BUSY");
  std::unique_ptr<UsbPort> port = std::make_unique<Port>(*this, *found);
  return wrap ? wrap(std::move(port)) : std::move(port);
}

std::optional<UsbHotplug> UsbHostModel::WaitHotplug(nanoseconds deadline) {
  while (true) {
    Advance();
    if (!hotplugs_.empty()) {
      UsbHotplug hotplug = std::move(hotplugs_.front());
      hotplugs_.pop_front();
      return hotplug;
    }
    if (clock_.Now() >= deadline) return std::nullopt;
    clock_.SleepUntil(std::min(deadline, NextEvent()));
  }
}

}  // namespace annulus::sim
