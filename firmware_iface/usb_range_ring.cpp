#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/ensure.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/ring_boards.h"
#include "firmware_iface/ring_rules.h"
#include "firmware_iface/usb_board_link.h"
#include "firmware_iface/usb_frame_codec.h"
#include "firmware_iface/usb_reference.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kStopDeadline = std::chrono::seconds(1);
/// What of it the orders to stop may take; the rest is for the transfers' ends.
constexpr nanoseconds kStopOrders = std::chrono::milliseconds(700);
/// Each board's share of it, at least.
constexpr nanoseconds kLeastPatience = std::chrono::milliseconds(1);
/// Boards that have just been plugged in may be opened and speak within it.
constexpr nanoseconds kOpenDeadline = std::chrono::seconds(3);
/// How long a wait on one board goes on before the others are looked at.
constexpr nanoseconds kGlance = std::chrono::milliseconds(10);
/// Boards that go within it have one cause.
constexpr nanoseconds kTogether = std::chrono::milliseconds(10);
constexpr nanoseconds kBetweenTries = std::chrono::milliseconds(50);
/// What the kernel keeps beside the data of a transfer, at most.
constexpr std::size_t kTransferOverhead = 512;

/// What a ring on USB is made of.
struct UsbRingParts {
  std::vector<RingBoard> boards;
  std::vector<UsbBoardLink> links;  ///< Same order.
  RingLimits limits;
  std::optional<UsbReference> reference;
};

class UsbRangeRing final : public RangeRing {
 public:
  /// `host` is null if the ports are borrowed.
  UsbRangeRing(UsbRingParts parts, UsbRangeRingOptions options, UsbHost* host, Clock& clock)
      : boards_(std::move(parts.boards)),
        accepted_(boards_),
        links_(std::move(parts.links)),
        reference_(std::move(parts.reference)),
        limits_(parts.limits),
        options_(std::move(options)),
        host_(host),
        clock_(clock) {}
  ~UsbRangeRing() override {
    if (state_ != State::kIdle) static_cast<void>(Stop());
  }
  UsbRangeRing(const UsbRangeRing&) = delete;
  UsbRangeRing& operator=(const UsbRangeRing&) = delete;

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
  [[nodiscard]] Status CheckMemory() const;
  Status StartBoards(Hertz level_rate);
  /// Waits until the board has a frame or the deadline is over.
  Status Await(UsbBoardLink& link, nanoseconds deadline);
  Status AwaitReference(nanoseconds deadline);
  Result<RingLevel> Assemble();
  [[nodiscard]] Status CheckAllSpoke() const;
  /// The one cause when a board's end shows that it, perhaps with others, was unplugged; else the board's own failure.
  tl::unexpected<Error> Explain(const UsbBoardLink& failed, const Status& failure);
  void CountFrames();
  /// Orders each board to stop, first the one that drives SYNC; says which did not obey, and why.
  std::string StopBoards(nanoseconds deadline);
  /// Makes sure that every board is there and where it was.
  Status FindAll(nanoseconds deadline);
  Status FindBorrowed(nanoseconds deadline);
  /// Makes sure that this board is there, on its old port or on one opened anew.
  Status Find(std::size_t board, nanoseconds deadline);

  std::vector<RingBoard> boards_;
  std::vector<RingBoard> accepted_;  ///< Who was where when the ring was last complete.
  std::vector<UsbBoardLink> links_;  ///< Same order as boards_.
  std::optional<UsbReference> reference_;
  RingLimits limits_;
  UsbRangeRingOptions options_;
  UsbHost* host_;
  Clock& clock_;
  State state_ = State::kIdle;
  RingTrouble trouble_ = RingTrouble::kNone;
  Status usable_;  ///< Why the ring must be reopened before it may start.
  RingCounters counters_;
  std::uint32_t wanted_ = 0;  ///< Sequence of the next level.
};

/// The limit is shared with every other program that uses USB; more than all of it can not be had.
Status UsbRangeRing::CheckMemory() const {
  const std::uint64_t limit = host_ == nullptr ? 0 : host_->transfer_memory();
  const std::size_t boards = links_.size() + (reference_ ? 1 : 0);
  const std::uint64_t needed = boards * options_.transfers_per_board * (kTransferBytes + kTransferOverhead);
  if (limit == 0 || needed <= limit) return {};
  return Fail("start the ring",
              "its transfers need " + std::to_string(needed) + " bytes, the kernel allows " + std::to_string(limit) +
                  " (usbfs_memory_mb)",
              "raise usbcore.usbfs_memory_mb, or keep fewer transfers in flight");
}

