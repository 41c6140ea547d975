#include "sim/ring_board_core.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace annulus::sim {

using std::chrono::nanoseconds;

namespace {

/// What a beam from the wall meets of the ring: half its height, and what it is wider than its sensors' circle.
constexpr double kRingHalfHeightMm = 40.0;
constexpr double kRingWallMm = 50.0;

}  // namespace

nanoseconds ShareOf(nanoseconds whole, double share) {
  return nanoseconds(std::llround(static_cast<double>(whole.count()) * share));
}

nanoseconds SyncLine::EdgeTime(std::uint64_t edge) const {
  return start + nanoseconds(std::llround(static_cast<double>(edge) * period_ns));
}

std::uint64_t SyncLine::EdgeFrom(nanoseconds time) const {
  if (time <= start) return 0;
  return static_cast<std::uint64_t>(std::ceil(static_cast<double>((time - start).count()) / period_ns));
}

RingBoardCore::RingBoardCore(const RingBoardOptions& options, World& world)
    : options_(options), world_(world), seed_(MixSeed(options.seed, options.serial)) {
  const auto unit = [this](BoardDraw purpose) { return UnitFromBits(BoardBits(purpose)); };
  clock_offset_ = ShareOf(std::chrono::seconds(1000), unit(BoardDraw::kClock));
  clock_drift_ = options_.clock_drift_ppm * 1e-6 * (2.0 * unit(BoardDraw::kDrift) - 1.0);
  fire_delay_ = ShareOf(options_.fire_delay, unit(BoardDraw::kDelay));
}

std::uint64_t RingBoardCore::BoardBits(BoardDraw purpose) const {
  return MixSeed(seed_, static_cast<std::uint64_t>(purpose));
}

std::uint64_t RingBoardCore::LevelBits(std::uint32_t sequence, BoardDraw purpose) const {
  const std::uint64_t level = static_cast<std::uint64_t>(runs_) << 32 | sequence;
  return MixSeed(BoardBits(purpose), level);
}

nanoseconds RingBoardCore::DeviceTime(nanoseconds time) const {
  const nanoseconds drift(std::llround(static_cast<double>(time.count()) * clock_drift_));
  return faults_.ClockOf(clock_offset_ + time + drift, time);
}

nanoseconds RingBoardCore::FireTime(std::uint32_t sequence, nanoseconds edge) const {
  return edge + fire_delay_ + ShareOf(options_.fire_jitter, UnitFromBits(LevelBits(sequence, BoardDraw::kFire)));
}

nanoseconds RingBoardCore::ReadyTime(std::uint32_t sequence, nanoseconds fire, double period_ns) const {
  const double late_ns = faults_.Value(BoardFaultKind::kLate, fire).value_or(0.0) * period_ns;
  return fire + nanoseconds(std::llround(late_ns)) + options_.frame_delay +
         ShareOf(options_.frame_jitter, UnitFromBits(LevelBits(sequence, BoardDraw::kArrival)));
}

BeamReading RingBoardCore::LookFromWall(std::size_t channel, nanoseconds time, std::mt19937_64& random) const {
  const auto& sensors = options_.reference;
  const auto sensor =
      std::find_if(sensors.begin(), sensors.end(), [&](const ReferenceSensor& one) { return one.channel == channel; });
  if (sensor == sensors.end()) return {std::numeric_limits<double>::quiet_NaN(), 0};
  const double time_s = static_cast<double>(time.count()) * 1e-9;
  const BeamReading seen = world_.beam.Measure(world_.subject, RayOf(*sensor), time_s, world_.max_range_mm, random);
  const double to_ring_mm = sensor->distance_mm - world_.ring.sensors.front().radius_mm - kRingWallMm;
  const bool hidden = std::abs(world_.axis.TrueZ(time) - sensor->height_mm) < kRingHalfHeightMm;
  return hidden && to_ring_mm > 0.0 ? BeamReading{to_ring_mm, 255} : seen;
}

BeamReading RingBoardCore::Look(std::size_t sensor, nanoseconds time, std::mt19937_64& random) const {
  if (!options_.reference.empty()) return LookFromWall(sensor - options_.first_sensor, time, random);
  const Ray ray = world_.ring.RayOf(sensor, world_.axis.TrueZ(time));
  const double time_s = static_cast<double>(time.count()) * 1e-9;
  return world_.beam.Measure(world_.subject, ray, time_s, world_.max_range_mm, random);
}

LevelFrame RingBoardCore::Measure(std::uint32_t sequence, nanoseconds fire) const {
  constexpr BeamReading kStuckInTheAir{500.0, 128};
  std::mt19937_64 random(LevelBits(sequence, BoardDraw::kBeam));
  LevelFrame frame;
  frame.board_serial = options_.serial;
  frame.sequence = sequence;
  frame.device_time = DeviceTime(fire);
  // Boards of one ring differ by up to a degree to either side.
  frame.temperature_centi_c = static_cast<std::int16_t>(std::lround(100.0 * options_.temperature_c) - 100 +
                                                        static_cast<long>(BoardBits(BoardDraw::kTemperature) % 200));
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    const std::size_t sensor = faults_.WiredTo(i, fire).value_or(options_.first_sensor + i);
    BeamReading reading = Look(sensor, fire, random);
    if (const auto stuck = faults_.StuckSince(i, fire)) {
      std::mt19937_64 then(MixSeed(BoardBits(BoardDraw::kStuck), sensor));
      reading = Look(sensor, *stuck, then);
      if (std::isnan(reading.range_mm)) reading = kStuckInTheAir;
    }
    // The sensor's own zero and scale are what calibration takes out again (RingCalibration::PointOf).
    const bool of_ring = options_.reference.empty();
    const double raw_mm = of_ring ? world_.ring.sensors[sensor].ReadingOf(reading.range_mm) : reading.range_mm;
    const double raw_um = std::round(raw_mm * 1000.0);
    const bool returned = raw_um >= 0.0 && raw_um < static_cast<double>(kNoReturn);
    frame.range_um[i] = returned ? static_cast<std::uint32_t>(raw_um) : kNoReturn;
    frame.quality[i] = returned ? reading.quality : std::uint8_t{0};
  }
  faults_.Spoil(frame, fire, LevelBits(sequence, BoardDraw::kFault));
  return frame;
}

}  // namespace annulus::sim
