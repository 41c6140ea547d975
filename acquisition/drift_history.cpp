#include "acquisition/drift_history.h"

#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

constexpr std::uint64_t kMostBytes = std::uint64_t{64} << 20;

/// As it stands in the file.
double Rounded(double number) {
  constexpr double kUnit = 1e4;
  constexpr double kLargest = 1e4;  // mm; an offset that large is none
  if (!(std::abs(number) <= kLargest)) return std::numeric_limits<double>::quiet_NaN();
  return std::round(number * kUnit) / kUnit;
}
/// An sd is never rounded to nothing.
double RoundedUp(double sigma) { return std::max(Rounded(sigma), sigma >= 0.0 ? 1e-4 : sigma); }

DriftRecord RecordOf(const DriftEstimate& estimate, std::optional<double> temperature) {
  DriftRecord record;
  record.scan_hash = estimate.scan_hash;
  record.calibration = estimate.calibration;
  record.wall_start_ns = estimate.wall_start_ns;
  record.temperature = temperature;
  record.duration_s = Rounded(estimate.duration_s);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (const SensorDrift& sensor : estimate.sensors) {
    const bool known = sensor.known();
    const bool has_trend = known && std::isfinite(sensor.trend_mm_s) && std::isfinite(sensor.trend_sigma_mm_s);
    record.offset_mm.push_back(known ? Rounded(sensor.offset_mm) : kNone);
    record.sigma_mm.push_back(known ? RoundedUp(sensor.sigma_mm) : kNone);
    record.trend_mm_s.push_back(has_trend ? Rounded(sensor.trend_mm_s) : kNone);
    record.trend_sigma_mm_s.push_back(has_trend ? RoundedUp(sensor.trend_sigma_mm_s) : kNone);
  }
  return record;
}

}  // namespace

std::size_t DriftHistory::SinceCalibration() const {
  std::size_t first = records_.size();
  while (first > 0 && records_[first - 1].calibration == records_.back().calibration) --first;
  return first;
}

Status DriftHistory::CheckRing(const std::string& ring_serial, std::size_t sensors) const {
  if (stencils_.empty() && checks_.empty()) return {};
  const std::size_t own = stencils_.empty() ? checks_.front().sensors.size() : stencils_.size();
  if (sensors == own && ring_serial == ring_serial_) return {};
  return Fail("add a scan to the drift history of ring '" + ring_serial_ + "'",
              "it is of ring '" + ring_serial + "' with " + std::to_string(sensors) + " sensors",
              "keep one history file for each ring");
}

Result<DriftHistory::Added> DriftHistory::AddCheck(const ReferenceRecord& check) {
  RETURN_IF_ERROR(CheckRing(check.ring_serial, check.sensors.size()));
  const auto known = [&](const ReferenceRecord& old) { return old.scan_hash == check.scan_hash; };
  if (std::any_of(checks_.begin(), checks_.end(), known)) return Added::kKnown;
  ring_serial_ = check.ring_serial;
  checks_.push_back(check);
  if (checks_.size() > kMostChecks) checks_.erase(checks_.begin());
  return Added::kNew;
}

Result<DriftHistory::Added> DriftHistory::Add(const DriftEstimate& estimate, std::optional<double> temperature) {
  if (estimate.sensors.size() > kMostSensors) {
    return Fail("add a scan to a drift history", "it has " + std::to_string(estimate.sensors.size()) + " sensors",
                "give scans of a ring");
  }
  RETURN_IF_ERROR(CheckRing(estimate.ring_serial, estimate.sensors.size()));
  const auto known = [&](const DriftRecord& record) { return record.scan_hash == estimate.scan_hash; };
  if (std::any_of(records_.begin(), records_.end(), known)) return Added::kKnown;
  if (records_.empty() || records_.back().calibration != estimate.calibration) stencil_scans_ = 0;
  ring_serial_ = estimate.ring_serial;
  stencils_.resize(estimate.sensors.size());
  ++stencil_scans_;
  for (std::size_t sensor = 0; sensor < stencils_.size(); ++sensor) {
    for (std::size_t k = 0; k < kNeighbours; ++k) {
      double& mean = stencils_[sensor][k];
      const double old = stencil_scans_ == 1 ? 0.0 : mean;
      mean = Rounded(old + (estimate.sensors[sensor].neighbour_weight[k] - old) / static_cast<double>(stencil_scans_));
    }
  }
  records_.push_back(RecordOf(estimate, temperature));
  Trim();
  return Added::kNew;
}

void DriftHistory::Trim() {
  if (records_.size() <= kMostRecords) return;
  const std::size_t first = SinceCalibration();
  records_.erase(records_.begin() + static_cast<std::ptrdiff_t>(first > 0 ? 0 : kKeptFirst));
}

Result<DriftHistory> DriftHistory::Load(Storage& storage, const std::string& path) {
  if (!storage.Exists(path)) return DriftHistory();
  const auto bytes = storage.ReadAll(path, kMostBytes);
  if (!bytes) return Fail(bytes);
  return FromJson({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
}

Status DriftHistory::Save(Storage& storage, const std::string& path) const {
  return WriteFileAtomically(storage, path, ToJson());
}

}  // namespace annulus