Status UsbRangeRing::Start(Hertz level_rate) {
  trouble_ = RingTrouble::kOrder;
  RETURN_IF_ERROR(CheckRingState("start the ring", state_, State::kIdle));
  RETURN_IF_ERROR(CheckLevelRate(level_rate, limits_, "correct the scan plan"));
  trouble_ = RingTrouble::kIdentity;
  RETURN_IF_ERROR(usable_);
  trouble_ = RingTrouble::kBus;
  RETURN_IF_ERROR(CheckMemory());
  counters_ = {};
  wanted_ = 0;
  for (UsbBoardLink& link : links_) link.Reset();
  state_ = State::kStreaming;
  if (Status started = StartBoards(level_rate); !started) {
    state_ = State::kFailed;
    static_cast<void>(Stop());
    const bool gone = std::any_of(links_.begin(), links_.end(), [](const UsbBoardLink& link) { return link.gone(); });
    trouble_ = gone ? RingTrouble::kBoardLost : RingTrouble::kBus;
    return started;
  }
  return {};
}

Status UsbRangeRing::StartBoards(Hertz level_rate) {
  const auto rate = EncodeLevelRate(static_cast<std::uint32_t>(std::lround(level_rate.value() * 1000.0)));
  for (std::size_t board = 0; board < links_.size(); ++board) {
    UsbBoardLink& link = links_[board];
    // What a board still had of an earlier run, if only in its USB controller, comes first: its stamps are too old.
    const auto clock = ReadClock(board);
    if (!clock) return Fail(clock);
    link.IgnoreBefore(clock->device_time);
    RETURN_IF_ERROR(link.Order(BoardRequest::kArm, rate, options_.control_timeout, "arm "));
    for (std::size_t i = 0; i < options_.transfers_per_board; ++i) RETURN_IF_ERROR(link.Submit());
  }
  if (reference_) reference_->Start(rate, clock_);
  return links_[0].Order(BoardRequest::kStartSync, {}, options_.control_timeout, "start SYNC on ");
}

Result<RingLevel> UsbRangeRing::NextLevel(nanoseconds deadline) {
  RETURN_IF_ERROR(CheckRingState("read a level of the ring", state_, State::kStreaming));
  for (UsbBoardLink& link : links_) {
    RETURN_IF_ERROR(Await(link, deadline));
  }
  CountFrames();
  if (const Status spoke = CheckAllSpoke(); !spoke) {
    state_ = State::kFailed;
    trouble_ = RingTrouble::kBoardLost;
    return Fail(spoke);
  }
  RETURN_IF_ERROR(AwaitReference(deadline));
  return Assemble();
}

Status UsbRangeRing::AwaitReference(nanoseconds deadline) {
  if (!reference_) return {};
  Status awaited = reference_->Await(deadline);
  if (awaited) return awaited;
  state_ = State::kFailed;
  trouble_ = RingTrouble::kEmitter;
  return awaited;
}

/// A wait on one board looks at the others now and then: when the board that drives SYNC goes, all others fall silent,
/// and the cause lies with a board whose frame of this level is there.
Status UsbRangeRing::Await(UsbBoardLink& link, nanoseconds deadline) {
  while (!link.has_frame()) {
    if (const Status awaited = link.Await(std::min(deadline, clock_.Now() + kGlance)); !awaited) {
      return Explain(link, awaited);
    }
    if (link.has_frame()) break;
    for (UsbBoardLink& other : links_) {
      if (const Status collected = other.Collect(); !collected) return Explain(other, collected);
    }
    if (clock_.Now() >= deadline) break;
  }
  return {};
}

tl::unexpected<Error> UsbRangeRing::Explain(const UsbBoardLink& failed, const Status& failure) {
  state_ = State::kFailed;
  CountFrames();
  trouble_ = failed.gone() ? RingTrouble::kBoardLost : failed.trouble();
  if (!failed.gone()) return Fail(failure);
  clock_.SleepUntil(clock_.Now() + kTogether);
  std::string names;
  std::size_t count = 0;
  for (UsbBoardLink& link : links_) {
    link.LookWhetherGone();
    if (!link.gone()) continue;
    names += (names.empty() ? "" : ", ") + link.name();
    ++count;
  }
  if (count == 1) return Fail(failure);
  const bool all = count == links_.size();
  return Fail("read level " + std::to_string(wanted_) + " of the ring",
              (all ? "all " : "") + std::to_string(count) + " boards are unplugged at once" + (all ? "" : ": " + names),
              "check the supply and the cable of the hub that they share, then open the ring again");
}

Status UsbRangeRing::CheckAllSpoke() const {
  std::string silent;
  std::size_t count = 0;
  for (const UsbBoardLink& link : links_) {
    if (link.has_frame()) continue;
    ++count;
    silent += (silent.empty() ? "" : ", ") + link.name();
  }
  if (count == 0) return {};
  if (count == links_.size()) {
    return Fail("read level " + std::to_string(wanted_) + " of the ring", "nothing from any board",
                "check the ring's supply, its hub and the SYNC wire, then start again");
  }
  return Fail("read level " + std::to_string(wanted_) + " of the ring", "nothing from " + silent,
              "check the board's cable and supply, then start again");
}

