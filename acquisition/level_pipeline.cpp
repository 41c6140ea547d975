#include "acquisition/level_pipeline.h"

#include <cmath>

namespace annulus {

Result<std::optional<std::chrono::nanoseconds>> LevelPipeline::AddPosition(const AxisPosition& position) {
  RETURN_IF_ERROR(stamper_.AddPosition(position));
  if (!collecting_) return std::nullopt;
  return stamper_.HostTime(position);
}

void LevelPipeline::BeginSweep(std::uint32_t sweep) {
  collecting_ = true;
  sweep_ = sweep;
  last_index_ = -1;
  sweep_levels_ = 0;
  passed_end_ = false;
  deviation_sum_ = 0.0;
}

void LevelPipeline::EndSweep() {
  collecting_ = false;
  stamper_.Drop();
}

Status LevelPipeline::AddLevel(RingLevel level) { return collecting_ ? stamper_.AddLevel(std::move(level)) : Status{}; }

std::vector<ScanLevel> LevelPipeline::Take() {
  std::vector<ScanLevel> wanted;
  for (ScanLevel& level : stamper_.Take()) {
    if (Place(level)) wanted.push_back(std::move(level));
  }
  return wanted;
}

bool LevelPipeline::Place(ScanLevel& level) {
  std::int64_t index = last_index_ + 1;
  if (plan_.parked()) {
    if (index >= plan_.TotalLevels()) return false;
  } else {
    // The nearest planned level, counted in the sweep's direction.
    const double height = MeanHeight(level);
    const std::int64_t last = plan_.SweepLevels(sweep_) - 1;
    const std::int64_t from_top = std::llround((plan_.SweepTop(sweep_) - height) / plan_.sweep_pitch_mm());
    index = sweep_ % 2 == 0 ? from_top : last - from_top;
    if (index > last) passed_end_ = true;
    if (index <= last_index_ || index > last) return false;
    deviation_sum_ += height - (plan_.SweepTop(sweep_) - static_cast<double>(from_top) * plan_.sweep_pitch_mm());
  }
  last_index_ = index;
  level.index = static_cast<std::uint32_t>(index);
  level.sweep = static_cast<std::uint16_t>(sweep_);
  ++sweep_levels_;
  return true;
}

double LevelPipeline::mean_deviation_mm() const {
  return sweep_levels_ == 0 ? 0.0 : deviation_sum_ / static_cast<double>(sweep_levels_);
}

}  // namespace annulus
