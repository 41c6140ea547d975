#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>
#include <utility>

#include "base/ensure.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/ring_boards.h"
#include "firmware_iface/usb_frame_codec.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// Large enough for several frames that piled up in a board, and a multiple of the 512-byte packets of high speed.
constexpr std::size_t kTransferBytes = 2048;
constexpr nanoseconds kStopDeadline = std::chrono::seconds(1);
/// Leaky bucket of lost frames: one more per lost frame, this much less per good one, an Error at the limit.
constexpr double kLossLeak = 1.0 / 30.0;
constexpr double kLossLimit = 4.0;
/// Transfers in a row that may end badly before the board counts as gone.
constexpr int kMostBadTransfers = 3;
/// Transfers of one board per level beyond which it is talking nonsense.
constexpr int kMostTransfersPerLevel = 1000;

struct ArrivedFrame {
  LevelFrame frame;
  nanoseconds host_arrival{0};
};

struct BoardLink {
  explicit BoardLink(UsbPort* usb_port) : port(usb_port) {}

  UsbPort* port;
  UsbFrameAssembler assembler;
  std::deque<ArrivedFrame> frames;  ///< Whole, not yet given out, sequence strictly rising.
  std::vector<UsbToken> tokens;     ///< In flight.
  double losses = 0.0;              ///< Leaky bucket.
  int bad_transfers = 0;            ///< In a row.
};

const char* StateText(RangeRing::State state) {
  switch (state) {
    case RangeRing::State::kIdle:
      return "idle";
    case RangeRing::State::kStreaming:
      return "streaming";
    case RangeRing::State::kFailed:
      return "failed";
  }
  return "unknown";
}

class UsbRangeRing final : public RangeRing {
 public:
  UsbRangeRing(std::vector<RingBoard> boards, const std::vector<UsbPort*>& ports, RingLimits limits,
               UsbRangeRingOptions options, Clock& clock)
      : boards_(std::move(boards)), limits_(limits), options_(std::move(options)), clock_(clock) {
    for (UsbPort* port : ports) links_.emplace_back(port);
  }
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

 private:
  [[nodiscard]] Status Gate(const char* call, State required) const;
  Status StartBoards(Hertz level_rate);
  Status Order(std::size_t board, BoardRequest request, std::span<const std::byte> data, const char* what);
  Status Submit(std::size_t board);
  /// Collects until the board has the frame of the wanted level or a later one, or the deadline is over.
  Status Await(std::size_t board, nanoseconds deadline);
  Status Take(std::size_t board, const UsbCompletion& completion);
  Status Sort(std::size_t board, const LevelFrame& frame, nanoseconds host_arrival);
  Result<RingLevel> Assemble();
  [[nodiscard]] bool HasFrame(std::size_t board) const { return !links_[board].frames.empty(); }
  [[nodiscard]] Status CheckAllSpoke() const;
  Status EndTransfers(std::size_t board, nanoseconds deadline);
  void CountRejected();

  std::vector<RingBoard> boards_;
  std::vector<BoardLink> links_;  ///< Same order as boards_.
  RingLimits limits_;
  UsbRangeRingOptions options_;
  Clock& clock_;
  State state_ = State::kIdle;
  RingCounters counters_;
  std::uint32_t wanted_ = 0;  ///< Sequence of the next level.
};

Status UsbRangeRing::Gate(const char* call, State required) const {
  if (state_ == required) return {};
  return Fail(call, std::string("the ring is ") + StateText(state_) + ", it must be " + StateText(required),
              "stop the ring and start it again");
}

Status UsbRangeRing::Start(Hertz level_rate) {
  RETURN_IF_ERROR(Gate("start the ring", State::kIdle));
  if (!(level_rate >= limits_.min_level_rate && level_rate <= limits_.max_level_rate)) {
    return Fail("start the ring",
                "a level rate of " + std::to_string(level_rate.value()) + " Hz; the boards allow " +
                    std::to_string(limits_.min_level_rate.value()) + " to " +
                    std::to_string(limits_.max_level_rate.value()),
                "correct the scan plan");
  }
  counters_ = {};
  wanted_ = 0;
  for (BoardLink& link : links_) link = BoardLink(link.port);
  state_ = State::kStreaming;
  if (Status started = StartBoards(level_rate); !started) {
    state_ = State::kFailed;
    static_cast<void>(Stop());
    return started;
  }
  return {};
}

Status UsbRangeRing::StartBoards(Hertz level_rate) {
  const auto rate = EncodeLevelRate(static_cast<std::uint32_t>(std::lround(level_rate.value() * 1000.0)));
  for (std::size_t board = 0; board < links_.size(); ++board) {
    RETURN_IF_ERROR(Order(board, BoardRequest::kArm, rate, "arm "));
    for (std::size_t i = 0; i < options_.transfers_per_board; ++i) RETURN_IF_ERROR(Submit(board));
  }
  return Order(0, BoardRequest::kStartSync, {}, "start SYNC on ");
}

