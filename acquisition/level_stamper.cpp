#include "acquisition/level_stamper.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/ensure.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// A stamp may lie this far in the future by the clocks' own errors.
constexpr nanoseconds kFutureAllowance = std::chrono::milliseconds(1);
constexpr nanoseconds kOldest = std::chrono::seconds(1);

/// Whether a level can have been so old when it arrived.
bool IsPossible(nanoseconds age) { return age >= -kFutureAllowance && age <= kOldest; }

}  // namespace

Status LevelStamper::AddBoardClock(std::size_t board, const ClockExchange& exchange) {
  if (board == board_clocks_.size()) {
    if (reference_clock_ && !reference_clock_->Add(exchange)) reference_clock_.reset();
    return {};
  }
  Status added = board_clocks_[board].Add(exchange);
  if (added) return added;
  return Fail(added.error().attempted,
              "ring board " + std::to_string(boards_[board].serial) + ": " + added.error().seen, added.error().advice);
}

Status LevelStamper::AddPosition(const AxisPosition& position) {
  ENSURE(position.fresh, "only fresh positions count");
  if (Status added = drive_clock_.Add(position.time); !added) {
    return Fail(added.error().attempted, "axis drive: " + added.error().seen, added.error().advice);
  }
  track_.Add(position.time.device_time, position.z.value());
  return {};
}

Status LevelStamper::AddLevel(RingLevel level) {
  for (std::size_t board = 0; board < level.boards.size(); ++board) {
    const BoardStamp& stamp = level.boards[board];
    if (!stamp.present) continue;
    const nanoseconds age = stamp.host_arrival - HostTime(board, stamp.device_time);
    if (!IsPossible(age)) {
      return Fail("place level " + std::to_string(level.sequence) + " of the ring in time",
                  "ring board " + std::to_string(boards_[board].serial) + " stamps it " +
                      std::to_string(age.count() / 1000) + " us before its arrival",
                  "power-cycle the ring; replace the board if this comes back");
    }
  }
  waiting_.push_back(std::move(level));
  return {};
}

bool LevelStamper::Passed(const RingLevel& level) const {
  if (track_.empty()) return false;
  for (std::size_t board = 0; board < level.boards.size(); ++board) {
    const BoardStamp& stamp = level.boards[board];
    if (stamp.present && drive_clock_.DeviceTime(HostTime(board, stamp.device_time)) > track_.newest_time())
      return false;
  }
  return true;
}

std::vector<ScanLevel> LevelStamper::Take() {
  std::vector<ScanLevel> stamped;
  for (; !waiting_.empty() && Passed(waiting_.front()); waiting_.pop_front()) {
    ScanLevel level = Stamp(waiting_.front());
    if (!level.readings.empty()) stamped.push_back(std::move(level));
  }
  return stamped;
}

ScanLevel LevelStamper::Stamp(const RingLevel& raw) const {
  ScanLevel level;
  std::vector<std::optional<double>> heights(raw.boards.size());
  double sum = 0.0;
  int known = 0;
  for (std::size_t board = 0; board < raw.boards.size(); ++board) {
    const BoardStamp& stamp = raw.boards[board];
    if (!stamp.present) continue;
    const nanoseconds time = HostTime(board, stamp.device_time);
    heights[board] = track_.At(drive_clock_.DeviceTime(time));
    if (!heights[board]) continue;
    level.time = known == 0 ? time : std::min(level.time, time);
    sum += *heights[board];
    ++known;
  }
  if (known == 0) return level;
  level.readings.resize(raw.range_mm.size());
  for (std::size_t board = 0; board < boards_.size(); ++board) {
    for (std::size_t i = 0; i < boards_[board].sensor_count; ++i) {
      const std::size_t sensor = boards_[board].first_sensor + i;
      RangeReading& reading = level.readings[sensor];
      reading.z_mm = heights[board].value_or(sum / known);
      if (!heights[board]) continue;
      reading.range_mm = raw.range_mm[sensor];
      reading.quality = raw.quality[sensor];
    }
  }
  for (RangeReading& reading : level.readings) {
    if (reading.range_mm != reading.range_mm) reading.quality = 0;
  }
  StampReference(raw, level);
  return level;
}

void LevelStamper::StampReference(const RingLevel& raw, ScanLevel& level) const {
  level.reference.assign(raw.reference_range_mm.size(), {std::numeric_limits<double>::quiet_NaN(), 0.0, 0});
  if (!raw.reference.present || !reference_clock_ || !reference_clock_->ready()) return;
  const nanoseconds time = reference_clock_->HostTime(raw.reference.device_time);
  if (!IsPossible(raw.reference.host_arrival - time)) return;
  level.reference_time = time;
  for (std::size_t i = 0; i < level.reference.size(); ++i) {
    level.reference[i].range_mm = raw.reference_range_mm[i];
    level.reference[i].quality = raw.reference_quality[i];
  }
}

double LevelStamper::WorstBound() const {
  double worst = drive_clock_.bound_us();
  for (const ClockSync& clock : board_clocks_) worst = std::max(worst, clock.bound_us());
  return worst;
}

double MeanHeight(const ScanLevel& level) {
  ENSURE(!level.readings.empty(), "a level has readings");
  double sum = 0.0;
  for (const RangeReading& reading : level.readings) sum += reading.z_mm;
  return sum / static_cast<double>(level.readings.size());
}

}  // namespace annulus
