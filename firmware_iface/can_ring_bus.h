#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/can_level_codec.h"
#include "firmware_iface/canopen.h"
#include "firmware_iface/sdo.h"

namespace annulus {

/// What the host knows of a node.
///
///     kSilent --boot-up, beat--> kPreOperational <--beat--> kOperational, kStopped
///                                     |  no beat for the watch time        |
///                                     +-------------> kLost <--------------+     kLost --beat--> as the beat says
///
/// kSilent is a node of which nothing was ever heard: not ready, whatever the reason.
enum class CanNodeState { kSilent, kPreOperational, kOperational, kStopped, kLost };
[[nodiscard]] const char* CanNodeStateText(CanNodeState state);

struct CanNode {
  CanNodeState state = CanNodeState::kSilent;
  std::chrono::nanoseconds last_heard{0};     ///< Boot-up or beat.
  std::uint32_t boots = 0;                    ///< Boot-up messages since the host last reset the bus.
  std::optional<std::uint16_t> emergency;     ///< The last code that is not 0 and was not taken back.
  std::set<std::uint32_t> serials;            ///< Of boards that spoke under this node id; two are one too many.
  std::optional<std::uint32_t> alien_serial;  ///< In an emergency message that is of another board.
  std::uint32_t serial = 0;                   ///< Once identified.
  CanLevelAssembler levels;
  WrappedClock clock;
  std::string trouble;  ///< Of a node beside the ring: what would be a fault if it were of the ring.
};

/// The fault confinement of the host's own controller, as reports tell it.
struct CanBusHealth {
  CanState state = CanState::kErrorActive;
  std::optional<std::chrono::nanoseconds> passive_since;
  std::uint64_t reports = 0;         ///< Of any kind.
  std::uint64_t lost_frames = 0;     ///< Told by the controller; see CanBus::overflows() for those of the queue.
  std::uint64_t foreign_frames = 0;  ///< Of no node of the ring.
};

/// One bus of the ring: sends with patience, collects with deadlines, keeps the nodes' states, carries out SDO
/// transfers. Whatever comes changes only the node it is from. Thread-bound. Borrows bus and clock.
class CanRingBus {
 public:
  /// Nodes 1 … `last_node` may be on the bus.
  CanRingBus(CanBus& bus, NodeId last_node, Clock& clock);
  /// One more node may be on the bus, which is not part of the ring: what it reports is its own trouble and no fault,
  /// unless it is an emitter's.
  void AddBeside(NodeId node);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] CanBus& bus() { return bus_; }
  [[nodiscard]] std::map<NodeId, CanNode>& nodes() { return nodes_; }
  [[nodiscard]] const CanBusHealth& health() const { return health_; }
  /// The first thing that went wrong and ends a scan (bus-off, interface gone, a board restarted or in emergency),
  /// since Forgive.
  [[nodiscard]] const std::optional<Error>& fault() const { return fault_; }
  /// A board said so itself; else it is the bus or its controller.
  [[nodiscard]] bool fault_is_of_a_board() const { return fault_is_of_a_board_; }
  void Forgive() {
    fault_.reset();
    fault_is_of_a_board_ = false;
  }
  /// How a board is called in messages, once it is known.
  void SetNodeName(NodeId node, std::string name) { node_names_[node] = std::move(name); }
  [[nodiscard]] std::string NodeName(NodeId node) const;
  [[nodiscard]] bool KnowsName(NodeId node) const { return node_names_.count(node) != 0; }

  /// Sends; a full queue is tried again for 20 ms, in which frames are collected. A failure is a fault too.
  Status Send(const CanFrame& frame, const std::string& attempted);
  /// Takes what has come until `deadline`, or what is there if that is past; returns early once `enough`, if given,
  /// says so after a frame. At most 4096 frames per call. False: there may be more at once.
  bool Collect(std::chrono::nanoseconds deadline);
  template <class Enough>
  bool CollectUntil(std::chrono::nanoseconds deadline, Enough enough);

  /// Reads an object of a node.
  Result<std::vector<std::byte>> Upload(NodeId node, SdoAddress address, std::chrono::nanoseconds timeout,
                                        int attempts);
  /// Writes an object of a node.
  Status Download(NodeId node, SdoAddress address, std::vector<std::byte> data, std::chrono::nanoseconds timeout,
                  int attempts);
  /// When the frame that ended the last transfer came.
  [[nodiscard]] std::chrono::nanoseconds last_reply_time() const { return last_reply_time_; }

  /// Takes what is there. False: there is still more.
  bool CollectAll();
  /// Marks nodes lost of which nothing was heard for `watch` in which the host was listening: this is called at least
  /// as often. Call it when everything is collected.
  void WatchHeartbeats(std::chrono::nanoseconds watch);
  /// Notes a failure of the seam.
  void Note(const CanFailure& failure, const std::string& attempted);
  /// Binds to the interface of the same name anew and reads its state.
  CanResult<void> Rebind();
  /// The host has just reset the bus: boots are counted from 0, beats are awaited anew.
  void ForgetNodes();

 private:
  Result<std::vector<std::byte>> Transfer(SdoTransfer transfer, std::chrono::nanoseconds timeout,
                                          const std::string& attempted);
  Result<std::vector<std::byte>> TransferWithRetries(const SdoTransfer& transfer, NodeId node,
                                                     std::chrono::nanoseconds timeout, int attempts);
  /// One reception; false when nothing came until the deadline or the bus failed.
  bool Step(std::chrono::nanoseconds deadline);
  void TakeFrame(const CanFrame& frame, std::chrono::nanoseconds host_time);
  void TakeHeartbeat(const Heartbeat& beat, std::chrono::nanoseconds host_time);
  void TakeEmergency(const Emergency& emergency);
  void TakeSdoReply(NodeId node, const CanFrame& frame, std::chrono::nanoseconds host_time);
  void TakeReport(const CanReport& report, std::chrono::nanoseconds host_time);
  void EnterState(CanState state, std::chrono::nanoseconds host_time);
  void RaiseFault(std::string attempted, std::string seen, std::string advice);
  void RaiseBoardFault(NodeId node, std::string seen, std::string advice);
  void LogLimited(const std::string& text);

  static constexpr int kMostCollected = 4096;

  CanBus& bus_;
  Clock& clock_;
  std::string name_;
  std::map<NodeId, CanNode> nodes_;
  NodeId beside_ = 0;  ///< 0: none.
  std::map<NodeId, std::string> node_names_;
  CanBusHealth health_;
  std::optional<Error> fault_;
  bool fault_is_of_a_board_ = false;
  SdoTransfer* transfer_ = nullptr;  ///< Running; set within Transfer only.
  NodeId transfer_node_ = 0;
  bool refused_ = false;  ///< The last transfer was ended by the node itself.
  std::chrono::nanoseconds last_reply_time_{0};
  std::uint64_t overflows_seen_ = 0;
  std::chrono::nanoseconds watched_{0};  ///< Last call of WatchHeartbeats.
  std::chrono::nanoseconds listening_since_{0};
  std::chrono::nanoseconds log_window_{0};
  int log_lines_ = 0;
  std::uint64_t log_dropped_ = 0;
};

template <class Enough>
bool CanRingBus::CollectUntil(std::chrono::nanoseconds deadline, Enough enough) {
  for (int i = 0; i < kMostCollected; ++i) {
    if (enough()) return true;
    // A flood must not keep the host beyond its deadline; what is there at the deadline is still taken.
    if (!Step(deadline)) return true;
  }
  return false;
}

}  // namespace annulus
