#include "sim/board_faults.h"

#include <algorithm>
#include <cmath>

#include "sim/world.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using Kind = BoardFaultKind;

constexpr std::int64_t kWrapNs = (std::int64_t{1} << 32) * 1000;
constexpr double kLeastSpike = 0.2;  ///< Of the size.

nanoseconds Seconds(double seconds) { return nanoseconds(std::llround(seconds * 1e9)); }

/// Adds to a range, which is lost if nothing sensible comes out.
void Shift(LevelFrame& level, std::size_t sensor, double by_mm) {
  if (level.range_um[sensor] == kNoReturn) return;
  const double um = std::round(static_cast<double>(level.range_um[sensor]) + 1000.0 * by_mm);
  const bool fits = um >= 0.0 && um < static_cast<double>(kNoReturn);
  level.range_um[sensor] = fits ? static_cast<std::uint32_t>(um) : kNoReturn;
  if (!fits) level.quality[sensor] = 0;
}

void SpoilSensor(const BoardFault& fault, LevelFrame& level, std::size_t sensor, nanoseconds fire, std::uint64_t bits) {
  const bool hit = UnitFromBits(bits) < fault.value;
  switch (fault.kind) {
    case Kind::kNoReturn:
    case Kind::kDead:
      if (fault.kind == Kind::kNoReturn && !hit) return;
      level.range_um[sensor] = kNoReturn;
      level.quality[sensor] = 0;
      return;
    case Kind::kSpikes: {
      const double place = 2.0 * UnitFromBits(MixSeed(bits, 1)) - 1.0;
      const double share = std::copysign(kLeastSpike + (1.0 - kLeastSpike) * std::abs(place), place);
      if (hit) Shift(level, sensor, share * fault.size_mm);
      return;
    }
    case Kind::kDrift:
      return Shift(level, sensor,
                   fault.value * std::chrono::duration<double>(std::min(fire, fault.to) - fault.from).count());
    default:
      return;
  }
}

}  // namespace

std::size_t BoardFaults::Add(const BoardFault& fault) {
  faults_.push_back(fault);
  return faults_.size() - 1;
}

nanoseconds BoardFaults::ClockOf(nanoseconds honest, nanoseconds time) const {
  nanoseconds shown = honest;
  for (const BoardFault& fault : faults_) {
    if (time < fault.from) continue;
    if (fault.kind == Kind::kClockStuck) shown -= std::min(time, fault.to) - fault.from;
    if (fault.kind == Kind::kClockJump) shown += Seconds(fault.value);
    if (fault.kind == Kind::kClockWrap) {
      const nanoseconds wraps = shown - time + fault.from + Seconds(fault.value);
      shown += nanoseconds(kWrapNs - wraps.count() % kWrapNs);
    }
  }
  return std::max(shown, nanoseconds(0));
}

std::optional<nanoseconds> BoardFaults::StuckSince(std::size_t sensor, nanoseconds fire) const {
  for (const BoardFault& fault : faults_) {
    if (fault.kind == Kind::kStuck && fault.Holds(fire) && fault.Meets(sensor)) return fault.from;
  }
  return std::nullopt;
}

std::optional<std::size_t> BoardFaults::WiredTo(std::size_t channel, nanoseconds fire) const {
  for (const BoardFault& fault : faults_) {
    if (fault.kind == Kind::kWiring && fault.Holds(fire) && fault.Meets(channel)) {
      return static_cast<std::size_t>(fault.value) + channel - fault.first_sensor;
    }
  }
  return std::nullopt;
}

void BoardFaults::Spoil(LevelFrame& level, nanoseconds fire, std::uint64_t bits) const {
  for (std::size_t number = 0; number < faults_.size(); ++number) {
    const BoardFault& fault = faults_[number];
    const bool stays = fault.kind == Kind::kDrift && fire >= fault.from;
    if (!fault.Holds(fire) && !stays) continue;
    if (fault.kind == Kind::kSerial) level.board_serial = static_cast<std::uint32_t>(fault.value);
    if (fault.kind == Kind::kEmitterFault) level.status |= kFrameEmitterFault;
    for (std::size_t sensor = 0; sensor < kSensorsPerBoard; ++sensor) {
      if (fault.Meets(sensor)) SpoilSensor(fault, level, sensor, fire, MixSeed(MixSeed(bits, number), sensor));
    }
  }
}

std::optional<double> BoardFaults::Value(BoardFaultKind kind, nanoseconds time) const {
  const auto found = std::find_if(faults_.rbegin(), faults_.rend(),
                                  [&](const BoardFault& fault) { return fault.kind == kind && fault.Holds(time); });
  if (found == faults_.rend()) return std::nullopt;
  return found->value;
}

}  // namespace annulus::sim
