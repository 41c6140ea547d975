#include "firmware_iface/usb_board_link.h"

#include <algorithm>
#include <utility>

#include "firmware_iface/ring_boards.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// Transfers in a row that may end badly before the board counts as gone.
constexpr int kMostBadTransfers = 3;
/// Transfers of one board per level beyond which it is talking nonsense.
constexpr int kMostTransfersPerLevel = 1000;
/// Good transfers after which a halt is forgotten.
constexpr int kStallForgotten = 30;
constexpr nanoseconds kLongAgo{0};

}  // namespace

UsbBoardLink::UsbBoardLink(const RingBoard& board, UsbPort& port)
    : serial_(board.serial), name_(BoardName(board)), port_(&port), identity_(port.identity()) {}

UsbBoardLink::UsbBoardLink(const RingBoard& board, std::unique_ptr<UsbPort> port) : UsbBoardLink(board, *port) {
  owned_ = std::move(port);
}

void UsbBoardLink::Attach(const RingBoard& board, std::unique_ptr<UsbPort> port) {
  serial_ = board.serial;
  name_ = BoardName(board);
  owned_ = std::move(port);
  port_ = owned_.get();
  if (port_ != nullptr) identity_ = port_->identity();
  Reset();
}

void UsbBoardLink::Reset() {
  gone_ = broken_ = port_ == nullptr;
  assembler_ = UsbFrameAssembler();
  frames_.clear();
  tokens_.clear();
  earliest_ = 0;
  run_begin_ = nanoseconds(0);
  losses_ = {};
  bad_transfers_ = 0;
  excused_stalls_ = 0;
  good_since_stall_ = kStallForgotten;
  duplicate_frames_ = 0;
}

tl::unexpected<Error> UsbBoardLink::Broken(const UsbFailure& failure) {
  broken_ = true;
  gone_ = gone_ || failure.status == UsbStatus::kNoDevice;
  return FailUsb("read " + name_, failure);
}

Status UsbBoardLink::Order(BoardRequest request, std::span<const std::byte> data, nanoseconds timeout,
                           const char* what) {
  if (port_ == nullptr) return Fail(what + name_, "it is not plugged in", "plug it in, then open the ring again");
  const auto done = port_->ControlOut(RequestTo(request), data, timeout);
  if (done) return {};
  static_cast<void>(Broken(done.error()));
  return FailUsb(what + name_, done.error());
}

Status UsbBoardLink::Submit() {
  // Room first: a transfer that runs and of which nothing is known could never be ended.
  if (tokens_.size() == tokens_.capacity()) tokens_.reserve(2 * tokens_.size() + 4);
  auto token = port_->SubmitBulkIn(kLevelEndpoint, kTransferBytes);
  if (!token) return Broken(token.error());
  tokens_.push_back(*token);
  return {};
}

Status UsbBoardLink::Await(nanoseconds deadline) {
  for (int transfers = 0; !has_frame(); ++transfers) {
    if (transfers == kMostTransfersPerLevel) {
      trouble_ = RingTrouble::kData;
      return Fail("read a level of the ring", name_ + " sends much, but no level frames",
                  "power-cycle the ring; replace the board if it happens again");
    }
    const auto completion = port_->WaitCompletion(deadline);
    if (!completion) return {};
    RETURN_IF_ERROR(Take(*completion));
  }
  return {};
}

Status UsbBoardLink::Collect() {
  // No more than is in flight now: a board that answers each new transfer at once must not keep us here.
  for (std::size_t left = tokens_.size(); left > 0; --left) {
    const auto completion = port_->WaitCompletion(kLongAgo);
    if (!completion) return {};
    RETURN_IF_ERROR(Take(*completion));
  }
  return {};
}

Status UsbBoardLink::Take(const UsbCompletion& completion) {
  std::erase(tokens_, completion.token);
  RETURN_IF_ERROR(Judge(completion.status));
  // Data is used whatever the status: the checksums say what of it is whole.
  for (const LevelFrame& frame : assembler_.Push(completion.data)) {
    RETURN_IF_ERROR(Sort(frame, completion.host_time));
  }
  return Submit();
}

