#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/ensure.h"
#include "firmware_iface/can_bus_recovery.h"
#include "firmware_iface/can_reference.h"
#include "firmware_iface/can_ring_boot.h"
#include "firmware_iface/can_ring_bus.h"
#include "firmware_iface/can_ring_orders.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/ring_boards.h"
#include "firmware_iface/ring_objects.h"
#include "firmware_iface/ring_rules.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// Beats that may fail in a row, and what one may be late by.
constexpr int kMissedBeats = 3;
constexpr nanoseconds kBeatSlack = milliseconds(20);
/// A controller that is error-passive for longer than this is not started with.
constexpr nanoseconds kMostPassive = std::chrono::seconds(1);
/// Attempts of orders while stopping: the time is bounded, and boards that do not hear stop with their SYNC.
constexpr int kStopAttempts = 2;

tl::unexpected<Error> FailWith(const Error& error) { return tl::unexpected<Error>(error); }

class CanRangeRing final : public RangeRing {
 public:
  CanRangeRing(std::vector<CanRingBus> buses, std::vector<CanRingBoard> links, std::optional<CanReference> reference,
               CanRangeRingOptions options, Clock& clock)
      : buses_(std::move(buses)),
        links_(std::move(links)),
        reference_(std::move(reference)),
        options_(std::move(options)),
        clock_(clock),
        losses_(links_.size()),
        recoveries_(buses_.size()) {
    for (const CanRingBoard& link : links_) boards_.push_back(link.board);
    limits_ = LimitsNow();
    CountOverflows();
  }
  ~CanRangeRing() override {
    if (state_ != State::kIdle) static_cast<void>(Stop());
  }
  CanRangeRing(const CanRangeRing&) = delete;
  CanRangeRing& operator=(const CanRangeRing&) = delete;

  [[nodiscard]] State state() const override { return state_; }
  [[nodiscard]] const std::vector<RingBoard>& boards() const override { return boards_; }
  [[nodiscard]] const RingLimits& limits() const override { return limits_; }
  [[nodiscard]] const RingCounters& counters() const override { return counters_; }

  Status Start(Hertz level_rate) override;
  Status Stop() override;
  Result<RingLevel> NextLevel(nanoseconds deadline) override;
  Status Reopen(nanoseconds deadline) override;
  Result<ClockExchange> ReadClock(std::size_t board) override;
  [[nodiscard]] RingTrouble trouble() const override { return trouble_; }
  [[nodiscard]] const ReferenceBoard* reference() const override { return reference_ ? &reference_->board() : nullptr; }

 private:
  [[nodiscard]] RingLimits LimitsNow() {
    return LimitsOf(buses_, links_, reference_ ? reference_->node() : std::nullopt, options_.sensor_count);
  }
  [[nodiscard]] CanRingBus& BusOf(std::size_t board) { return buses_[links_[board].bus]; }
  [[nodiscard]] CanNode& NodeOf(std::size_t board) { return BusOf(board).nodes().at(links_[board].node); }
  [[nodiscard]] Status CheckBuses();
  [[nodiscard]] Status CheckNodes(CanNodeState required);
  Status StartBoards(Hertz level_rate);
  [[nodiscard]] CanRingOrders Orders() { return {buses_, links_, options_.sdo_timeout, clock_}; }
  [[nodiscard]] bool HasDecision(std::size_t board);
  void Await(std::size_t board, nanoseconds deadline);
  [[nodiscard]] Status FirstFault();
  [[nodiscard]] Status CheckAllSpoke();
  Result<RingLevel> Assemble();
  Status Put(std::size_t board, const CanLevel& arrived, RingLevel& level);
  void CountOverflows();
  void UpdateCounters();
  /// Boots the boards and makes sure that each is the one that was there.
  Status FindAll(nanoseconds deadline);
  Result<std::vector<CanRingBoard>> BootAgain(nanoseconds deadline);

  std::vector<CanRingBus> buses_;
  std::vector<CanRingBoard> links_;  ///< In the order of boards_.
  std::optional<CanReference> reference_;
  CanRangeRingOptions options_;
  Clock& clock_;
  std::vector<RingBoard> boards_;
  RingLimits limits_;
  State state_ = State::kIdle;
  RingTrouble trouble_ = RingTrouble::kNone;
  Status usable_;  ///< Why the ring must be opened again before it may start: the nodes are no longer those of boards_.
  RingCounters counters_;
  std::uint64_t overflows_at_start_ = 0;
  std::vector<LossBucket> losses_;
  std::vector<CanBusRecovery> recoveries_;  ///< One per bus.
  std::uint32_t wanted_ = 0;                ///< Sequence of the next level.
  std::uint8_t clock_question_ = 0;
};

