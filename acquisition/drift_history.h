#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/drift_watch.h"
#include "acquisition/reference_record.h"
#include "base/result.h"
#include "base/storage.h"

namespace annulus {

/// What a history keeps of one scan: DriftEstimate, rounded to 0.0001 mm.
struct DriftRecord {
  std::string scan_hash;
  std::string calibration;            ///< Certificate in force; "" for an ideal ring.
  std::int64_t wall_start_ns = 0;     ///< ns since 1970; 0 where unknown.
  std::optional<double> temperature;  ///< Of the ring, degrees Celsius, where known.
  double duration_s = 0.0;
  std::vector<double> offset_mm;         ///< By sensor; NaN: unknown. As SensorDrift.
  std::vector<double> sigma_mm;          ///< By sensor; NaN: unknown.
  std::vector<double> trend_mm_s;        ///< By sensor; NaN: unknown.
  std::vector<double> trend_sigma_mm_s;  ///< By sensor; NaN: unknown.
};

/// What scans of customers have said of one ring, scan by scan, oldest first. A value; the file is docs/formats.md,
/// "Drift history".
class DriftHistory {
 public:
  /// More are not kept: the oldest after the first kKeptFirst of the calibration in force go, older calibrations'
  /// before.
  static constexpr std::size_t kMostRecords = 1000;
  static constexpr std::size_t kKeptFirst = 40;
  static constexpr std::size_t kMostChecks = 400;  ///< More than a year of daily checks.
  static constexpr std::size_t kMostSensors = 720;

  /// Neighbours' mean weights over all scans of the calibration in force (SensorDrift::neighbour_weight), by sensor.
  using Stencils = std::vector<std::array<double, kNeighbours>>;

  enum class Added {
    kNew,
    kKnown,  ///< This scan was there already: nothing has changed.
  };
  /// Takes one scan up. Fails if it is of another ring.
  Result<Added> Add(const DriftEstimate& estimate, std::optional<double> temperature = std::nullopt);

  /// Takes a check with a reference up. Fails if it is of another ring.
  Result<Added> AddCheck(const ReferenceRecord& check);

  [[nodiscard]] const std::string& ring_serial() const { return ring_serial_; }
  [[nodiscard]] std::size_t sensors() const { return stencils_.size(); }
  [[nodiscard]] const std::vector<DriftRecord>& records() const { return records_; }
  /// Checks with a reference, oldest first.
  [[nodiscard]] const std::vector<ReferenceRecord>& checks() const { return checks_; }
  [[nodiscard]] const Stencils& stencils() const { return stencils_; }
  /// Index of the first record of the calibration in force (that of the newest record).
  [[nodiscard]] std::size_t SinceCalibration() const;

  /// The file's text: the same history, the same bytes.
  [[nodiscard]] std::string ToJson() const;
  /// Refuses what is not a history, is damaged, or is newer than this program; `name` stands in the message.
  static Result<DriftHistory> FromJson(std::string_view text, const std::string& name);

  /// A file that is not there is an empty history.
  static Result<DriftHistory> Load(Storage& storage, const std::string& path);
  /// Replaces the file atomically.
  Status Save(Storage& storage, const std::string& path) const;

 private:
  [[nodiscard]] Status CheckRing(const std::string& ring_serial, std::size_t sensors) const;
  void Trim();

  std::string ring_serial_;
  Stencils stencils_;
  std::size_t stencil_scans_ = 0;  ///< In the mean of stencils_.
  std::vector<DriftRecord> records_;
  std::vector<ReferenceRecord> checks_;
};

}  // namespace annulus
