#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/reference_sensor.h"
#include "base/ring_calibration.h"
#include "base/surface_sample.h"

namespace annulus {

/// One range reading as it was taken. Missing return: range_mm is NaN.
struct RangeReading {
  double range_mm = std::numeric_limits<double>::quiet_NaN();  ///< Raw range from the sensor's zero, mm.
  double z_mm = 0.0;                                           ///< Carriage height at the reading's time, mm.
  std::uint8_t quality = 255;                                  ///< Return quality, 0 (none) … 255 (best).
};

/// All sensors at one carriage position.
struct ScanLevel {
  std::uint32_t index = 0;  ///< Level within its sweep, 0 first taken.
  std::uint16_t sweep = 0;
  std::chrono::nanoseconds time{0};    ///< Host clock of the level's SYNC; 0 where unknown.
  std::vector<RangeReading> readings;  ///< One per sensor of the ring.
  /// One per reference sensor, as ScanHeader::reference lists them; empty without them. Their z_mm is 0: they stand
  /// still, and where is in the header.
  std::vector<RangeReading> reference{};
  std::chrono::nanoseconds reference_time{0};  ///< Host clock when they fired; 0: nothing came of them.
};

/// A board of the ring as a recording names it.
struct RecordedBoard {
  std::uint32_t serial = 0;
  std::uint16_t first_sensor = 0;  ///< Ring index of its sensor 0.
  std::uint16_t sensor_count = 0;
  std::uint16_t protocol_version = 0;
  std::string firmware_version;  ///< "major.minor.patch".

  bool operator==(const RecordedBoard&) const = default;
};

/// The sensors beside the ring, and the board that they hang on.
struct RecordedReference {
  std::uint32_t board = 0;               ///< Serial number.
  std::string firmware_version;          ///< "major.minor.patch"; "" if the board was not there.
  std::vector<ReferenceSensor> sensors;  ///< In the order of ScanLevel::reference.

  bool operator==(const RecordedReference&) const = default;
};

/// The machine that took a scan: who was connected, with which versions and limits. Empty for imported scans.
struct RecordedMachine {
  std::string ring_bus;               ///< "usb", "can", "sim"; "" where unknown.
  std::vector<RecordedBoard> boards;  ///< The map of the sensors, in the order of RangeRing::boards().
  std::uint32_t axis_serial = 0;
  std::uint16_t axis_protocol_version = 0;
  std::string axis_firmware_version;  ///< "major.minor".
  double axis_z_min_mm = 0.0;         ///< Limits of the carriage, station frame.
  double axis_z_max_mm = 0.0;
  double axis_max_speed_mm_s = 0.0;
  double axis_max_acceleration_mm_s2 = 0.0;
  double level_rate_hz = 0.0;                ///< SYNC edges per second; 0 where unknown.
  std::optional<double> ring_temperature_c;  ///< Mean of the boards before the scan, degrees Celsius; nothing: unknown.

  bool operator==(const RecordedMachine&) const = default;
};

/// What a recording says of itself before its first level.
struct ScanHeader {
  std::uint32_t format_version = 1;
  std::string station_id;  ///< "sim" for the simulated booth, "import" for imported files.
  std::string source;      ///< Free text of an imported file's header; the subject of a simulated scan.
  std::string subject_id;  ///< Pseudonym; never a name.
  std::string consent_reference;
  std::string program_version;
  double ring_radius_mm = 0.0;
  RingCalibration calibration;     ///< Full copy of what was in force; sensors.size() is the ring's sensor count.
  std::string profile;             ///< Scan profile; "" where unknown.
  std::string plan_json;           ///< The validated plan as JSON; "" where unknown.
  std::uint64_t seed = 0;          ///< Of a simulated scan.
  std::int64_t wall_start_ns = 0;  ///< Wall clock of the start, ns since 1970; 0 where unknown.
  RecordedMachine machine;
  std::optional<RecordedReference> reference{};  ///< Nothing: there were none.
};

/// A whole scan in memory: what a recording holds, what import makes and export writes.
struct Scan {
  ScanHeader header;
  std::vector<ScanLevel> levels;  ///< In the order they were taken.
};

/// The calibrated points of every return of a scan (SampleBuilder): paper 001, eq. 2.1 for an ideal ring.
/// Readings that are not finite, beyond the axis or not positive are left out. The weight is the return quality,
/// lowered where the scan itself shows that a reading is doubtful (QualityWeights; 0: not to be used).
[[nodiscard]] std::vector<SurfaceSample> BuildSamples(const Scan& scan);

/// "sha256:" + hex of ring geometry and readings (not of file bytes): the identity of what was measured.
[[nodiscard]] std::string ScanHash(const Scan& scan);

}  // namespace annulus
