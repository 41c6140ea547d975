#include "firmware_iface/usb_reference.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/ensure.h"
#include "firmware_iface/ring_boards.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// What a request to a board that may be dead costs the ring at most.
constexpr nanoseconds kPatience = std::chrono::milliseconds(50);

/// The ring's options for this board alone.
UsbRangeRingOptions Alone(UsbRangeRingOptions options) {
  ENSURE(options.reference, "the ring has a reference board");
  for (const std::uint8_t channel : options.reference->channels) {
    ENSURE(channel < kSensorsPerBoard, "a board has channels 0 to 14");
  }
  options.first_sensors = {{options.reference->serial, kNotInRing}};
  return options;
}

}  // namespace

UsbReference::UsbReference(const UsbRangeRingOptions& options)
    : options_(Alone(options)), patience_(std::min(options.control_timeout, kPatience)) {
  board_.serial = options_.reference->serial;
  board_.trouble = "it was not there when the ring was opened";
}

void UsbReference::Adopt(UsbPort& port) {
  const auto known = Quieten(port, options_);
  if (!known) return Lose(known.error());
  board_.board = known->board;
  board_.trouble.clear();
  link_.emplace(known->board, port);
}

void UsbReference::Adopt(std::unique_ptr<UsbPort> port) {
  const auto known = Quieten(*port, options_);
  if (!known) return Lose(known.error());
  board_.board = known->board;
  board_.trouble.clear();
  link_.emplace(known->board, std::move(port));
}

void UsbReference::Lose(const Error& error) { board_.trouble = error.attempted + ": " + error.seen; }

void UsbReference::Start(std::span<const std::byte> rate, Clock& clock) {
  if (!link_) return;
  link_->Reset();
  board_.trouble.clear();
  // As for the ring's boards: what is stamped earlier belongs to an earlier run.
  const auto now = ReadClock(clock);
  if (!now) return;
  link_->IgnoreBefore(now->device_time);
  Status armed = link_->Order(BoardRequest::kArm, rate, patience_, "arm ");
  for (std::size_t i = 0; armed && i < options_.transfers_per_board; ++i) armed = link_->Submit();
  if (!armed) Lose(armed.error());
}

Status UsbReference::Await(nanoseconds deadline) {
  if (!reads()) return {};
  const Status awaited = link_->Await(deadline);
  if (!awaited && link_->trouble() == RingTrouble::kEmitter) return awaited;
  if (!awaited) {
    Lose(awaited.error());
  } else if (!link_->has_frame()) {
    board_.trouble = "read " + link_->name() + ": it says nothing";
  }
  return {};
}

void UsbReference::Put(std::uint32_t sequence, RingLevel& level) {
  const std::vector<std::uint8_t>& channels = options_.reference->channels;
  level.reference_range_mm.assign(channels.size(), std::numeric_limits<double>::quiet_NaN());
  level.reference_quality.assign(channels.size(), 0);
  if (!reads()) return;
  const auto arrived = link_->TakeFrame(sequence);
  if (!arrived) {
    if (link_->loses_frames()) board_.trouble = "read " + link_->name() + ": it loses frames repeatedly";
    return;
  }
  const LevelFrame& frame = arrived->frame;
  level.reference = {true, frame.device_time, arrived->host_arrival, frame.temperature_centi_c / 100.0};
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (frame.range_um[channels[i]] == kNoReturn) continue;
    level.reference_range_mm[i] = frame.range_um[channels[i]] / 1000.0;
    level.reference_quality[i] = frame.quality[channels[i]];
  }
}

Result<ClockExchange> UsbReference::ReadClock(Clock& clock) {
  const std::string attempted = "read the clock of reference board " + std::to_string(board_.serial);
  if (!reads()) return Fail(attempted, board_.trouble, "check its cable and supply; the ring does without it");
  if (link_->port() == nullptr) {
    board_.trouble = attempted + ": it is not plugged in";
    return Fail(attempted, "it is not plugged in", "plug it in; the ring does without it");
  }
  auto [exchange, reply] = AskClock(*link_->port(), patience_, clock);
  const auto time = reply ? DecodeDeviceTime(*reply) : FailUsb(attempted, reply.error());
  if (!time) {
    Lose(time.error());
    return Fail(time);
  }
  exchange.device_time = *time;
  return exchange;
}

void UsbReference::BeginStop() {
  if (!link_ || link_->port() == nullptr) return;
  // Without SYNC, which the ring's first board has ended, it does not fire even if it does not hear.
  static_cast<void>(link_->Order(BoardRequest::kStop, {}, patience_, "stop "));
  link_->CancelAll();
}

void UsbReference::EndStop(nanoseconds deadline) {
  if (!link_) return;
  if (const Status ended = link_->EndTransfers(deadline); !ended) Lose(ended.error());
}

void UsbReference::Reopen(UsbHost* host, Clock& clock) {
  if (!link_) return;
  board_.trouble.clear();
  if (!link_->broken() && IdentifyBoard(*link_->port(), options_)) return;
  if (host == nullptr) {
    const auto known = IdentifyBoard(*link_->port(), options_);
    return known ? void() : Lose(known.error());
  }
  link_->Attach(*board_.board, nullptr);  // closed first: the same device can not be opened twice
  auto port = OpenPort(*host, link_->identity(), clock, clock.Now());
  if (!port) {
    board_.trouble = "open " + link_->name() + ": it is not plugged in";
    return;
  }
  const auto known = Quieten(**port, options_);
  if (!known) return Lose(known.error());
  board_.board = known->board;
  link_->Attach(known->board, std::move(*port));
}

}  // namespace annulus