Status CanRangeRing::Start(Hertz level_rate) {
  trouble_ = RingTrouble::kOrder;
  RETURN_IF_ERROR(CheckRingState("start the ring", state_, State::kIdle));
  RETURN_IF_ERROR(CheckLevelRate(level_rate, limits_, "correct the scan plan, or spread the boards over more buses"));
  trouble_ = RingTrouble::kIdentity;
  RETURN_IF_ERROR(usable_);
  trouble_ = RingTrouble::kBus;
  RETURN_IF_ERROR(CheckBuses());
  counters_ = {};
  CountOverflows();
  wanted_ = 0;
  losses_.assign(links_.size(), {});
  // Each run asks alike, so that a replay of its frames asks what they answer. An answer to a question of before is no
  // danger: each board answers in order, and the orders to start ask each of them something else first.
  clock_question_ = 0;
  state_ = State::kStreaming;
  if (Status started = StartBoards(level_rate); !started) {
    state_ = State::kFailed;
    static_cast<void>(Stop());
    return started;
  }
  for (CanBusRecovery& recovery : recoveries_) recovery = {};
  return {};
}

/// A bus in trouble is not started with.
Status CanRangeRing::CheckBuses() {
  for (CanRingBus& bus : buses_) {
    bus.CollectAll();
    bus.WatchHeartbeats(kMissedBeats * options_.heartbeat + kBeatSlack);
    if (bus.fault()) {
      return Fail("start the ring", bus.fault()->seen + " (" + bus.fault()->attempted + ")",
                  "open the ring again when the cause is gone");
    }
    const auto link = bus.bus().ReadLink();
    if (!link) {
      return Fail("start the ring", bus.name() + ": " + CanFailureText(link.error()), "check the CAN adapter");
    }
    if (link->restart_ms && *link->restart_ms > 0 && *link->restart_ms < 1000) {
      return Fail("start the ring",
                  bus.name() + " restarts from bus-off after " + std::to_string(*link->restart_ms) + " ms",
                  "set restart-ms to 1000 or more, or to 0: ip link set " + bus.name() + " type can restart-ms 1000");
    }
    const auto& since = bus.health().passive_since;
    if (since && clock_.Now() - *since > kMostPassive) {
      return Fail("start the ring",
                  bus.name() + " is " + CanStateText(bus.health().state) + " for " +
                      std::to_string((clock_.Now() - *since) / milliseconds(1)) + " ms",
                  "check the bus' wiring, termination and bit rate");
    }
  }
  return CheckNodes(CanNodeState::kPreOperational);
}

/// Every board is heard, and while streaming in the state that it was ordered into.
Status CanRangeRing::CheckNodes(CanNodeState required) {
  trouble_ = RingTrouble::kBoardLost;
  for (std::size_t board = 0; board < links_.size(); ++board) {
    const CanNode& node = NodeOf(board);
    const std::string attempted = "watch " + BoardName(boards_[board]);
    if (node.alien_serial || node.levels.foreign_serial()) {
      trouble_ = RingTrouble::kIdentity;
      return Fail(attempted,
                  "another board" + (node.alien_serial ? ", " + std::to_string(*node.alien_serial) + "," : "") +
                      " sends under its node id",
                  "give each board of the ring its own node id");
    }
    const bool wrong = required == CanNodeState::kOperational && node.state != required;
    if (node.state != CanNodeState::kLost && node.state != CanNodeState::kSilent && !wrong) continue;
    return Fail(attempted, std::string("it is ") + CanNodeStateText(node.state),
                "check the board's cable and supply, then open the ring again");
  }
  return {};
}

Status CanRangeRing::StartBoards(Hertz level_rate) {
  trouble_ = RingTrouble::kBus;
  const auto period_us = static_cast<std::uint32_t>(std::lround(1e6 / level_rate.value()));
  CanRingOrders orders = Orders();
  RETURN_IF_ERROR(orders.Prepare(period_us));
  for (std::size_t board = 0; board < links_.size(); ++board) {
    NodeOf(board).levels.Begin(std::chrono::microseconds(period_us));
  }
  if (reference_) reference_->Begin(buses_, std::chrono::microseconds(period_us));
  return orders.StartSync();
}

bool CanRangeRing::HasDecision(std::size_t board) {
  const CanLevelAssembler& levels = NodeOf(board).levels;
  return levels.has_level() || levels.next() > wanted_;
}

void CanRangeRing::Await(std::size_t board, nanoseconds deadline) {
  CanRingBus& bus = BusOf(board);
  bool drained = false;
  while (!HasDecision(board) && !bus.fault()) {
    if (drained && clock_.Now() >= deadline) break;
    drained = bus.CollectUntil(deadline, [&] { return HasDecision(board) || bus.fault(); });
  }
  // At the deadline, what came of the level or of a later one proves that the rest is lost.
  if (!HasDecision(board)) static_cast<void>(NodeOf(board).levels.GiveUpOldest());
}

