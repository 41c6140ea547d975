#include "firmware_iface/can_ring_bus.h"

#include <algorithm>
#include <utility>

#include "base/log.h"
#include "firmware_iface/little_endian.h"
#include "firmware_iface/ring_objects.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// How long a full transmit queue is put up with, and how often it is tried.
constexpr nanoseconds kSendPatience = milliseconds(20);
constexpr nanoseconds kSendPause = milliseconds(1);
/// After an answer that did not come: time in which a late one is thrown away.
constexpr nanoseconds kQuietTime = milliseconds(20);
/// Calls of Collect that empty the longest queue of the kernel; a flood may go on for ever.
constexpr int kMostCollects = 32;
constexpr int kMostLogLines = 10;  ///< Per second.
constexpr std::uint8_t kExpeditedSerialReply = 0x43;
/// Boards of one node id that are remembered; two are too many already.
constexpr std::size_t kMostSerials = 4;

CanNodeState StateOf(NmtState state) {
  switch (state) {
    case NmtState::kOperational:
      return CanNodeState::kOperational;
    case NmtState::kStopped:
      return CanNodeState::kStopped;
    case NmtState::kBootUp:
    case NmtState::kPreOperational:
      break;
  }
  return CanNodeState::kPreOperational;
}

const char* AdviceFor(CanFault fault) {
  switch (fault) {
    case CanFault::kQueueFull:
      return "check that the boards are on and the bus is terminated; raise the interface's txqueuelen";
    case CanFault::kDown:
      return "bring the CAN interface up, then start again";
    case CanFault::kGone:
      return "plug the CAN adapter in again, then start again";
    case CanFault::kError:
      break;
  }
  return "check the CAN adapter, then start again";
}

}  // namespace

const char* CanNodeStateText(CanNodeState state) {
  switch (state) {
    case CanNodeState::kSilent:
      return "not ready: it has said nothing since power-up";
    case CanNodeState::kPreOperational:
      return "pre-operational";
    case CanNodeState::kOperational:
      return "operational";
    case CanNodeState::kStopped:
      return "stopped";
    case CanNodeState::kLost:
      return "lost: its heartbeat is missing";
  }
  return "in an unknown state";
}

CanRingBus::CanRingBus(CanBus& bus, NodeId last_node, Clock& clock) : bus_(bus), clock_(clock) {
  const auto link = bus_.ReadLink();
  name_ = link && !link->name.empty() ? link->name : "CAN bus";
  if (link) EnterState(link->state, clock_.Now());
  for (NodeId node = 1; node <= last_node; ++node) nodes_.emplace(node, CanNode());
}

void CanRingBus::AddBeside(NodeId node) {
  beside_ = node;
  nodes_.emplace(node, CanNode());
}

std::string CanRingBus::NodeName(NodeId node) const {
  const auto known = node_names_.find(node);
  return known != node_names_.end() ? known->second : "node " + std::to_string(node) + " on " + name_;
}

void CanRingBus::RaiseFault(std::string attempted, std::string seen, std::string advice) {
  if (!fault_) fault_ = Error{std::move(attempted), std::move(seen), std::move(advice)};
}

void CanRingBus::RaiseBoardFault(NodeId node, std::string seen, std::string advice) {
  const std::string attempted = "read " + NodeName(node);
  const bool hazard = nodes_.at(node).emergency == kEmergencyEmitter;
  if (node == beside_ && !hazard) {
    nodes_.at(node).trouble = attempted + ": " + seen;
    return LogLimited(nodes_.at(node).trouble);
  }
  if (!fault_) fault_is_of_a_board_ = true;
  RaiseFault(attempted, std::move(seen), std::move(advice));
}

void CanRingBus::Note(const CanFailure& failure, const std::string& attempted) {
  RaiseFault(attempted, name_ + ": " + CanFailureText(failure), AdviceFor(failure.fault));
  if (failure.fault == CanFault::kDown || failure.fault == CanFault::kGone) health_.state = CanState::kDown;
}

CanResult<void> CanRingBus::Rebind() {
  auto bound = bus_.Reopen();
  if (!bound) return bound;
  const auto link = bus_.ReadLink();
  if (!link) return tl::unexpected<CanFailure>(link.error());
  health_.passive_since.reset();
  EnterState(link->state, clock_.Now());
  return {};
}

void CanRingBus::ForgetNodes() {
  for (auto& [id, node] : nodes_) node = CanNode();
}

Status CanRingBus::Send(const CanFrame& frame, const std::string& attempted) {
  const nanoseconds give_up = clock_.Now() + kSendPatience;
  auto sent = bus_.Send(frame);
  while (!sent && sent.error().fault == CanFault::kQueueFull && clock_.Now() < give_up) {
    const nanoseconds next_try = std::min(give_up, clock_.Now() + kSendPause);
    Collect(next_try);
    clock_.SleepUntil(next_try);
    sent = bus_.Send(frame);
  }
  if (sent) return {};
  Note(sent.error(), attempted);
  return Fail(attempted, name_ + ": " + CanFailureText(sent.error()), AdviceFor(sent.error().fault));
}