Status UsbRangeRing::Order(std::size_t board, BoardRequest request, std::span<const std::byte> data, const char* what) {
  const auto done = links_[board].port->ControlOut(RequestTo(request), data, options_.control_timeout);
  if (!done) return FailUsb(what + BoardName(boards_[board]), done.error());
  return {};
}

Status UsbRangeRing::Submit(std::size_t board) {
  auto token = links_[board].port->SubmitBulkIn(kLevelEndpoint, kTransferBytes);
  if (!token) return FailUsb("receive from " + BoardName(boards_[board]), token.error());
  links_[board].tokens.push_back(*token);
  return {};
}

Result<RingLevel> UsbRangeRing::NextLevel(nanoseconds deadline) {
  RETURN_IF_ERROR(Gate("read a level of the ring", State::kStreaming));
  for (std::size_t board = 0; board < links_.size(); ++board) {
    if (Status awaited = Await(board, deadline); !awaited) {
      state_ = State::kFailed;
      return Fail(awaited);
    }
  }
  CountRejected();
  if (Status spoke = CheckAllSpoke(); !spoke) {
    state_ = State::kFailed;
    return Fail(spoke);
  }
  return Assemble();
}

Status UsbRangeRing::Await(std::size_t board, nanoseconds deadline) {
  for (int transfers = 0; !HasFrame(board); ++transfers) {
    if (transfers == kMostTransfersPerLevel) {
      return Fail("read a level of the ring", BoardName(boards_[board]) + " sends much, but no level frames",
                  "power-cycle the ring; replace the board if it happens again");
    }
    const auto completion = links_[board].port->WaitCompletion(deadline);
    if (!completion) return {};
    RETURN_IF_ERROR(Take(board, *completion));
  }
  return {};
}

Status UsbRangeRing::Take(std::size_t board, const UsbCompletion& completion) {
  BoardLink& link = links_[board];
  std::erase(link.tokens, completion.token);
  const std::string attempted = "read " + BoardName(boards_[board]);
  switch (completion.status) {
    case UsbStatus::kCompleted:
    case UsbStatus::kTimedOut:
      link.bad_transfers = 0;
      break;
    case UsbStatus::kNoDevice:
    case UsbStatus::kNoMemory:
      return FailUsb(attempted, {completion.status, {}});
    case UsbStatus::kStall:
      if (const auto cleared = link.port->ClearHalt(kLevelEndpoint); !cleared) {
        return FailUsb(attempted, cleared.error());
      }
      [[fallthrough]];
    case UsbStatus::kCancelled:
    case UsbStatus::kOverflow:
    case UsbStatus::kError:
      if (++link.bad_transfers > kMostBadTransfers) return FailUsb(attempted, {completion.status, {}});
      break;
  }
  // Data is used whatever the status: the checksums say what of it is whole.
  for (const LevelFrame& frame : link.assembler.Push(completion.data)) {
    RETURN_IF_ERROR(Sort(board, frame, completion.host_time));
  }
  return Submit(board);
}

Status UsbRangeRing::Sort(std::size_t board, const LevelFrame& frame, nanoseconds host_arrival) {
  BoardLink& link = links_[board];
  if (frame.board_serial != boards_[board].serial) {
    return Fail("read " + BoardName(boards_[board]), "frames of board " + std::to_string(frame.board_serial),
                "check that no two boards have the same number, and start again");
  }
  if ((frame.status & kFrameEmitterFault) != 0) {
    return Fail("read " + BoardName(boards_[board]), "it reports an emitter fault",
                "keep the ring off and have the board replaced");
  }
  const std::uint32_t earliest = link.frames.empty() ? wanted_ : link.frames.back().frame.sequence + 1;
  if (frame.sequence < earliest) {
    ++counters_.duplicate_frames;
    return {};
  }
  link.frames.push_back({frame, host_arrival});
  return {};
}

