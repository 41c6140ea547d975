#include "sim/ring_firmware.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/ensure.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

/// Between the two parts of a frame that does not go out in one.
constexpr nanoseconds kSplitGap = std::chrono::microseconds(125);

tl::unexpected<UsbFailure> FailWith(UsbStatus status) { return tl::unexpected<UsbFailure>(UsbFailure{status, {}}); }

template <std::size_t N>
std::vector<std::byte> ToVector(const std::array<std::byte, N>& bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

RingBoardModel::RingBoardModel(RingBoardOptions options, World& world, SyncLine& sync, Clock& clock)
    : options_(options), core_(options, world), sync_(sync), clock_(clock) {
  identity_ = {0x1209, 0xA180, "RB" + std::to_string(options_.serial),
               "1-1." + std::to_string(options_.first_sensor / kSensorsPerBoard + 1)};
  control_engine_.seed(core_.BoardBits(BoardDraw::kControl));
}

void RingBoardModel::UnplugAt(nanoseconds time) {
  unplug_time_ = time;
  if (drives_sync_) sync_.stop = std::min(sync_.stop, time);
}

void RingBoardModel::PlugIn() {
  ENSURE(in_flight() == 0, "the transfers of the unplugged board have been collected");
  unplug_time_.reset();
  armed_ = drives_sync_ = false;
  fifo_.clear();
}

nanoseconds RingBoardModel::EdgeTime(std::uint32_t sequence) const { return sync_.EdgeTime(first_edge_ + sequence); }

bool RingBoardModel::WillFire(std::uint32_t sequence) const {
  return armed_ && sync_.run == sync_run_ && EdgeTime(sequence) < sync_.stop;
}

nanoseconds RingBoardModel::FireTime(std::uint32_t sequence) const {
  return core_.FireTime(sequence, EdgeTime(sequence));
}

nanoseconds RingBoardModel::ArrivalTime(std::uint32_t sequence) const {
  return core_.ReadyTime(sequence, FireTime(sequence), sync_.period_ns);
}

nanoseconds RingBoardModel::ControlTime() {
  const double extra = -std::log1p(-UnitFromBits(control_engine_()));
  return options_.control_delay + ShareOf(options_.control_jitter, extra);
}

UsbResult<nanoseconds> RingBoardModel::Exchange(nanoseconds timeout) {
  const nanoseconds sent = clock_.Now();
  const nanoseconds there = ControlTime();
  const nanoseconds back = ControlTime();
  if (Unplugged()) return FailWith(UsbStatus::kNoDevice);
  clock_.SleepUntil(sent + std::min(there + back, timeout));
  Advance();
  if (there + back > timeout) return FailWith(UsbStatus::kTimedOut);
  if (Unplugged()) return FailWith(UsbStatus::kNoDevice);
  return sent + there;
}

UsbResult<std::vector<std::byte>> RingBoardModel::ControlIn(UsbRequest request, std::size_t length,
                                                            nanoseconds timeout) {
  const auto taken = Exchange(timeout);
  if (!taken) return tl::unexpected<UsbFailure>(taken.error());
  std::vector<std::byte> reply;
  switch (static_cast<BoardRequest>(request.request)) {
    case BoardRequest::kIdentify: {
      const auto claim = [&](BoardFaultKind kind, auto truth) {
        return static_cast<decltype(truth)>(core_.faults().Value(kind, *taken).value_or(truth));
      };
      BoardIdentity identity;
      identity.protocol_version = claim(BoardFaultKind::kProtocol, identity.protocol_version);
      identity.firmware_version = kBoardFirmwareVersion;
      identity.firmware_version[0] = claim(BoardFaultKind::kFirmware, kBoardFirmwareVersion[0]);
      identity.serial = claim(BoardFaultKind::kSerial, options_.serial);
      identity.first_sensor = claim(BoardFaultKind::kPlace, options_.first_sensor);
      identity.min_level_rate_mhz = kBoardMinLevelRateMhz;
      identity.max_level_rate_mhz = options_.max_level_rate_mhz;
      reply = ToVector(EncodeBoardIdentity(identity));
      break;
    }
    case BoardRequest::kReadClock:
      reply = ToVector(EncodeDeviceTime(DeviceTime(*taken)));
      break;
    default:
      return FailWith(UsbStatus::kStall);
  }
  reply.resize(std::min(reply.size(), length));
  return reply;
}

UsbResult<void> RingBoardModel::ControlOut(UsbRequest request, std::span<const std::byte> data, nanoseconds timeout) {
  const auto taken = Exchange(timeout);
  if (!taken) return tl::unexpected<UsbFailure>(taken.error());
  switch (static_cast<BoardRequest>(request.request)) {
    case BoardRequest::kArm: {
      const auto rate = DecodeLevelRate(data);
      if (!rate || *rate < kBoardMinLevelRateMhz || *rate > options_.max_level_rate_mhz)
        return FailWith(UsbStatus::kStall);
      level_rate_mhz_ = *rate;
      armed_ = true;
      core_.StartRun();
      next_sequence_ = 0;
      sync_run_ = sync_.run;
      first_edge_ = 0;
      if (*taken >= sync_.stop) {
        ++sync_run_;  // the line is quiet: wait for it to start again
      } else if (*taken > sync_.start) {
        first_edge_ = sync_.EdgeFrom(*taken);
      }
      return {};
    }
    case BoardRequest::kStartSync:
      if (!armed_) return FailWith(UsbStatus::kStall);
      // The period is counted on this board's own crystal; the first edge comes one period after the order.
      sync_.period_ns = core_.CrystalNs(1e12 / level_rate_mhz_);
      sync_.start = *taken + nanoseconds(std::llround(sync_.period_ns));
      sync_.stop = unplug_time_.value_or(nanoseconds::max());
      ++sync_.run;
      drives_sync_ = true;
      return {};
    case BoardRequest::kStop:
      if (drives_sync_) sync_.stop = *taken;
      drives_sync_ = false;
      armed_ = false;
      fifo_.clear();
      return {};
    default:
      return FailWith(UsbStatus::kStall);
  }
}

UsbResult<UsbToken> RingBoardModel::SubmitBulkIn(std::uint8_t endpoint, std::size_t length) {
  ENSURE(length > 0, "a transfer has room");
  Advance();
  if (Unplugged()) return FailWith(UsbStatus::kNoDevice);
  if (endpoint != kLevelEndpoint) return FailWith(UsbStatus::kError);
  const UsbToken token{next_token_++};
  pending_.push_back({token, length, clock_.Now()});
  MatchTransfers();
  return token;
}

void RingBoardModel::Cancel(UsbToken token) {
  Advance();
  const auto found =
      std::find_if(pending_.begin(), pending_.end(), [&](const Transfer& transfer) { return transfer.token == token; });
  if (found == pending_.end()) return;
  completed_.push_back({token, UsbStatus::kCancelled, {}, clock_.Now()});
  pending_.erase(found);
}

UsbResult<void> RingBoardModel::ClearHalt(std::uint8_t) {
  if (Unplugged()) return FailWith(UsbStatus::kNoDevice);
  return {};
}

std::optional<UsbCompletion> RingBoardModel::WaitCompletion(nanoseconds deadline) {
  while (true) {
    Advance();
    if (!completed_.empty()) {
      UsbCompletion completion = std::move(completed_.front());
      completed_.pop_front();
      return completion;
    }
    if (clock_.Now() >= deadline) return std::nullopt;
    const auto next = NextEvent();
    clock_.SleepUntil(next ? std::min(*next, deadline) : deadline);
  }
}

std::optional<nanoseconds> RingBoardModel::NextEvent() const {
  std::optional<nanoseconds> next;
  const auto consider = [&](nanoseconds time) {
    if (time > clock_.Now()) next = std::min(next.value_or(time), time);
  };
  if (!fifo_.empty() && !pending_.empty()) consider(fifo_.front().time);
  if (WillFire(next_sequence_)) consider(ArrivalTime(next_sequence_));
  if (unplug_time_) consider(*unplug_time_);
  return next;
}

void RingBoardModel::Advance() {
  const nanoseconds now = clock_.Now();
  const nanoseconds alive_until = unplug_time_ ? std::min(now, *unplug_time_) : now;
  while (WillFire(next_sequence_) && ArrivalTime(next_sequence_) <= alive_until) SendFrame(next_sequence_++);
  MatchTransfers();
  if (!Unplugged()) return;
  for (const Transfer& transfer : pending_) {
    completed_.push_back({transfer.token, UsbStatus::kNoDevice, {}, *unplug_time_});
  }
  pending_.clear();
}

void RingBoardModel::SendFrame(std::uint32_t sequence) {
  MatchTransfers();
  if (core_.faults().Value(BoardFaultKind::kSilent, FireTime(sequence))) return;
  if (fifo_.size() >= options_.fifo_frames) {
    ++dropped_frames_;
    return;
  }
  const auto bytes = EncodeLevelFrame(core_.Measure(sequence, FireTime(sequence)));
  const nanoseconds arrival = ArrivalTime(sequence);
  const std::uint64_t bits = core_.LevelBits(sequence, BoardDraw::kSplit);
  if (UnitFromBits(bits) >= options_.split_share) {
    fifo_.push_back({arrival, ToVector(bytes)});
    return;
  }
  const auto cut = static_cast<std::ptrdiff_t>(1 + bits % (bytes.size() - 1));
  fifo_.push_back({arrival, {bytes.begin(), bytes.begin() + cut}});
  fifo_.push_back({arrival + kSplitGap, {bytes.begin() + cut, bytes.end()}});
}

void RingBoardModel::MatchTransfers() {
  const nanoseconds now = clock_.Now();
  while (!pending_.empty() && !fifo_.empty() && fifo_.front().time <= now) {
    const Transfer transfer = pending_.front();
    pending_.pop_front();
    UsbCompletion completion{
        transfer.token, UsbStatus::kCompleted, {}, std::max(fifo_.front().time, transfer.submitted)};
    // What had piled up when the host asked goes out together, as far as it fits.
    do {
      std::vector<std::byte>& bytes = fifo_.front().bytes;
      const std::size_t room = transfer.length - completion.data.size();
      const auto fitting = bytes.begin() + static_cast<std::ptrdiff_t>(std::min(room, bytes.size()));
      completion.data.insert(completion.data.end(), bytes.begin(), fitting);
      bytes.erase(bytes.begin(), fitting);
      if (bytes.empty()) fifo_.pop_front();
    } while (!fifo_.empty() && fifo_.front().time <= transfer.submitted && completion.data.size() < transfer.length);
    completed_.push_back(std::move(completion));
  }
}

}  // namespace annulus::sim