Status UsbBoardLink::Judge(UsbStatus status) {
  switch (status) {
    case UsbStatus::kCompleted:
    case UsbStatus::kTimedOut:
      bad_transfers_ = 0;
      excused_stalls_ = 0;
      good_since_stall_ = std::min(good_since_stall_ + 1, kStallForgotten);
      return {};
    case UsbStatus::kStall:
      return Recover();
    case UsbStatus::kNoDevice:
    case UsbStatus::kNoMemory:
      return Broken({status, {}});
    case UsbStatus::kCancelled:
    case UsbStatus::kOverflow:
    case UsbStatus::kNoAccess:
    case UsbStatus::kBusy:
    case UsbStatus::kError:
      break;
  }
  if (++bad_transfers_ > kMostBadTransfers) return Broken({status, {}});
  return {};
}

/// A halted endpoint is cleared once; what was in flight when it halted may still end so.
Status UsbBoardLink::Recover() {
  if (excused_stalls_ > 0) {
    --excused_stalls_;
    return {};
  }
  if (good_since_stall_ < kStallForgotten) {
    return Broken({UsbStatus::kStall, "again, soon after it was cleared; it must be opened again"});
  }
  if (const auto cleared = port_->ClearHalt(kLevelEndpoint); !cleared) return Broken(cleared.error());
  excused_stalls_ = tokens_.size();
  good_since_stall_ = 0;
  return {};
}

Status UsbBoardLink::Sort(const LevelFrame& frame, nanoseconds host_arrival) {
  if (frame.board_serial != serial_) {
    trouble_ = RingTrouble::kIdentity;
    return Fail("read " + name_, "frames of board " + std::to_string(frame.board_serial),
                "check that no two boards have the same number, and start again");
  }
  if ((frame.status & kFrameEmitterFault) != 0) {
    trouble_ = RingTrouble::kEmitter;
    return Fail("read " + name_, "it reports an emitter fault", "keep the ring off and have the board replaced");
  }
  const std::uint32_t earliest = frames_.empty() ? earliest_ : frames_.back().frame.sequence + 1;
  if (frame.sequence < earliest || frame.device_time < run_begin_) {
    ++duplicate_frames_;
    return {};
  }
  frames_.push_back({frame, host_arrival});
  return {};
}

std::optional<ArrivedFrame> UsbBoardLink::TakeFrame(std::uint32_t sequence) {
  earliest_ = sequence + 1;
  // USB keeps the order, so a later frame means that the wanted one is lost for good.
  if (frames_.front().frame.sequence != sequence) {
    losses_.Lose();
    return std::nullopt;
  }
  ArrivedFrame arrived = frames_.front();
  frames_.pop_front();
  losses_.Keep();
  return arrived;
}

bool UsbBoardLink::loses_frames() const { return losses_.full(); }

void UsbBoardLink::LookWhetherGone() {
  for (std::size_t left = tokens_.size(); left > 0 && !gone_; --left) {
    const auto completion = port_->WaitCompletion(kLongAgo);
    if (!completion) return;
    std::erase(tokens_, completion->token);
    // An unplugged board's transfers may all end well: then the next one can not be submitted.
    if (completion->status == UsbStatus::kNoDevice) gone_ = broken_ = true;
    if (!gone_) static_cast<void>(Submit());
  }
}

void UsbBoardLink::CancelAll() {
  for (const UsbToken token : tokens_) port_->Cancel(token);
}

Status UsbBoardLink::EndTransfers(nanoseconds deadline) {
  while (port_ != nullptr && port_->in_flight() > 0) {
    const auto completion = port_->WaitCompletion(deadline);
    if (!completion) {
      return Fail("stop " + name_, "USB transfers do not end within 1 s", "unplug the ring and restart the program");
    }
    // The end of a stream may be the first to tell that its board is gone.
    if (completion->status == UsbStatus::kNoDevice) gone_ = broken_ = true;
  }
  tokens_.clear();
  return {};
}

}  // namespace annulus