Status UsbRangeRing::CheckAllSpoke() const {
  std::string silent;
  std::size_t count = 0;
  for (std::size_t board = 0; board < links_.size(); ++board) {
    if (HasFrame(board)) continue;
    ++count;
    silent += (silent.empty() ? "" : ", ") + BoardName(boards_[board]);
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
    BoardLink& link = links_[board];
    // USB keeps the order, so a later frame means that the wanted one is lost for good.
    if (link.frames.front().frame.sequence != wanted_) {
      ++counters_.lost_frames;
      link.losses += 1.0;
      if (link.losses < kLossLimit) continue;
      state_ = State::kFailed;
      return Fail("read level " + std::to_string(wanted_) + " of the ring",
                  BoardName(boards_[board]) + " loses frames repeatedly",
                  "check the board's cable and the host's load, then start again");
    }
    const ArrivedFrame& arrived = link.frames.front();
    const LevelFrame& frame = arrived.frame;
    level.boards[board] = {true, frame.device_time, arrived.host_arrival, frame.temperature_centi_c / 100.0};
    for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
      if (frame.range_um[i] == kNoReturn) continue;
      level.range_mm[boards_[board].first_sensor + i] = frame.range_um[i] / 1000.0;
      level.quality[boards_[board].first_sensor + i] = frame.quality[i];
    }
    link.frames.pop_front();
    link.losses = std::max(0.0, link.losses - kLossLeak);
  }
  ++wanted_;
  ++counters_.levels;
  return level;
}

void UsbRangeRing::CountRejected() {
  counters_.rejected_bytes = 0;
  counters_.rejected_frames = 0;
  for (const BoardLink& link : links_) {
    counters_.rejected_bytes += link.assembler.rejected_bytes();
    counters_.rejected_frames += link.assembler.rejected_frames();
  }
}

Status UsbRangeRing::Stop() {
  Status result;
  for (std::size_t board = 0; board < links_.size(); ++board) {
    const Status stopped = Order(board, BoardRequest::kStop, {}, "stop ");
    // A board that is already known to be lost can not be stopped, and need not be.
    if (!stopped && result && state_ == State::kStreaming) result = stopped;
    for (UsbToken token : links_[board].tokens) links_[board].port->Cancel(token);
  }
  const nanoseconds deadline = clock_.Now() + kStopDeadline;
  for (std::size_t board = 0; board < links_.size(); ++board) {
    const Status ended = EndTransfers(board, deadline);
    if (!ended && result) result = ended;
  }
  CountRejected();
  state_ = State::kIdle;
  return result;
}

Status UsbRangeRing::EndTransfers(std::size_t board, nanoseconds deadline) {
  BoardLink& link = links_[board];
  while (link.port->in_flight() > 0) {
    const auto completion = link.port->WaitCompletion(deadline);
    if (!completion) {
      return Fail("stop " + BoardName(boards_[board]), "USB transfers do not end within 1 s",
                  "unplug the ring and restart the program");
    }
    std::erase(link.tokens, completion->token);
  }
  link.tokens.clear();
  return {};
}

Status UsbRangeRing::Reopen(nanoseconds deadline) {
  RETURN_IF_ERROR(Gate("open the ring again", State::kIdle));
  std::vector<UsbPort*> ports;
  for (const BoardLink& link : links_) ports.push_back(link.port);
  while (true) {
    const auto known = IdentifyBoards(ports, options_);
    if (known) return {};
    if (clock_.Now() >= deadline) return Fail(known);
    clock_.SleepUntil(std::min(deadline, clock_.Now() + std::chrono::milliseconds(50)));
  }
}

Result<ClockExchange> UsbRangeRing::ReadClock(std::size_t board) {
  ENSURE(board < links_.size(), "the board is one of boards()");
  if (state_ == State::kFailed) return Fail(Gate("read a board's clock", State::kStreaming));
  ClockExchange exchange;
  exchange.host_before = clock_.Now();
  const auto reply = links_[board].port->ControlIn(RequestTo(BoardRequest::kReadClock), sizeof(std::uint64_t),
                                                   options_.control_timeout);
  exchange.host_after = clock_.Now();
  if (!reply) return FailUsb("read the clock of " + BoardName(boards_[board]), reply.error());
  const auto time = DecodeDeviceTime(*reply);
  if (!time) return Fail(time);
  exchange.device_time = *time;
  return exchange;
}

}  // namespace

Result<std::unique_ptr<RangeRing>> MakeUsbRangeRing(const std::vector<UsbPort*>& ports, UsbRangeRingOptions options,
                                                    Clock& clock) {
  ENSURE(options.transfers_per_board > 0, "a board is read by transfers");
  for (const UsbPort* port : ports) ENSURE(port != nullptr, "every board has a port");
  const auto known = IdentifyBoards(ports, options);
  if (!known) return Fail(known);

  RingLimits limits{options.sensor_count, Hertz(0.0), Hertz(std::numeric_limits<double>::infinity())};
  std::vector<RingBoard> boards;
  std::vector<UsbPort*> sorted_ports;
  for (const IdentifiedBoard& one : *known) {
    limits.min_level_rate = std::max(limits.min_level_rate, one.limits.min_level_rate);
    limits.max_level_rate = std::min(limits.max_level_rate, one.limits.max_level_rate);
    boards.push_back(one.board);
    sorted_ports.push_back(one.port);
  }
  return std::make_unique<UsbRangeRing>(std::move(boards), sorted_ports, limits, std::move(options), clock);
}

}  // namespace annulus