Result<RingLevel> UsbRangeRing::Assemble() {
  RingLevel level;
  level.sequence = wanted_;
  level.boards.resize(boards_.size());
  level.range_mm.assign(limits_.sensor_count, std::numeric_limits<double>::quiet_NaN());
  level.quality.assign(limits_.sensor_count, 0);
  for (std::size_t board = 0; board < links_.size(); ++board) {
    UsbBoardLink& link = links_[board];
    const auto arrived = link.TakeFrame(wanted_);
    if (!arrived) {
      ++counters_.lost_frames;
      if (!link.loses_frames()) continue;
      state_ = State::kFailed;
      trouble_ = RingTrouble::kData;
      return Fail("read level " + std::to_string(wanted_) + " of the ring", link.name() + " loses frames repeatedly",
                  "check the board's cable and the host's load, then start again");
    }
    const LevelFrame& frame = arrived->frame;
    level.boards[board] = {true, frame.device_time, arrived->host_arrival, frame.temperature_centi_c / 100.0};
    for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
      if (frame.range_um[i] == kNoReturn) continue;
      level.range_mm[boards_[board].first_sensor + i] = frame.range_um[i] / 1000.0;
      level.quality[boards_[board].first_sensor + i] = frame.quality[i];
    }
  }
  if (reference_) reference_->Put(wanted_, level);
  ++wanted_;
  ++counters_.levels;
  return level;
}

void UsbRangeRing::CountFrames() {
  counters_.duplicate_frames = 0;
  counters_.rejected_bytes = 0;
  counters_.rejected_frames = 0;
  for (const UsbBoardLink& link : links_) {
    counters_.duplicate_frames += link.duplicate_frames();
    counters_.rejected_bytes += link.rejected_bytes();
    counters_.rejected_frames += link.rejected_frames();
  }
}

Status UsbRangeRing::Stop() {
  const nanoseconds begin = clock_.Now();
  const std::string running = StopBoards(begin + kStopOrders);
  Status result;
  if (!running.empty()) {
    trouble_ = RingTrouble::kBus;
    result = Fail("stop the ring", running, "switch the ring's supply off: SYNC and emitters may be on");
  }
  if (reference_) reference_->BeginStop();
  for (UsbBoardLink& link : links_) {
    const Status ended = link.EndTransfers(begin + kStopDeadline);
    if (!ended && result) result = ended;
  }
  if (reference_) reference_->EndStop(begin + kStopDeadline);
  CountFrames();
  state_ = State::kIdle;
  return result;
}

std::string UsbRangeRing::StopBoards(nanoseconds deadline) {
  std::string running;
  for (std::size_t board = 0; board < links_.size(); ++board) {
    UsbBoardLink& link = links_[board];
    if (link.port() == nullptr) continue;
    // Boards that do not answer must not use up the time of those that would.
    const nanoseconds share = (deadline - clock_.Now()) / static_cast<std::int64_t>(links_.size() - board);
    const nanoseconds patience = std::max(kLeastPatience, std::min(share, options_.control_timeout));
    const Status stopped = link.Order(BoardRequest::kStop, {}, patience, "stop ");
    link.CancelAll();
    // A board that is known to be unplugged can not be stopped, and need not be.
    if (stopped || (link.gone() && state_ != State::kStreaming)) continue;
    running += (running.empty() ? "" : "; ") + link.name() + ": " + stopped.error().seen;
  }
  return running;
}

Status UsbRangeRing::Reopen(nanoseconds deadline) {
  RETURN_IF_ERROR(CheckRingState("open the ring again", state_, State::kIdle));
  trouble_ = RingTrouble::kBoardLost;
  usable_ = host_ == nullptr ? FindBorrowed(deadline) : FindAll(deadline);
  if (usable_) accepted_ = boards_;
  if (reference_) reference_->Reopen(host_, clock_);
  return usable_;
}

Status UsbRangeRing::FindAll(nanoseconds deadline) {
  std::string missing;
  std::optional<Error> first;
  for (std::size_t board = 0; board < links_.size(); ++board) {
    const Status found = Find(board, deadline);
    if (found) continue;
    missing += (missing.empty() ? "" : "; ") + BoardName(boards_[board]) + ": " + found.error().seen;
    if (!first) first = found.error();
  }
  if (first) return Fail("open the ring again", missing, first->advice);
  trouble_ = RingTrouble::kIdentity;
  return CheckPlaces(accepted_, boards_);
}