Result<RingLevel> CanRangeRing::NextLevel(nanoseconds deadline) {
  RETURN_IF_ERROR(CheckRingState("read a level of the ring", state_, State::kStreaming));
  for (std::size_t board = 0; board < links_.size(); ++board) Await(board, deadline);
  if (reference_) reference_->Await(wanted_, deadline, buses_, clock_);
  const nanoseconds now = clock_.Now();
  for (CanRingBus& bus : buses_) {
    if (bus.Collect(now)) bus.WatchHeartbeats(kMissedBeats * options_.heartbeat + kBeatSlack);
  }
  UpdateCounters();
  Status good = FirstFault();
  if (good) good = CheckNodes(CanNodeState::kOperational);
  if (good) good = CheckAllSpoke();
  if (good) {
    auto level = Assemble();
    if (!level) state_ = State::kFailed;
    return level;
  }
  state_ = State::kFailed;
  return Fail(good);
}

Status CanRangeRing::FirstFault() {
  for (const CanRingBus& bus : buses_) {
    if (!bus.fault()) continue;
    trouble_ = bus.fault_is_of_a_board() ? RingTrouble::kBoardLost : RingTrouble::kBus;
    return FailWith(*bus.fault());
  }
  return {};
}

Status CanRangeRing::CheckAllSpoke() {
  trouble_ = RingTrouble::kBoardLost;
  std::string silent;
  std::size_t count = 0;
  for (std::size_t board = 0; board < links_.size(); ++board) {
    if (HasDecision(board)) continue;
    ++count;
    silent += (silent.empty() ? "" : ", ") + BoardName(boards_[board]);
  }
  if (count == 0) return {};
  const std::string attempted = "read level " + std::to_string(wanted_) + " of the ring";
  if (count == links_.size()) {
    return Fail(attempted, "nothing from any board", "check the ring's supply and its CAN buses, then start again");
  }
  return Fail(attempted, "nothing from " + silent, "check the board's cable and supply, then start again");
}

Result<RingLevel> CanRangeRing::Assemble() {
  RingLevel level;
  level.sequence = wanted_;
  level.boards.resize(boards_.size());
  level.range_mm.assign(limits_.sensor_count, std::numeric_limits<double>::quiet_NaN());
  level.quality.assign(limits_.sensor_count, 0);
  for (std::size_t board = 0; board < links_.size(); ++board) {
    CanLevelAssembler& levels = NodeOf(board).levels;
    if (levels.has_level() && levels.front().level.sequence == wanted_) {
      RETURN_IF_ERROR(Put(board, levels.front(), level));
      levels.Pop();
      losses_[board].Keep();
      continue;
    }
    ++counters_.lost_frames;
    losses_[board].Lose();
    if (losses_[board].full()) {
      trouble_ = RingTrouble::kData;
      return Fail("read level " + std::to_string(wanted_) + " of the ring",
                  BoardName(boards_[board]) + " loses frames repeatedly",
                  "check the bus' wiring and load and the host's load, then start again");
    }
  }
  if (reference_) {
    trouble_ = RingTrouble::kEmitter;
    RETURN_IF_ERROR(reference_->Put(buses_, level));
  }
  ++wanted_;
  ++counters_.levels;
  return level;
}

Status CanRangeRing::Put(std::size_t board, const CanLevel& arrived, RingLevel& level) {
  const LevelFrame& told = arrived.level;
  if ((told.status & kFrameEmitterFault) != 0) {
    trouble_ = RingTrouble::kEmitter;
    return Fail("read " + BoardName(boards_[board]), "it reports an emitter fault",
                "keep the ring off and have the board replaced");
  }
  const auto wire_us = static_cast<std::uint32_t>(told.device_time / std::chrono::microseconds(1));
  level.boards[board] = {true, NodeOf(board).clock.Unwrap(wire_us, arrived.host_arrival), arrived.host_arrival,
                         told.temperature_centi_c / 100.0};
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    if (told.range_um[i] == kNoReturn) continue;
    level.range_mm[boards_[board].first_sensor + i] = told.range_um[i] / 1000.0;
    level.quality[boards_[board].first_sensor + i] = told.quality[i];
  }
  return {};
}

void CanRangeRing::CountOverflows() {
  overflows_at_start_ = 0;
  for (CanRingBus& bus : buses_) overflows_at_start_ += bus.bus().overflows() + bus.health().lost_frames;
}

void CanRangeRing::UpdateCounters() {
  counters_.duplicate_frames = 0;
  counters_.rejected_frames = 0;
  for (std::size_t board = 0; board < links_.size(); ++board) {
    counters_.duplicate_frames += NodeOf(board).levels.duplicates();
    counters_.rejected_frames += NodeOf(board).levels.rejected();
  }
  std::uint64_t overflows = 0;
  for (CanRingBus& bus : buses_) overflows += bus.bus().overflows() + bus.health().lost_frames;
  counters_.overflowed_frames = overflows - overflows_at_start_;
}

