#include "sim/ring_firmware.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/ensure.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

constexpr std::array<std::uint8_t, 3> kFirmwareVersion{1, 2, 0};
constexpr std::uint32_t kMinLevelRateMhz = 15'000;
/// Between the two parts of a frame that does not go out in one.
constexpr nanoseconds kSplitGap = std::chrono::microseconds(125);

// What a frame's or a board's random number is for, so that each purpose has its own.
constexpr std::uint64_t kForClock = 1;
constexpr std::uint64_t kForDrift = 2;
constexpr std::uint64_t kForDelay = 3;
constexpr std::uint64_t kForControl = 4;
constexpr std::uint64_t kForFire = 5;
constexpr std::uint64_t kForArrival = 6;
constexpr std::uint64_t kForSplit = 7;
constexpr std::uint64_t kForBeam = 8;
constexpr std::uint64_t kForTemperature = 9;

nanoseconds Share(nanoseconds whole, double share) {
  return nanoseconds(std::llround(static_cast<double>(whole.count()) * share));
}

tl::unexpected<UsbFailure> FailWith(UsbStatus status) { return tl::unexpected<UsbFailure>(UsbFailure{status, {}}); }

template <std::size_t N>
std::vector<std::byte> ToVector(const std::array<std::byte, N>& bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

RingBoardModel::RingBoardModel(RingBoardOptions options, World& world, SyncLine& sync, Clock& clock)
    : options_(options), world_(world), sync_(sync), clock_(clock) {
  options_.seed = MixSeed(options.seed, options.serial);
  const auto unit = [this](std::uint64_t purpose) { return UnitFromBits(MixSeed(options_.seed, purpose)); };
  identity_ = {0x1209, 0xA180, "RB" + std::to_string(options_.serial),
               "1-1." + std::to_string(options_.first_sensor / kSensorsPerBoard + 1)};
  control_engine_.seed(MixSeed(options_.seed, kForControl));
  clock_offset_ = Share(std::chrono::seconds(1000), unit(kForClock));
  clock_drift_ = options_.clock_drift_ppm * 1e-6 * (2.0 * unit(kForDrift) - 1.0);
  fire_delay_ = Share(options_.fire_delay, unit(kForDelay));
}

nanoseconds RingBoardModel::DeviceTime(nanoseconds time) const {
  return clock_offset_ + time + nanoseconds(std::llround(static_cast<double>(time.count()) * clock_drift_));
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

std::uint64_t RingBoardModel::FrameBits(std::uint32_t sequence, std::uint64_t purpose) const {
  const std::uint64_t frame = static_cast<std::uint64_t>(runs_) << 32 | sequence;
  return MixSeed(MixSeed(options_.seed, purpose), frame);
}

nanoseconds RingBoardModel::EdgeTime(std::uint32_t sequence) const {
  return sync_.start + nanoseconds(std::llround(static_cast<double>(first_edge_ + sequence) * sync_.period_ns));
}

bool RingBoardModel::WillFire(std::uint32_t sequence) const {
  return armed_ && sync_.run == sync_run_ && EdgeTime(sequence) < sync_.stop;
}

nanoseconds RingBoardModel::FireTime(std::uint32_t sequence) const {
  return EdgeTime(sequence) + fire_delay_ + Share(options_.fire_jitter, UnitFromBits(FrameBits(sequence, kForFire)));
}

nanoseconds RingBoardModel::ArrivalTime(std::uint32_t sequence) const {
  return FireTime(sequence) + options_.frame_delay +
         Share(options_.frame_jitter, UnitFromBits(FrameBits(sequence, kForArrival)));
}

nanoseconds RingBoardModel::ControlTime() {
  const double extra = -std::log1p(-UnitFromBits(control_engine_()));
  return options_.control_delay + Share(options_.control_jitter, extra);
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
      BoardIdentity identity;
      identity.firmware_version = kFirmwareVersion;
      identity.serial = options_.serial;
      identity.first_sensor = options_.first_sensor;
      identity.min_level_rate_mhz = kMinLevelRateMhz;
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
      if (!rate || *rate < kMinLevelRateMhz || *rate > options_.max_level_rate_mhz) return FailWith(UsbStatus::kStall);
      level_rate_mhz_ = *rate;
      armed_ = true;
      ++runs_;
      next_sequence_ = 0;
      sync_run_ = sync_.run;
      first_edge_ = 0;
      if (*taken >= sync_.stop) {
        ++sync_run_;  // the line is quiet: wait for it to start again
      } else if (*taken > sync_.start) {
        first_edge_ = static_cast<std::uint64_t>(
            std::ceil(static_cast<double>((*taken - sync_.start).count()) / sync_.period_ns));
      }
      return {};
    }
    case BoardRequest::kStartSync:
      if (!armed_) return FailWith(UsbStatus::kStall);
      // The period is counted on this board's own crystal; the first edge comes one period after the order.
      sync_.period_ns = 1e12 / level_rate_mhz_ / (1.0 + clock_drift_);
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
  if (fifo_.size() >= options_.fifo_frames) {
    ++dropped_frames_;
    return;
  }
  const auto bytes = EncodeLevelFrame(MeasureLevel(sequence));
  const nanoseconds arrival = ArrivalTime(sequence);
  const std::uint64_t bits = FrameBits(sequence, kForSplit);
  if (UnitFromBits(bits) >= options_.split_share) {
    fifo_.push_back({arrival, ToVector(bytes)});
    return;
  }
  const auto cut = static_cast<std::ptrdiff_t>(1 + bits % (bytes.size() - 1));
  fifo_.push_back({arrival, {bytes.begin(), bytes.begin() + cut}});
  fifo_.push_back({arrival + kSplitGap, {bytes.begin() + cut, bytes.end()}});
}

LevelFrame RingBoardModel::MeasureLevel(std::uint32_t sequence) const {
  const nanoseconds fire = FireTime(sequence);
  const double z = world_.axis.TrueZ(fire);
  const double time_s = static_cast<double>(fire.count()) * 1e-9;
  std::mt19937_64 random(FrameBits(sequence, kForBeam));
  LevelFrame frame;
  frame.board_serial = options_.serial;
  frame.sequence = sequence;
  frame.device_time = DeviceTime(fire);
  frame.temperature_centi_c = static_cast<std::int16_t>(3000 + MixSeed(options_.seed, kForTemperature) % 200);
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    const std::size_t sensor = options_.first_sensor + i;
    const BeamReading reading =
        world_.beam.Measure(world_.subject, world_.ring.RayOf(sensor, z), time_s, world_.max_range_mm, random);
    // The sensor's own zero and scale are what calibration takes out again (RingCalibration::PointOf).
    const SensorCalibration& own = world_.ring.sensors[sensor];
    const double raw_um = std::round((reading.range_mm - own.range_offset_mm) / own.range_scale * 1000.0);
    const bool returned = raw_um >= 0.0 && raw_um < static_cast<double>(kNoReturn);
    frame.range_um[i] = returned ? static_cast<std::uint32_t>(raw_um) : kNoReturn;
    frame.quality[i] = returned ? reading.quality : std::uint8_t{0};
  }
  return frame;
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