Status UsbRangeRing::FindBorrowed(nanoseconds deadline) {
  std::vector<UsbPort*> ports;
  for (const UsbBoardLink& link : links_) ports.push_back(link.port());
  while (true) {
    const auto known = IdentifyBoards(ports, options_);
    if (known) {
      std::vector<RingBoard> now;
      for (const IdentifiedBoard& one : *known) now.push_back(one.board);
      return CheckPlaces(boards_, now);
    }
    if (clock_.Now() >= deadline) return Fail(known);
    clock_.SleepUntil(std::min(deadline, clock_.Now() + kBetweenTries));
  }
}

Status UsbRangeRing::Find(std::size_t board, nanoseconds deadline) {
  UsbBoardLink& link = links_[board];
  if (!link.broken()) {
    if (IdentifyBoard(*link.port(), options_)) return {};
  }
  while (true) {
    link.Attach(boards_[board], nullptr);  // closed first: the same device can not be opened twice
    auto port = OpenPort(*host_, link.identity(), clock_, deadline);
    if (!port) return FailUsb("open " + link.name(), port.error());
    const auto known = Quieten(**port, options_);
    if (known) {
      boards_[board] = known->board;
      link.Attach(known->board, std::move(*port));
      return {};
    }
    // It may be there, but still starting.
    if (clock_.Now() >= deadline) return Fail(known);
    port->reset();
    clock_.SleepUntil(std::min(deadline, clock_.Now() + kBetweenTries));
  }
}

Result<ClockExchange> UsbRangeRing::ReadClock(std::size_t board) {
  ENSURE(board < links_.size() || (reference_ && board == links_.size()), "the board is one of boards(), or beside");
  if (state_ == State::kFailed) return Fail(CheckRingState("read a board's clock", state_, State::kStreaming));
  RETURN_IF_ERROR(usable_);
  if (board == links_.size()) return reference_->ReadClock(clock_);
  const std::string attempted = "read the clock of " + links_[board].name();
  UsbPort* const port = links_[board].port();
  if (port == nullptr) return Fail(attempted, "it is not plugged in", "plug it in, then open the ring again");
  auto [exchange, reply] = AskClock(*port, options_.control_timeout, clock_);
  if (!reply) {
    trouble_ = reply.error().status == UsbStatus::kNoDevice ? RingTrouble::kBoardLost : RingTrouble::kBus;
    return FailUsb(attempted, reply.error());
  }
  trouble_ = RingTrouble::kData;
  const auto time = DecodeDeviceTime(*reply);
  if (!time) return Fail(time);
  exchange.device_time = *time;
  return exchange;
}

}  // namespace

Result<std::unique_ptr<RangeRing>> MakeUsbRangeRing(const std::vector<UsbPort*>& ports, UsbRangeRingOptions options,
                                                    Clock& clock) {
  ENSURE(options.transfers_per_board > 0, "a board is read by transfers");
  UsbRingParts parts;
  if (options.reference) parts.reference.emplace(options);
  std::vector<UsbPort*> of_ring;
  for (UsbPort* port : ports) {
    ENSURE(port != nullptr, "every board has a port");
    if (IsReference(port->identity(), options)) {
      parts.reference->Adopt(*port);
    } else {
      of_ring.push_back(port);
    }
  }
  const auto known = IdentifyBoards(of_ring, options);
  if (!known) return Fail(known);
  for (const IdentifiedBoard& one : *known) {
    parts.boards.push_back(one.board);
    parts.links.emplace_back(one.board, *one.port);
  }
  parts.limits = CommonLimits(*known, options.sensor_count);
  return std::make_unique<UsbRangeRing>(std::move(parts), std::move(options), nullptr, clock);
}

Result<std::unique_ptr<RangeRing>> OpenUsbRangeRing(UsbHost& host, UsbRangeRingOptions options, Clock& clock) {
  ENSURE(options.transfers_per_board > 0, "a board is read by transfers");
  auto opened = OpenListedBoards(host, options, clock, clock.Now() + kOpenDeadline);
  if (!opened) return Fail(opened);
  UsbRingParts parts;
  if (options.reference) parts.reference.emplace(options);
  std::vector<UsbPort*> of_ring;
  for (auto& port : *opened) {
    if (IsReference(port->identity(), options)) {
      parts.reference->Adopt(std::move(port));
    } else {
      of_ring.push_back(port.get());
    }
  }
  const auto known = IdentifyBoards(of_ring, options);
  if (!known) return Fail(known);
  for (const IdentifiedBoard& one : *known) {
    RETURN_IF_ERROR(Quieten(*one.port, options));
    const auto owner =
        std::find_if(opened->begin(), opened->end(), [&](const auto& port) { return port.get() == one.port; });
    parts.boards.push_back(one.board);
    parts.links.emplace_back(one.board, std::move(*owner));
  }
  parts.limits = CommonLimits(*known, options.sensor_count);
  return std::make_unique<UsbRangeRing>(std::move(parts), std::move(options), &host, clock);
}

}  // namespace annulus