Status CanRangeRing::Stop() {
  const bool was_well = state_ == State::kStreaming;
  trouble_ = RingTrouble::kBus;
  Status result = Orders().StopAll(was_well ? kStopAttempts : 1);
  // What is known to be broken can not be stopped, and need not be.
  if (!was_well) result = {};
  UpdateCounters();
  for (std::size_t board = 0; board < links_.size(); ++board) NodeOf(board).levels.End();
  if (reference_) reference_->End(buses_);
  state_ = State::kIdle;
  return result;
}

Result<ClockExchange> CanRangeRing::ReadClock(std::size_t board) {
  ENSURE(board < links_.size() || (reference_ && board == links_.size()), "the board is one of boards(), or beside");
  if (state_ == State::kFailed) return Fail(CheckRingState("read a board's clock", state_, State::kStreaming));
  RETURN_IF_ERROR(usable_);
  Result<ClockExchange> told = Fail("read a board's clock", "not asked", "ask again");
  for (int attempt = 0; attempt < kSdoAttempts && !told; ++attempt) {
    // Another sub-index for each question: a late answer is then never that of the next one.
    clock_question_ = static_cast<std::uint8_t>(clock_question_ % kClockSubIndices + 1);
    if (board == links_.size()) return reference_->ReadClock(clock_question_, buses_, clock_);
    told = AskCanClock(BusOf(board), links_[board], clock_question_, options_.sdo_timeout, clock_);
    if (BusOf(board).fault()) break;
  }
  if (!told) trouble_ = RingTrouble::kBus;
  return told;
}

Status CanRangeRing::Reopen(nanoseconds deadline) {
  RETURN_IF_ERROR(CheckRingState("open the ring again", state_, State::kIdle));
  trouble_ = RingTrouble::kBoardLost;
  usable_ = FindAll(deadline);
  return usable_;
}

Status CanRangeRing::FindAll(nanoseconds deadline) {
  Result<std::vector<CanRingBoard>> links = BootAgain(deadline);
  // A bus that fails while the boards boot is brought back once more, as long as there is time.
  while (!links && !FirstFault() && clock_.Now() < deadline) links = BootAgain(deadline);
  if (!links) return Fail(links);
  for (std::size_t board = 0; board < links_.size(); ++board) {
    const RingBoard& now = (*links)[board].board;
    if (now.serial == boards_[board].serial && now.first_sensor == boards_[board].first_sensor) continue;
    trouble_ = RingTrouble::kIdentity;
    return Fail("open the ring again", BoardName(now) + " stands where " + BoardName(boards_[board]) + " was",
                "connect the board that was there, or start the program again");
  }
  links_ = std::move(*links);
  boards_.clear();
  for (const CanRingBoard& link : links_) boards_.push_back(link.board);
  if (reference_) reference_->Boot(buses_, clock_);
  limits_ = LimitsNow();
  return {};
}

Result<std::vector<CanRingBoard>> CanRangeRing::BootAgain(nanoseconds deadline) {
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    RETURN_IF_ERROR(recoveries_[bus].BringBack(buses_[bus], deadline, clock_));
  }
  CanRangeRingOptions options = options_;
  options.boot_deadline = std::clamp(deadline - clock_.Now(), nanoseconds(0), options_.boot_deadline);
  return BootCanBoards(buses_, options, clock_);
}

}  // namespace

Result<std::unique_ptr<RangeRing>> MakeCanRangeRing(const std::vector<CanBus*>& buses, CanRangeRingOptions options,
                                                    Clock& clock) {
  ENSURE(!buses.empty(), "a ring hangs on a bus");
  ENSURE(options.board_count >= 1 && options.board_count <= kLastNodeId, "node ids are 1 to 127");
  ENSURE(options.heartbeat >= milliseconds(1) && options.heartbeat < std::chrono::seconds(60), "a heartbeat is set");
  std::vector<CanRingBus> known;
  for (CanBus* bus : buses) {
    ENSURE(bus != nullptr, "every bus is there");
    known.emplace_back(*bus, static_cast<NodeId>(options.board_count), clock);
    if (options.reference) known.back().AddBeside(static_cast<NodeId>(options.board_count + 1));
  }
  auto links = BootCanBoards(known, options, clock);
  if (!links) return Fail(links);
  std::optional<CanReference> reference;
  if (options.reference) {
    ENSURE(options.board_count < kLastNodeId, "the reference board has a node id");
    reference.emplace(options).Boot(known, clock);
  }
  return std::make_unique<CanRangeRing>(std::move(known), std::move(*links), std::move(reference), std::move(options),
                                        clock);
}

}  // namespace annulus