bool CanRingBus::Collect(nanoseconds deadline) {
  return CollectUntil(deadline, [] { return false; });
}

bool CanRingBus::Step(nanoseconds deadline) {
  auto received = bus_.Receive(deadline);
  if (!received) {
    Note(received.error(), "receive from " + name_);
    // A failed bus answers at once: without a pause a wait for it would not pass any time.
    clock_.SleepUntil(std::min(deadline, clock_.Now() + kSendPause));
    return false;
  }
  if (!*received) return false;
  const CanReception& reception = **received;
  if (const auto* report = std::get_if<CanReport>(&reception.what)) {
    TakeReport(*report, reception.host_time);
  } else {
    TakeFrame(std::get<CanFrame>(reception.what), reception.host_time);
  }
  return true;
}

void CanRingBus::TakeFrame(const CanFrame& frame, nanoseconds host_time) {
  if (const auto node = LevelNodeOf(frame); node && nodes_.count(*node) != 0) {
    return nodes_.at(*node).levels.Push(frame, host_time);
  }
  if (const auto beat = DecodeHeartbeat(frame); beat && nodes_.count(beat->node) != 0) {
    return TakeHeartbeat(*beat, host_time);
  }
  if (const auto emergency = DecodeEmergency(frame); emergency && nodes_.count(emergency->node) != 0) {
    return TakeEmergency(*emergency);
  }
  const auto reply = static_cast<std::uint32_t>(CobId::kSdoReply);
  if (IsCanopenFrame(frame) && frame.id > reply && frame.id <= reply + kLastNodeId &&
      nodes_.count(static_cast<NodeId>(frame.id - reply)) != 0) {
    return TakeSdoReply(static_cast<NodeId>(frame.id - reply), frame, host_time);
  }
  if (!DecodeSync(frame)) ++health_.foreign_frames;
}

void CanRingBus::TakeHeartbeat(const Heartbeat& beat, nanoseconds host_time) {
  CanNode& node = nodes_.at(beat.node);
  if (beat.state == NmtState::kBootUp) {
    ++node.boots;
    // Once identified, a board that boots has lost what it was told.
    if (node.serial != 0) {
      RaiseBoardFault(beat.node, "it restarted", "check the board's supply and cable, then open the ring again");
    }
  }
  node.state = StateOf(beat.state);
  node.last_heard = std::max(node.last_heard, host_time);
}

void CanRingBus::TakeEmergency(const Emergency& emergency) {
  CanNode& node = nodes_.at(emergency.node);
  if (node.serials.size() < kMostSerials) node.serials.insert(emergency.serial);
  // Found when the serial numbers are read, which then names both boards.
  if (node.serial == 0 && emergency.code == kEmergencySameNodeId) return;
  if (node.serial != 0 && emergency.serial != node.serial) node.alien_serial = emergency.serial;
  if (emergency.code == kEmergencyNone) {
    node.emergency.reset();
    return;
  }
  node.emergency = emergency.code;
  const std::string text = "it reports emergency " + EmergencyText(emergency.code);
  if (IsWarning(emergency.code)) {
    LogLimited(NodeName(emergency.node) + ": " + text);
    return;
  }
  RaiseBoardFault(emergency.node, text, "look the code up in docs/wire_protocol.md; have the board checked");
}

void CanRingBus::TakeSdoReply(NodeId node, const CanFrame& frame, nanoseconds host_time) {
  const std::span<const std::byte> bytes(frame.data);
  const bool tells_serial = std::to_integer<std::uint8_t>(bytes[0]) == kExpeditedSerialReply &&
                            GetLittleEndian<std::uint16_t>(bytes.subspan(1)) == kObjectSerial.index &&
                            std::to_integer<std::uint8_t>(bytes[3]) == kObjectSerial.sub_index;
  auto& serials = nodes_.at(node).serials;
  if (tells_serial && serials.size() < kMostSerials) serials.insert(GetLittleEndian<std::uint32_t>(bytes.subspan(4)));
  if (transfer_ != nullptr && transfer_node_ == node && transfer_->Take(frame)) last_reply_time_ = host_time;
}

void CanRingBus::TakeReport(const CanReport& report, nanoseconds host_time) {
  ++health_.reports;
  if (report.receive_overflow) ++health_.lost_frames;
  if (report.state) EnterState(*report.state, host_time);
  if (report.restarted) LogLimited(name_ + ": back from bus-off");
  if (!report.state || report.receive_overflow || report.transmit_overflow) {
    const char* what = "bus error";
    if (report.no_acknowledge) what = "nobody acknowledges";
    if (report.receive_overflow) what = "the controller lost frames";
    if (report.transmit_overflow) what = "the controller's transmit buffer overflowed";
    LogLimited(name_ + ": " + what + ", the controller is " + CanStateText(health_.state));
  }
  if (report.state == CanState::kBusOff) {
    RaiseFault("watch " + name_, "the controller is bus-off: too many transmit errors",
               "check the bus' wiring, termination and bit rate, then open the ring again");
  }
}

void CanRingBus::EnterState(CanState state, nanoseconds host_time) {
  if (state != health_.state) LogLimited(name_ + ": the controller is " + CanStateText(state));
  health_.state = state;
  const bool passive = state == CanState::kErrorPassive || state == CanState::kBusOff;
  if (!passive) health_.passive_since.reset();
  if (passive && !health_.passive_since) health_.passive_since = host_time;
}

void CanRingBus::LogLimited(const std::string& text) {
  const nanoseconds now = clock_.Now();
  if (now - log_window_ >= std::chrono::seconds(1)) {
    // The line about the dropped ones is the first of its second.
    const std::uint64_t dropped = std::exchange(log_dropped_, 0);
    log_window_ = now;
    log_lines_ = dropped > 0 ? 1 : 0;
    if (dropped > 0) Log(LogLevel::kWarning, name_ + ": " + std::to_string(dropped) + " more messages in a second");
  }
  if (log_lines_ >= kMostLogLines) {
    ++log_dropped_;
    return;
  }
  ++log_lines_;
  Log(LogLevel::kWarning, text);
}

void CanRingBus::WatchHeartbeats(nanoseconds watch) {
  const nanoseconds now = clock_.Now();
  // A host that was away finds old frames, and none in place of those that its queue lost: it has to listen anew.
  const bool was_away = now - watched_ > watch || std::exchange(overflows_seen_, bus_.overflows()) != bus_.overflows();
  if (was_away) listening_since_ = now;
  watched_ = now;
  for (auto& [id, node] : nodes_) {
    if (node.state == CanNodeState::kSilent || now - std::max(node.last_heard, listening_since_) <= watch) continue;
    node.state = CanNodeState::kLost;
  }
}

bool CanRingBus::CollectAll() {
  const nanoseconds now = clock_.Now();
  for (int i = 0; i < kMostCollects; ++i) {
    if (Collect(now)) return true;
  }
  return false;
}

Result<std::vector<std::byte>> CanRingBus::Transfer(SdoTransfer transfer, nanoseconds timeout,
                                                    const std::string& attempted) {
  const nanoseconds deadline = clock_.Now() + timeout;
  transfer_ = &transfer;
  Status sent;
  while (sent && transfer.state() == SdoTransfer::State::kRunning) {
    if (const auto request = transfer.TakeRequest()) {
      sent = Send(*request, attempted);
      continue;
    }
    CollectUntil(deadline,
                 [&] { return transfer.state() != SdoTransfer::State::kRunning || transfer.wants_to_send(); });
    if (transfer.state() == SdoTransfer::State::kRunning && !transfer.wants_to_send() && clock_.Now() >= deadline)
      break;
    if (fault_ && health_.state == CanState::kDown) break;
  }
  transfer_ = nullptr;
  const bool aborted = transfer.state() == SdoTransfer::State::kAborted;
  const auto farewell = aborted ? transfer.TakeRequest() : std::nullopt;
  refused_ = aborted && !farewell;
  if (!sent) return Fail(sent);
  if (transfer.state() == SdoTransfer::State::kDone) return transfer.data();
  if (aborted) {
    // The board would stay in a transfer that only the host gave up.
    if (farewell) static_cast<void>(bus_.Send(*farewell));
    return Fail(
        attempted,
        (refused_ ? "the board refuses: " : "the board's answer is not usable: ") + SdoAbortText(transfer.abort_code()),
        "check the board's firmware version");
  }
  static_cast<void>(bus_.Send(transfer.AbortFrame(SdoAbort::kTimeout)));
  return Fail(attempted, "no answer in " + std::to_string(timeout / milliseconds(1)) + " ms",
              "check the board's supply, cable and node id");
}

Result<std::vector<std::byte>> CanRingBus::TransferWithRetries(const SdoTransfer& transfer, NodeId node,
                                                               nanoseconds timeout, int attempts) {
  const std::string attempted =
      std::string("exchange object ") + SdoAddressText(transfer.address()) + " with " + NodeName(node);
  transfer_node_ = node;
  auto result = Transfer(transfer, timeout, attempted);
  const auto worth_it = [&] { return !refused_ && health_.state != CanState::kDown; };
  for (int attempt = 1; !result && attempt < attempts && worth_it(); ++attempt) {
    Collect(clock_.Now() + kQuietTime);
    result = Transfer(transfer, timeout, attempted);
  }
  return result;
}

Result<std::vector<std::byte>> CanRingBus::Upload(NodeId node, SdoAddress address, nanoseconds timeout, int attempts) {
  return TransferWithRetries(SdoTransfer::Upload(node, address), node, timeout, attempts);
}

Status CanRingBus::Download(NodeId node, SdoAddress address, std::vector<std::byte> data, nanoseconds timeout,
                            int attempts) {
  const auto written =
      TransferWithRetries(SdoTransfer::Download(node, address, std::move(data)), node, timeout, attempts);
  if (!written) return Fail(written);
  return {};
}

}  // namespace annulus
